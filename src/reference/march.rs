//! One pixel: the flat loop over the segments of a ray that every backend has.

use super::Classes;
use crate::lattice::RayBasis;
use crate::mode::{Mode, Parameters};
use crate::sample::{Sampler, cell, trilinear};
use crate::scene::{Counters, Scene};
use crate::skip::Plan;

/// All that the pixels of one picture share.
pub(super) struct Marcher<'a, V, C> {
    plan: &'a Plan<'a>,
    voxels: &'a [V],
    dims: [usize; 3],
    pub(super) classes: &'a C,
    /// Table coordinate per stored unit, and the stored number at coordinate 0.
    scale: f64,
    origin: f64,
    basis: RayBasis<f64>,
    step: f64,
    pub(super) grid_from_local: [f64; 3],
    sampler: Sampler,
    pub(super) mode: Mode,
    pub(super) parameters: Parameters,
    pub(super) ert_threshold: f64,
}

/// What a ray found.
pub(super) struct Pixel {
    pub(super) rgba: [f64; 4],
    /// The work of this pixel alone.
    pub(super) counters: Counters,
    /// Local units along the ray, from its start, to the first contributing sample; infinite where there is none.
    pub(super) first_hit: f64,
}

impl<'a, V: Copy + Into<f64>, C: Classes> Marcher<'a, V, C> {
    pub(super) fn new(scene: &Scene<'a>, plan: &'a Plan, voxels: &'a [V], classes: &'a C) -> Self {
        Self {
            plan,
            voxels,
            dims: scene.volume.dims,
            classes,
            scale: classes.domain().scale,
            origin: classes.domain().origin,
            basis: scene.frame.basis(),
            step: scene.frame.step,
            grid_from_local: scene.frame.grid_from_local.to_array(),
            sampler: scene.sampler,
            mode: scene.mode,
            parameters: Parameters::new(&scene.mode, classes.domain(), scene.frame.step),
            ert_threshold: scene.ert_threshold(),
        }
    }

    /// The pixel in column `x` of row `y`.
    pub(super) fn pixel(&self, x: usize, y: usize) -> Pixel {
        self.pixel_at([x as f64, y as f64])
    }

    /// What is seen at a place of the picture; whole numbers are the middles of pixels.
    pub(super) fn pixel_at(&self, [x, y]: [f64; 2]) -> Pixel {
        let ray = self.basis.ray(x, y);
        let mut state = [0.0; 4];
        let shows = |k: u32| {
            let k = f64::from(k);
            self.add(&mut [0.0; 4], self.sample(ray.at(k)), k, &ray)
        };
        let mut segments = self
            .plan
            .segments(&ray, [x.round() as u32, y.round() as u32], &shows);
        let mut counters = Counters::default();
        let mut first_hit = f64::INFINITY;
        let mut k = 0;
        'ray: while let Some(segment) = segments.next(k, f64::NAN) {
            k = segment.end;
            let stride = segments.stride();
            for first in segment.step_by(stride as usize) {
                counters.samples += 1;
                let k = f64::from(first);
                let value = self.sample(ray.at(k + 0.5 * f64::from(stride - 1)));
                let mut contributes = false;
                for i in 0..stride {
                    contributes |= self.add(&mut state, value, k + f64::from(i), &ray);
                }
                if !contributes {
                    continue;
                }
                if counters.contributing == 0 {
                    first_hit = ray.t_box + (k + 0.5) * self.step;
                }
                counters.contributing += 1;
                if self.is_done(&state) {
                    break 'ray;
                }
            }
        }
        counters.samples += u64::from(segments.probes());
        counters.skip_steps = u64::from(segments.steps());
        Pixel {
            rgba: self.finish(state, &ray),
            counters,
            first_hit,
        }
    }

    /// Table coordinate at a grid position; beyond the outermost voxel centres these go on.
    #[inline]
    pub(super) fn sample(&self, at: [f64; 3]) -> f64 {
        match self.sampler {
            Sampler::Hardware | Sampler::Exact => {
                // Written out: nested maps over arrays do not inline, and this is where the time goes.
                let (x, y, z) = (
                    self.neighbours(0, at[0]),
                    self.neighbours(1, at[1]),
                    self.neighbours(2, at[2]),
                );
                let row = |y: usize, z: usize| {
                    let row = (z * self.dims[1] + y) * self.dims[0];
                    [self.voxels[row + x.0].into(), self.voxels[row + x.1].into()]
                };
                let corners = [
                    [row(y.0, z.0), row(y.1, z.0)],
                    [row(y.0, z.1), row(y.1, z.1)],
                ];
                (trilinear(corners, [x.2, y.2, z.2]) - self.origin) * self.scale
            }
            Sampler::Nearest => {
                let voxel = |a: usize| (at[a].floor() as i32).clamp(0, self.dims[a] as i32 - 1);
                let [x, y, z] = [voxel(0), voxel(1), voxel(2)].map(|i| i as usize);
                let stored: f64 = self.voxels[(z * self.dims[1] + y) * self.dims[0] + x].into();
                (stored - self.origin) * self.scale
            }
        }
    }

    /// The two voxels around a grid coordinate of `axis`, and the fraction between them.
    #[inline]
    fn neighbours(&self, axis: usize, grid: f64) -> (usize, usize, f64) {
        let (lower, fraction) = cell(grid);
        let last = self.dims[axis] as i32 - 1;
        let lower = lower as i32;
        let clamped = |i: i32| i.clamp(0, last) as usize;
        (clamped(lower), clamped(lower + 1), fraction)
    }
}
