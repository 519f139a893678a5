//! What each mode does with a sample, in f64: the twins of `shaders/mode/` and `shaders/shared/surface.inc.wgsl`.

use super::Classes;
use super::march::Marcher;
use crate::lattice::Ray;
use crate::mode::surface::{self, HALVINGS};
use crate::mode::{Mode, emission_absorption};

impl<V: Copy + Into<f64>, C: Classes> Marcher<'_, V, C> {
    /// Takes sample `k`, of table coordinate `x`; whether it contributed.
    pub(super) fn add(&self, state: &mut [f64; 4], x: f64, k: f64, ray: &Ray<f64>) -> bool {
        let p = &self.parameters;
        match self.mode {
            Mode::EmissionAbsorption => {
                let color = self.color(x, k, ray);
                accumulate(state, self.cued(color, k, ray))
            }
            Mode::Shaded(_) => {
                let color = self.color(x, k, ray);
                let lit = || self.shaded(color, ray.at(k), ray);
                color != [0.0; 4] && accumulate(state, self.cued(lit(), k, ray))
            }
            Mode::Grey(_) => {
                let v = p.in_window(x);
                let opacity = if v >= 1.0 {
                    1.0
                } else {
                    -f64::exp_m1(p.opacity_ratio * f64::ln_1p(-v))
                };
                let grey = v * opacity;
                accumulate(state, self.cued([grey, grey, grey, opacity], k, ray))
            }
            Mode::Mip(_) | Mode::Minip(_) => {
                let v = p.in_window(x);
                let is_more = state[0] < v;
                state[0] = state[0].max(v);
                is_more
            }
            Mode::Mean(_) => {
                let v = p.in_window(x);
                state[0] += v;
                v > 0.0
            }
            Mode::Normals { .. } => {
                let is_hit = p.is_inside(x, p.iso);
                if is_hit {
                    let normal = self.surface_normal(ray, k, self.to_eye(ray));
                    let [r, g, b] = normal.map(|c| 0.5 + 0.5 * c);
                    *state = [r, g, b, 1.0];
                }
                is_hit
            }
            Mode::Phong { .. } => {
                let is_hit = p.is_inside(x, p.iso);
                if is_hit {
                    let [r, g, b] = self.lit_surface(ray, k);
                    *state = [r, g, b, 1.0];
                }
                is_hit
            }
            Mode::TwoSurfaces { .. } => {
                let meets_outer = state[3] == 0.0 && p.is_inside(x, p.outer_iso);
                if meets_outer {
                    let [r, g, b, opacity] = self.cued_surface(p.outer_color, ray, k, p.outer_iso);
                    *state = [r * opacity, g * opacity, b * opacity, opacity];
                }
                let meets_inner = state[3] < 1.0 && p.is_inside(x, p.iso);
                if meets_inner {
                    let [r, g, b] = self.lit_surface(ray, k);
                    accumulate(state, [r, g, b, 1.0]);
                }
                meets_outer || meets_inner
            }
        }
    }

    /// Whether the rest of the ray can be left out.
    pub(super) fn is_done(&self, state: &[f64; 4]) -> bool {
        match self.mode {
            Mode::EmissionAbsorption | Mode::Shaded(_) | Mode::Grey(_) => {
                self.ert_threshold <= state[3]
            }
            Mode::Mip(_) | Mode::Minip(_) => state[0] >= 1.0,
            Mode::Mean(_) => false,
            Mode::Normals { .. } | Mode::Phong { .. } | Mode::TwoSurfaces { .. } => state[3] >= 1.0,
        }
    }

    /// The pixel of a ray.
    pub(super) fn finish(&self, state: [f64; 4], ray: &Ray<f64>) -> [f64; 4] {
        match self.mode {
            Mode::Mip(_) => [state[0]; 4],
            Mode::Minip(_) => [0.0, 0.0, 0.0, state[0]],
            Mode::Mean(_) => [state[0] / (ray.k_end - ray.k_near).max(1.0); 4],
            _ => state,
        }
    }

    /// A sample's premultiplied colour in the light of the gradient around it, if there is one.
    fn shaded(&self, color: [f64; 4], at: [f64; 3], ray: &Ray<f64>) -> [f64; 4] {
        let Some(normal) = surface::normal(self.gradient(at), self.parameters.least_gradient)
        else {
            return color;
        };
        let to_eye = self.to_eye(ray);
        // Walls are seen from both sides.
        let normal = if surface::dot(normal, to_eye) < 0.0 {
            normal.map(|c| -c)
        } else {
            normal
        };
        let [diffuse, gloss] = self.parameters.lighting.reflected(normal, to_eye);
        let lit = |c: f64| c * diffuse + color[3] * gloss;
        [lit(color[0]), lit(color[1]), lit(color[2]), color[3]]
    }

    /// The (inner) surface's colour, lit, where the ray comes to it before sample `k`.
    fn lit_surface(&self, ray: &Ray<f64>, k: f64) -> [f64; 3] {
        let to_eye = self.to_eye(ray);
        let normal = self.surface_normal(ray, k, to_eye);
        let p = &self.parameters;
        let [diffuse, gloss] = p.lighting.reflected(normal, to_eye);
        let [r, g, b] = p.color.map(|c| c * diffuse + gloss);
        let [r, g, b, _] = self.cued_surface([r, g, b, 1.0], ray, k, p.iso);
        [r, g, b]
    }

    /// The colour of the surface at `iso` as the depth leaves it at which the ray meets it before sample `k`.
    fn cued_surface(&self, color: [f64; 4], ray: &Ray<f64>, k: f64, iso: f64) -> [f64; 4] {
        if self.cue.strength == 0.0 {
            return color;
        }
        self.cued(color, self.meets(ray, k, iso), ray)
    }

    /// A colour at sample `k`, or between samples, as the depth leaves it.
    fn cued(&self, color: [f64; 4], k: f64, ray: &Ray<f64>) -> [f64; 4] {
        if self.cue.strength == 0.0 {
            return color;
        }
        // Depth per local unit along the ray.
        let slope: f64 = (0..3)
            .map(|a| ray.delta[a] / self.grid_from_local[a] * self.forward[a])
            .sum::<f64>()
            / self.step;
        let light = self.cue.light((ray.t_box + (k + 0.5) * self.step) * slope);
        let [r, g, b, opacity] = color;
        [r * light, g * light, b * light, opacity]
    }

    /// Where the ray meets the surface at `iso` before sample `k`, as an index between samples: at the first sample where it
    /// begins inside.
    fn meets(&self, ray: &Ray<f64>, k: f64, iso: f64) -> f64 {
        if k <= ray.k_near {
            return k;
        }
        let p = &self.parameters;
        let (mut inside, mut outside) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            if p.is_inside(self.sample(ray.at(k - middle)), iso) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        k - 0.5 * (inside + outside)
    }

    /// The normal of the (inner) surface where the ray comes to it before sample `k`: towards less. Towards the eye where
    /// the data have no gradient, and where the ray begins inside: there it meets no surface but a cut.
    fn surface_normal(&self, ray: &Ray<f64>, k: f64, to_eye: [f64; 3]) -> [f64; 3] {
        if k <= ray.k_near {
            return to_eye;
        }
        let gradient = self.gradient(ray.at(self.meets(ray, k, self.parameters.iso)));
        surface::normal(gradient, self.parameters.least_gradient).unwrap_or(to_eye)
    }

    /// Central differences over two voxels, per local unit, of data values (in units of the table).
    fn gradient(&self, at: [f64; 3]) -> [f64; 3] {
        let differences = self.differences(at);
        std::array::from_fn(|axis| {
            differences[axis] * self.grid_from_local[axis] * self.parameters.direction
        })
    }

    /// The unit direction from a ray's samples to its eye.
    fn to_eye(&self, ray: &Ray<f64>) -> [f64; 3] {
        surface::unit(std::array::from_fn(|a| {
            -ray.delta[a] / self.grid_from_local[a]
        }))
    }
}

/// Adds a premultiplied colour behind those so far; whether that is any.
fn accumulate(state: &mut [f64; 4], color: [f64; 4]) -> bool {
    let mut sum = emission_absorption::State { rgba: *state };
    sum.add(color);
    *state = sum.rgba;
    color != [0.0; 4]
}
