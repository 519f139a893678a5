//! How far off a picture can be, without its truth.
//!
//! **Early termination.** Front to back, a ray's colour is `C = sum_i T_i c_i` with the premultiplied colour `c_i = a_i e_i` of
//! sample i, its opacity `a_i`, its radiance `e_i`, and the transmittance `T_i = prod_(j<i) (1 - a_j)` before it. A ray that
//! stops before sample n, where its opacity `1 - T_n` has reached the threshold t, leaves out
//! `R = sum_(i>=n) T_i a_i e_i`. With `e_i <= L` and `T_i a_i = T_i - T_(i+1)` the sum telescopes:
//! `0 <= R <= L (T_n - T_end) <= L T_n <= (1 - t) L`. The opacity itself lacks `T_n - T_end <= 1 - t`.
//! `L` is the largest channel of any control point: between points colours are mixed, so that none is larger, and light
//! multiplies it by at most what a surface can send. This holds for the real numbers; rounding comes on top.
//!
//! **Step.** Let f be the picture at a step of 0. Where the error falls at least in proportion to the step h, that is
//! `|f(h/2) - f| <= |f(h) - f| / 2`, then `|f(h) - f| <= |f(h) - f(h/2)| + |f(h/2) - f|` gives
//! `|f(h) - f| <= 2 |f(h) - f(h/2)|`. So twice what half the step changes is an estimate from above, of the pixels of a small
//! picture, and no proof: steps that miss a feature altogether do not see what they miss.

use serde::Serialize;

use super::metrics::metrics;
use crate::error::Result;
use crate::mode::Mode;
use crate::render::{Renderer, Settings, SliceCount};
use crate::transfer::TransferFunction;

/// What early termination can leave out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ErtBound {
    /// The transmittance that is left at most, `1 - threshold`.
    pub remaining: f64,
    /// The largest radiance of any sample in any channel, at least 1: opacity's.
    pub radiance: f64,
    /// No channel of any pixel is off by more.
    pub error: f64,
}

/// The bound on what early termination leaves out, in modes that composite; the others stop only where nothing can follow.
pub fn ert_bound(transfer: &TransferFunction, settings: &Settings) -> Option<ErtBound> {
    let of_points = || {
        let channels = transfer.points().iter().flat_map(|p| p.color);
        channels.fold(0.0, f64::max)
    };
    let radiance = match settings.mode {
        Mode::EmissionAbsorption => of_points(),
        Mode::Shaded(light) => of_points() * (light.ambient + light.diffuse) + light.specular,
        Mode::Grey(_) => 1.0,
        _ => return None,
    };
    let radiance = radiance.max(1.0);
    let remaining = (1.0 - f64::from(settings.ert)).max(0.0);
    Some(ErtBound {
        remaining,
        radiance,
        error: remaining * radiance,
    })
}

/// What the step is estimated to leave.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StepEstimate {
    /// The largest error of any channel.
    pub max_abs: f64,
    /// The root of the mean square.
    pub rms: f64,
    /// Width and height of the pictures that it was taken from.
    pub size: [u32; 2],
}

/// The longer edge of these pictures.
const EDGE: u32 = 96;

