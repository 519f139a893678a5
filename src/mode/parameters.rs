//! A mode's parameters as marchers read them.

use super::surface::{Light, Lighting};
use super::{Mode, Window};
use crate::transfer::Domain;

/// The numbers of a mode in table coordinates; those that it does not read are zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Table coordinate at which brightness is 0.
    pub window_low: f64,
    /// Brightness per table coordinate; negative where it falls.
    pub window_scale: f64,
    /// Brightness up to which a sample counts as 0: two [`Domain::snap`]s, so that a background at the window's end stays
    /// invisible however samples are rounded.
    pub window_dead: f64,
    /// Table coordinate of the (inner) surface.
    pub iso: f64,
    /// Table coordinate of the outer surface.
    pub outer_iso: f64,
    /// 1 where data values rise with table coordinates, -1 where they fall.
    pub direction: f64,
    /// Step in voxels of the smallest spacing: what opacities per voxel are raised to.
    pub opacity_ratio: f64,
    /// Linear colour of the (inner) surface.
    pub color: [f64; 3],
    /// Linear colour and opacity of the outer surface, not premultiplied.
    pub outer_color: [f64; 4],
    /// How surfaces are lit.
    pub lighting: Lighting,
    /// Length of a gradient (table coordinates per two voxels) up to which it has no direction to speak of: four snaps.
    pub least_gradient: f64,
}

impl Parameters {
    /// The parameters of `mode` over values in `domain`, with samples `step_voxels` apart.
    pub fn new(mode: &Mode, domain: &Domain, step_voxels: f64) -> Self {
        let dark = Lighting {
            light: Light::Headlight,
            ambient: 0.0,
            diffuse: 0.0,
            specular: 0.0,
            shininess: 1.0,
        };
        let unread = Self {
            window_low: 0.0,
            window_scale: 0.0,
            window_dead: 0.0,
            iso: 0.0,
            outer_iso: 0.0,
            direction: domain.direction(),
            opacity_ratio: step_voxels,
            color: [0.0; 3],
            outer_color: [0.0; 4],
            lighting: dark,
            least_gradient: 4.0 * domain.snap(),
        };
        let between = |low: f64, high: f64| {
            let [low, high] = [low, high].map(|value| domain.x_from_value(value));
            let scale = 1.0 / (high - low);
            Self {
                window_low: low,
                window_scale: scale,
                window_dead: 2.0 * domain.snap() * scale.abs(),
                ..unread
            }
        };
        match *mode {
            Mode::EmissionAbsorption => unread,
            Mode::Shaded(lighting) => Self { lighting, ..unread },
            Mode::Grey(Window { low, high })
            | Mode::Mip(Window { low, high })
            | Mode::Mean(Window { low, high }) => between(low, high),
            // How far below the upper end: the highest of that is the lowest value.
            Mode::Minip(Window { low, high }) => between(high, low),
            Mode::Normals { iso } => Self {
                iso: domain.x_from_value(iso),
                ..unread
            },
            Mode::Phong {
                iso,
                color,
                lighting,
            } => Self {
                iso: domain.x_from_value(iso),
                color,
                lighting,
                ..unread
            },
            Mode::TwoSurfaces {
                outer,
                iso,
                color,
                lighting,
            } => {
                let [r, g, b] = outer.color;
                Self {
                    iso: domain.x_from_value(iso),
                    outer_iso: domain.x_from_value(outer.iso),
                    color,
                    outer_color: [r, g, b, outer.opacity],
                    lighting,
                    ..unread
                }
            }
        }
    }

    /// Where a table coordinate lies in the window, 0 to 1; exactly 0 up to a hair above its lower end.
    pub fn in_window(&self, x: f64) -> f64 {
        let v = (x - self.window_low) * self.window_scale;
        if v <= self.window_dead {
            0.0
        } else {
            v.min(1.0)
        }
    }

    /// Whether matter at table coordinate `x` lies inside the surface at `iso`.
    pub fn is_inside(&self, x: f64, iso: f64) -> bool {
        (x - iso) * self.direction >= 0.0
    }
}
