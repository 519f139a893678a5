//! Surfaces: how exactly they are found, and how they are lit. Twin of `shaders/shared/surface.inc.wgsl`.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// Halvings of the step in which a ray crosses a surface: the crossing of the interpolated field is found to 2^-11 of a
/// step (2^-10 is left, its middle is taken).
pub const HALVINGS: u32 = 10;

/// Where the light comes from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Light {
    /// From the eye, along each ray.
    Headlight,
    /// From far away in this direction of the volume's own axes; of any length but zero.
    From([f64; 3]),
}

/// The parameters of Blinn and Phong's model: `ambient + diffuse * N.L`, times the colour, and `specular *
/// (N.H)^shininess` of white, with H halfway between the light and the eye.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Lighting {
    /// Where the light comes from.
    pub light: Light,
    /// Ka, not below 0.
    pub ambient: f64,
    /// Kd, not below 0.
    pub diffuse: f64,
    /// Ks, not below 0.
    pub specular: f64,
    /// The exponent, 1 to 1,000.
    pub shininess: f64,
}

impl Default for Lighting {
    fn default() -> Self {
        Self {
            light: Light::Headlight,
            ambient: 0.15,
            diffuse: 0.75,
            specular: 0.25,
            shininess: 32.0,
        }
    }
}

impl Lighting {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::Setting`] that names the one that is out of range.
    pub fn check(&self) -> Result<()> {
        if let Light::From(direction) = self.light {
            if !direction.iter().all(|c| c.is_finite()) {
                return Err(Error::setting(
                    "light",
                    "its direction must be finite numbers",
                ));
            }
            if length(direction) == 0.0 {
                return Err(Error::setting("light", "its direction has no length"));
            }
        }
        for (name, k) in [
            ("ka", self.ambient),
            ("kd", self.diffuse),
            ("ks", self.specular),
        ] {
            if !(0.0..=1000.0).contains(&k) {
                return Err(Error::setting(name, "must lie between 0 and 1000"));
            }
        }
        if !(1.0..=1000.0).contains(&self.shininess) {
            return Err(Error::setting("shininess", "must lie between 1 and 1000"));
        }
        Ok(())
    }

    /// What a surface of normal `normal` sends to the eye of light that is as bright as 1: the factor of its colour, and
    /// the highlight. Both directions have unit length.
    pub fn reflected(&self, normal: [f64; 3], to_eye: [f64; 3]) -> [f64; 2] {
        let light = match self.light {
            Light::Headlight => to_eye,
            Light::From(direction) => unit(direction),
        };
        let between = [
            light[0] + to_eye[0],
            light[1] + to_eye[1],
            light[2] + to_eye[2],
        ];
        // Light from straight behind has no direction halfway.
        let between = between.map(|c| c / length(between).max(1e-6));
        let gloss = dot(normal, between).max(1e-4).powf(self.shininess);
        [
            self.ambient + self.diffuse * dot(normal, light).max(0.0),
            self.specular * gloss,
        ]
    }
}

/// The normal of matter that grows along `gradient` (data values per length): towards less. Where the gradient is no
/// longer than `least`, it has no direction to speak of.
pub fn normal(gradient: [f64; 3], least: f64) -> Option<[f64; 3]> {
    let length = length(gradient);
    (length > least).then(|| gradient.map(|c| -c / length))
}

/// The vector of length 1 in the direction of `v`, which has a length.
pub fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = length(v);
    v.map(|c| c / length)
}

/// Scalar product.
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn length(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_falls_off_with_the_angle_and_shines_where_it_is_mirrored() {
        let lighting = Lighting {
            light: Light::From([0.0, 0.0, 2.0]),
            ambient: 0.1,
            diffuse: 0.5,
            specular: 0.4,
            shininess: 10.0,
        };
        let up = [0.0, 0.0, 1.0];
        let [color, gloss] = lighting.reflected(up, up);
        assert!((color - 0.6).abs() < 1e-12 && (gloss - 0.4).abs() < 1e-12);
        // From the side: no light, no highlight.
        let [color, gloss] = lighting.reflected([1.0, 0.0, 0.0], up);
        assert!((color - 0.1).abs() < 1e-12 && gloss < 1e-12);
        // The mirror direction of light that comes down is at twice the normal's angle.
        let normal = unit([1.0, 0.0, 1.0]);
        let [color, gloss] = lighting.reflected(normal, [1.0, 0.0, 0.0]);
        assert!((color - 0.1 - 0.5 * 0.5_f64.sqrt()).abs() < 1e-12);
        assert!((gloss - 0.4).abs() < 1e-12);
        // From straight behind nothing is halfway: no number, however small, is divided by zero.
        assert!(lighting.reflected(up, [0.0, 0.0, -1.0])[1].is_finite());
    }
}
