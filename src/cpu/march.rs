//! The marcher: eight rays at a time over ranges of their sample lattice.

use super::cells::Cells;
use super::grid::Grid;
use super::packet::{LANES, Packet, Voxel};
use super::project::Projection;
use crate::lattice::Ray;
use crate::mode::emission_absorption::State;
use crate::skip::beam_masks::{BeamMasks, Collapse};
use crate::skip::distance_map::DistanceMap;
use crate::skip::{FULL, Majorants};
use crate::transfer::lookup;

/// Everything that the tiles of one picture share.
pub(super) struct Job<'a, V> {
    pub(super) grid: Grid<'a, V>,
    pub(super) frame: &'a crate::lattice::RayFrame,
    /// [`super::table::rows`].
    pub(super) rows: &'a [[f32; 8]],
    /// Table coordinate of a voxel: `(stored - base) * scale`, so that large offsets cancel before they are rounded.
    pub(super) base: f64,
    pub(super) scale: f64,
    pub(super) snap: f64,
    /// Table coordinates between which nothing is visible; the second below the first where there are none.
    pub(super) background: [f64; 2],
    /// Opacity at which rays stop; infinite: never.
    pub(super) threshold: f64,
    /// Read in place of the table by the modes that project.
    pub(super) projection: Option<Projection>,
    pub(super) skip: &'a Skipping,
    /// Cells that may be visible; `None`: all are looked at.
    pub(super) cells: Option<&'a Cells>,
    /// What bounds the blocks of a distance map, in the modes that keep the highest place of their window.
    pub(super) majorants: Option<&'a Majorants>,
}

/// What a plan keeps of its method.
#[derive(Debug)]
pub(super) enum Skipping {
    Box,
    Layers(Box<BeamMasks>, Collapse),
    Distance(DistanceMap),
}

/// What is kept of a pixel: the picture alone, or the work too.
pub(super) trait Pixel: Copy + Send + Sync {
    /// A pixel whose ray took no sample.
    const EMPTY: Self;
    /// Whether work is counted.
    const COUNT: bool;

    fn new(rgba: [f32; 4], tally: Tally<f32>) -> Self;
}

impl Pixel for [f32; 4] {
    const EMPTY: Self = [0.0; 4];
    const COUNT: bool = false;

    #[inline(always)]
    fn new(rgba: [f32; 4], _: Tally<f32>) -> Self {
        rgba
    }
}

/// A pixel and the work it took.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counted {
    pub(super) rgba: [f32; 4],
    pub(super) tally: Tally<f32>,
}

impl Pixel for Counted {
    const EMPTY: Self = Self {
        rgba: [0.0; 4],
        tally: Tally {
            samples: 0.0,
            contributing: 0.0,
            skip_steps: 0.0,
            first_hit: f32::INFINITY,
        },
    };
    const COUNT: bool = true;

    fn new(rgba: [f32; 4], tally: Tally<f32>) -> Self {
        Self { rgba, tally }
    }
}

/// The work of a ray, or of one per lane. Counts are integers; a ray has fewer than 2^24 samples.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tally<R> {
    /// Samples whose voxels were asked for.
    pub(super) samples: R,
    /// Samples that added something.
    pub(super) contributing: R,
    /// Segments, leaps, and lattice points that the bit of their cell ruled out.
    pub(super) skip_steps: R,
    /// Distance from the ray's start to the first contributing sample, in local units.
    pub(super) first_hit: R,
}

impl<P: Packet> Tally<P> {
    #[inline(always)]
    fn new() -> Self {
        let zero = P::splat(0.0);
        Self {
            samples: zero,
            contributing: zero,
            skip_steps: zero,
            first_hit: P::splat(f64::INFINITY),
        }
    }

    /// One more lane by lane.
    #[inline(always)]
    fn count(counter: &mut P, lanes: P::Mask) {
        *counter = *counter + P::splat(1.0).keep(lanes);
    }

    /// The tally of one lane.
    #[inline(always)]
    pub(super) fn lane(columns: &[[f32; LANES]; 4], lane: usize) -> Tally<f32> {
        Tally {
            samples: columns[0][lane],
            contributing: columns[1][lane],
            skip_steps: columns[2][lane],
            first_hit: columns[3][lane],
        }
    }

    #[inline(always)]
    pub(super) fn columns(&self) -> [[f32; LANES]; 4] {
        [
            self.samples,
            self.contributing,
            self.skip_steps,
            self.first_hit,
        ]
        .map(P::to_lanes)
    }
}

/// Eight rays on their way.
pub(super) struct Marcher<'a, P: Packet, V, const COUNT: bool> {
    job: &'a Job<'a, V>,
    pub(super) ray: Ray<P>,
    state: State<P>,
    /// Where each ray ends: one past its last sample; 0 once it has seen enough.
    end: P,
    pub(super) tally: Tally<P>,
}

impl<'a, P: Packet, V: Voxel, const COUNT: bool> Marcher<'a, P, V, COUNT> {
    #[inline(always)]
    pub(super) fn new(job: &'a Job<'a, V>, ray: Ray<P>) -> Self {
        Self {
            job,
            ray,
            state: State::init(),
            end: ray.k_end,
            tally: Tally::new(),
        }
    }

    /// Takes the samples [first, end) of each ray.
    #[inline(always)]
    pub(super) fn take(&mut self, first: P, end: P) {
        match self.job.cells {
            Some(cells) => self.take_visible(cells, first, end),
            None => self.take_all(first, end),
        }
    }

