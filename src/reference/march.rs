//! One pixel: the flat loop over the segments of a ray that every backend has.

use super::Classes;
use super::classes::Baked;
use crate::lattice::{Ray, RayBasis};
use crate::mode::{DepthCue, Mode, Parameters};
use crate::sample::pre_integrated::Integrals;
use crate::sample::{Classification, Gradients, Sampler, bspline, cell, gradients, trilinear};
use crate::scene::{Counters, Scene};
use crate::skip::Plan;
use crate::transfer::Table;

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
    pub(super) step: f64,
    pub(super) grid_from_local: [f64; 3],
    sampler: Sampler,
    gradients: Gradients,
    coloring: Coloring<'a>,
    pub(super) mode: Mode,
    pub(super) cue: DepthCue,
    /// The direction that depth is measured along; unit length, local axes.
    pub(super) forward: [f64; 3],
    pub(super) parameters: Parameters,
    pub(super) ert_threshold: f64,
}

/// How a sample gets its colour; what comes before or between samples is by the baked table.
enum Coloring<'a> {
    Post,
    Pre(Baked<'a>),
    PreIntegrated(Integrals),
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
            gradients: scene.gradients,
            coloring: match scene.classification {
                Classification::Post => Coloring::Post,
                Classification::Pre => Coloring::Pre(Baked::new(scene.table)),
                Classification::PreIntegrated => {
                    Coloring::PreIntegrated(Integrals::new(scene.table))
                }
            },
            mode: scene.mode,
            cue: DepthCue::new(scene.depth_cue, scene.frame),
            forward: scene.frame.dir.to_array(),
            parameters: Parameters::new(&scene.mode, classes.domain(), scene.frame.step),
            ert_threshold: scene.ert_threshold(),
        }
    }

    /// The pixel in column `x` of row `y`.
    pub(super) fn pixel(&self, x: usize, y: usize) -> Pixel {
        self.pixel_at([x as f64, y as f64])
    }

    /// What is seen at a place of the picture; whole numbers are the middles of pixels.
    pub(super) fn pixel_at(&self, place: [f64; 2]) -> Pixel {
        self.pixel_told(place, |_, _| {})
    }

    /// The same, where `contributed` is told of every sample that contributes, and the state that it leaves.
    pub(super) fn pixel_told(
        &self,
        [x, y]: [f64; 2],
        mut contributed: impl FnMut(u32, &[f64; 4]),
    ) -> Pixel {
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
        let keeps_highest = self.mode.keeps_highest();
        let highest = |state: &[f64; 4]| if keeps_highest { state[0] } else { f64::NAN };
        'ray: while let Some(segment) = segments.next(k, highest(&state)) {
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
                contributed(first, &state);
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

    /// Whether samples in a row at a place of the picture show nothing by `table` but have visible values between theirs.
    pub(super) fn steps_over(&self, [x, y]: [f64; 2], table: &Table) -> bool {
        let ray = self.basis.ray(x, y);
        let pixel = [x.round() as u32, y.round() as u32];
        let mut segments = self.plan.segments(&ray, pixel, &|_| true);
        let mut end = 0;
        while let Some(segment) = segments.next(end, f64::NAN) {
            end = segment.end;
            // With the samples on either side: what is left out ends between two.
            let first = segment.start.saturating_sub(1);
            let mut before = self.sample(ray.at(f64::from(first)));
            for k in first + 1..=end.min(ray.k_end as u32) {
                let x = self.sample(ray.at(f64::from(k)));
                let is_hidden = |x: f64| !table.is_visible(x..=x);
                if table.is_visible(before.min(x)..=before.max(x))
                    && is_hidden(before)
                    && is_hidden(x)
                {
                    return true;
                }
                before = x;
            }
        }
        false
    }

    /// Premultiplied colour and opacity of sample `k`, of table coordinate `x`.
    pub(super) fn color(&self, x: f64, k: f64, ray: &Ray<f64>) -> [f64; 4] {
        match &self.coloring {
            Coloring::Post => self.classes.rgba(x),
            Coloring::Pre(table) => self.colors_around(ray.at(k), table),
            Coloring::PreIntegrated(integrals) => integrals.interval(
                self.sample(ray.interval_end(k)),
                self.sample(ray.interval_end(k + 1.0)),
            ),
        }
    }

    /// Table coordinate at a grid position; beyond the outermost voxel centres these go on.
    #[inline]
    pub(super) fn sample(&self, at: [f64; 3]) -> f64 {
        match self.sampler {
            Sampler::Hardware | Sampler::Exact => {
                let (corners, fractions) = self.corners(at);
                (trilinear(corners, fractions) - self.origin) * self.scale
            }
            Sampler::Nearest => {
                let voxel = |a: usize| (at[a].floor() as i32).clamp(0, self.dims[a] as i32 - 1);
                let [x, y, z] = [voxel(0), voxel(1), voxel(2)].map(|i| i as usize);
                let stored: f64 = self.voxels[(z * self.dims[1] + y) * self.dims[0] + x].into();
                (stored - self.origin) * self.scale
            }
            Sampler::Tricubic | Sampler::TricubicExact => {
                (self.bspline(at) - self.origin) * self.scale
            }
        }
    }

    /// The stored number of the cubic B-spline at a grid position.
    fn bspline(&self, at: [f64; 3]) -> f64 {
        let mut sum = 0.0;
        self.weigh(at, |weight, stored| sum += weight * stored);
        sum
    }

    /// Tells `add` of the weights in the cubic B-spline at a grid position, and of the stored numbers, of its 64 voxels.
    fn weigh(&self, at: [f64; 3], mut add: impl FnMut(f64, f64)) {
        let cells = at.map(cell);
        let weights = cells.map(|(_, f)| bspline(f));
        let voxel = |axis: usize, i: usize| {
            let last = self.dims[axis] as i64 - 1;
            (cells[axis].0 as i64 - 1 + i as i64).clamp(0, last) as usize
        };
        for z in 0..4 {
            for y in 0..4 {
                let row = (voxel(2, z) * self.dims[1] + voxel(1, y)) * self.dims[0];
                let weight = weights[2][z] * weights[1][y];
                for (x, along_x) in weights[0].into_iter().enumerate() {
                    let stored: f64 = self.voxels[row + voxel(0, x)].into();
                    add(weight * along_x, stored);
                }
            }
        }
    }

    /// The gradient at a grid position, over two voxels along each axis, in table coordinates.
    pub(super) fn differences(&self, at: [f64; 3]) -> [f64; 3] {
        let Some(edge) = self.gradients.cell_edge() else {
            return std::array::from_fn(|axis| {
                let (mut before, mut after) = (at, at);
                before[axis] -= 1.0;
                after[axis] += 1.0;
                self.sample(after) - self.sample(before)
            });
        };
        gradients::interpolated(self.voxels, self.dims, edge, at).map(|d| d * self.scale)
    }

    /// The colours of the voxels around a grid position, interpolated.
    fn colors_around(&self, at: [f64; 3], table: &Baked) -> [f64; 4] {
        match self.sampler {
            Sampler::Nearest => return table.rgba(self.sample(at)),
            Sampler::Tricubic | Sampler::TricubicExact => {
                let mut sum = [0.0; 4];
                self.weigh(at, |weight, stored| {
                    let color = table.rgba((stored - self.origin) * self.scale);
                    sum = std::array::from_fn(|c| sum[c] + weight * color[c]);
                });
                return sum;
            }
            Sampler::Hardware | Sampler::Exact => {}
        }
        let (corners, fractions) = self.corners(at);
        let colors =
            corners.map(|z| z.map(|y| y.map(|v| table.rgba((v - self.origin) * self.scale))));
        std::array::from_fn(|c| trilinear(colors.map(|z| z.map(|y| y.map(|v| v[c]))), fractions))
    }

    /// The stored numbers around a grid position, and where it lies between them.
    #[inline]
    fn corners(&self, at: [f64; 3]) -> ([[[f64; 2]; 2]; 2], [f64; 3]) {
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
        (corners, [x.2, y.2, z.2])
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