/// Estimates the step's error from two small pictures of the same view, of this step and of half of it; of slices, whose
/// step is their distance, where they are counted.
///
/// # Errors
/// As [`Renderer::render`].
pub fn step_estimate(renderer: &mut Renderer, settings: &Settings) -> Result<Option<StepEstimate>> {
    let longer = settings.size[0].max(settings.size[1]);
    let small = |n: u32| (u64::from(n) * u64::from(EDGE) / u64::from(longer)).max(1) as u32;
    let size = if longer > EDGE {
        settings.size.map(small)
    } else {
        settings.size
    };
    let whole = Settings {
        size,
        ert: 1.0,
        ..*settings
    };
    let slices = match settings.slices {
        Some(SliceCount::PerVoxel) => return Ok(None),
        Some(SliceCount::Exactly(count)) => Some(SliceCount::Exactly(2 * count)),
        None => None,
    };
    let half = Settings {
        step_voxels: 0.5 * settings.step_voxels,
        slices,
        ..whole
    };
    let pictures = [
        renderer.render(&whole)?.picture,
        renderer.render(&half)?.picture,
    ];
    let change = metrics([(&pictures[0], &pictures[1])]);
    Ok(Some(StepEstimate {
        max_abs: 2.0 * change.max_abs,
        rms: 2.0 * change.rms,
        size,
    }))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::camera::Orbit;
    use crate::measure::truth::Truths;
    use crate::render::BackendChoice;
    use crate::transfer::ControlPoint;
    use crate::volume::phantom;

    #[test]
    fn no_ray_that_stops_early_is_off_by_more_than_its_bound() {
        let mut renderer = Renderer::new(BackendChoice::Reference).unwrap();
        let mut reached = 0.0f64;
        for (name, tf) in [
            ("full", "ramp:0:255:0.2"),
            ("pot", "ramp:40:255:0.9"),
            ("shells", "translucent"),
            ("noise", "ramp:40:255:0.5"),
        ] {
            let volume = Arc::new(phantom::make(name, [16; 3]).unwrap());
            let statistics = crate::volume::Statistics::of(&volume);
            let transfer = TransferFunction::from_spec(tf, &statistics).unwrap();
            renderer.set_volume(Arc::clone(&volume)).unwrap();
            renderer.set_transfer(transfer.clone());
            for mode in ["emission-absorption", "shaded", "grey"] {
                let row = crate::mode::MODES.iter().find(|r| r.name == mode).unwrap();
                let settings = Settings {
                    size: [16; 2],
                    mode: (row.suited_to)(&statistics),
                    ..Settings::new(Orbit::default().camera(volume.extent()))
                };
                let whole = Settings {
                    ert: 1.0,
                    ..settings
                };
                let whole = renderer.render(&whole).unwrap().picture;
                for ert in [0.5, 0.9, 0.98] {
                    let settings = Settings { ert, ..settings };
                    let bound = ert_bound(&transfer, &settings).unwrap();
                    let stopped = renderer.render(&settings).unwrap().picture;
                    let off = metrics([(&stopped, &whole)]).max_abs;
                    assert!(
                        off <= bound.error + 1e-6,
                        "{name} {mode} {ert}: {off} {bound:?}"
                    );
                    reached = reached.max(off / bound.error);
                }
            }
        }
        // A bound that is never near to what it bounds would tell nothing.
        assert!(reached > 0.5, "{reached}");
    }

    #[test]
    fn the_step_leaves_no_more_than_estimated_where_it_meets_all_there_is() {
        let mut renderer = Renderer::new(BackendChoice::Cpu).unwrap();
        for name in ["full", "pot", "shells", "capsules", "gyroid"] {
            let volume = Arc::new(phantom::make(name, [24; 3]).unwrap());
            let statistics = crate::volume::Statistics::of(&volume);
            let transfer = TransferFunction::from_spec("translucent", &statistics).unwrap();
            renderer.set_volume(Arc::clone(&volume)).unwrap();
            renderer.set_transfer(transfer.clone());
            for step_voxels in [0.25, 0.5] {
                let settings = Settings {
                    size: [24; 2],
                    step_voxels,
                    ert: 1.0,
                    ..Settings::new(Orbit::default().camera(volume.extent()))
                };
                let estimate = step_estimate(&mut renderer, &settings).unwrap().unwrap();
                let truths = Truths::new(&volume, &transfer).unwrap();
                let truth = truths.kept_in(None).of(&settings, |_| ()).unwrap();
                let picture = renderer.render(&settings).unwrap().picture;
                let off = metrics([(&picture, &truth)]);
                assert!(
                    off.rms <= estimate.rms + truth.bound
                        && off.max_abs <= estimate.max_abs + truth.bound,
                    "{name} {step_voxels}: {off:?} {estimate:?}"
                );
            }
        }
    }

    #[test]
    fn modes_without_a_composite_have_no_bound_to_tell() {
        let volume = phantom::make("pot", [8; 3]).unwrap();
        let statistics = crate::volume::Statistics::of(&volume);
        let point = ControlPoint {
            value: 0.0,
            opacity: 0.2,
            color: [0.5; 3],
        };
        let transfer = TransferFunction::new(vec![point], 1.0).unwrap();
        for row in crate::mode::MODES {
            let settings = Settings {
                mode: (row.suited_to)(&statistics),
                ..Settings::new(Orbit::default().camera(volume.extent()))
            };
            let bound = ert_bound(&transfer, &settings);
            let composites = ["emission-absorption", "shaded", "grey"].contains(&row.name);
            assert_eq!(bound.is_some(), composites, "{}", row.name);
            assert!(bound.is_none_or(|b| b.error >= b.remaining));
        }
    }
}