    #[inline(always)]
    fn take_all(&mut self, first: P, end: P) {
        let one = P::splat(1.0);
        let mut k = first;
        if COUNT {
            Tally::count(&mut self.tally.skip_steps, k.lt(end.min(self.end)));
        }
        loop {
            let live = k.lt(end.min(self.end));
            if !P::any(live) {
                return;
            }
            let cell = self.job.grid.cell(self.ray.at(k));
            self.sample(cell, live, k);
            k = k + one;
        }
    }

    /// The same, where only samples in visible cells are looked at.
    #[inline(always)]
    fn take_visible(&mut self, cells: &Cells, first: P, end: P) {
        let one = P::splat(1.0);
        let mut k = first;
        if COUNT {
            Tally::count(&mut self.tally.skip_steps, k.lt(end.min(self.end)));
        }
        loop {
            let live = k.lt(end.min(self.end));
            if !P::any(live) {
                return;
            }
            let cell = self.job.grid.cell(self.ray.at(k));
            let visible = P::and(live, cells.visible(&cell));
            if P::any(visible) {
                self.sample(cell, visible, k);
            }
            if COUNT {
                Tally::count(&mut self.tally.skip_steps, live);
                let kept = P::splat(1.0).keep(visible);
                self.tally.skip_steps = self.tally.skip_steps - kept;
            }
            k = k + one;
        }
    }

    /// Takes all samples that the distance map and what rays have seen do not rule out, each ray leaping on its own.
    #[inline(always)]
    pub(super) fn leap(&mut self, map: &DistanceMap) {
        let one = P::splat(1.0);
        let mut k = self.ray.k_near;
        loop {
            let live = k.lt(self.end);
            if !P::any(live) {
                return;
            }
            let at = self.ray.at(k);
            let block = [
                map.block_at(0, at[0]),
                map.block_at(1, at[1]),
                map.block_at(2, at[2]),
            ];
            let row = P::mul_add_index(block[2].to_index(), map.dims[1], block[1].to_index());
            let index = P::mul_add_index(row, map.dims[0], block[0].to_index());
            let distance = P::bytes(map.distances(), index);
            let mut is_taken = distance.lt(one);
            if let Some(majorants) = self.job.majorants {
                let highest = self.state.rgba[0] * P::splat(FULL);
                let may_add = highest.lt(P::bytes(majorants.bytes(), index));
                is_taken = P::and(is_taken, may_add);
            }
            let active = P::and(live, is_taken);
            let leap = map.leap(&self.ray, at, block, distance.max(one));
            if COUNT {
                Tally::count(&mut self.tally.skip_steps, live);
                self.tally.skip_steps = self.tally.skip_steps - one.keep(active);
            }
            if P::any(active) {
                let cell = self.job.grid.cell(at);
                let visible = match self.job.cells {
                    Some(cells) => P::and(active, cells.visible(&cell)),
                    None => active,
                };
                if P::any(visible) {
                    self.sample(cell, visible, k);
                }
            }
            k = k + P::select(is_taken, one, leap);
        }
    }

    /// Samples the `wanted` lanes at `k` and adds what they see.
    #[inline(always)]
    fn sample(&mut self, cell: super::grid::Cell<P>, wanted: P::Mask, k: P) {
        let job = self.job;
        if COUNT {
            Tally::count(&mut self.tally.samples, wanted);
        }
        let x = (job.grid.value(cell) - P::splat(job.base)) * P::splat(job.scale);
        if let Some(projection) = &job.projection {
            let seen = projection.add(&mut self.state.rgba[0], x, wanted);
            let done = projection.done(self.state.rgba[0]);
            self.end = P::select(done, P::splat(0.0), self.end);
            self.tally_seen(seen, k);
            return;
        }
        let low = P::splat(job.background[0]);
        let high = P::splat(job.background[1]);
        let outside = P::and(wanted, P::or(x.lt(low), high.lt(x)));
        if !P::any(outside) {
            return;
        }
        let entries = P::splat(job.rows.len() as f64);
        let (entry, fraction) = lookup(x, entries, P::splat(job.snap));
        let columns = P::rows(job.rows, entry);
        let mut sample = [P::splat(0.0); 4];
        for (c, sample) in sample.iter_mut().enumerate() {
            *sample = (columns[c] + fraction * columns[c + 4]).keep(outside);
        }
        self.state.add(sample);
        let done = self.state.done(P::splat(job.threshold));
        self.end = P::select(done, P::splat(0.0), self.end);
        if COUNT {
            let zero = P::splat(0.0);
            let seen = sample.map(|c| zero.lt(c));
            let seen = P::or(P::or(seen[0], seen[1]), P::or(seen[2], seen[3]));
            self.tally_seen(seen, k);
        }
    }

    /// Counts samples at `k` that contributed.
    #[inline(always)]
    fn tally_seen(&mut self, seen: P::Mask, k: P) {
        if COUNT {
            Tally::count(&mut self.tally.contributing, seen);
            let t = self.ray.t_box + (k + P::splat(0.5)) * P::splat(self.job.frame.step);
            self.tally.first_hit =
                P::select(seen, self.tally.first_hit.min(t), self.tally.first_hit);
        }
    }

    /// The pixels, once all samples are taken.
    #[inline(always)]
    pub(super) fn pixels(&self) -> [P; 4] {
        match &self.job.projection {
            Some(projection) => projection.finish(self.state.rgba[0], &self.ray),
            None => self.state.rgba,
        }
    }
}
