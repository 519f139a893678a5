//! What one picture is made of, whoever makes it, and what comes back.

use std::ops::AddAssign;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use crate::error::{Error, Result};
use crate::lattice::RayFrame;
use crate::mode::Mode;
use crate::sample::{Classification, Gradients, Sampler};
use crate::transfer::Table;
use crate::volume::Volume;

/// Everything that decides a pixel: the same for every skipping method and backend.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// The voxels.
    pub volume: &'a Volume,
    /// The transfer function, baked for this frame's step.
    pub table: &'a Table,
    /// The rays and their lattice.
    pub frame: &'a RayFrame,
    /// HOW.
    pub sampler: Sampler,
    /// When samples get their colour; what it needs of them, [`RayFrame::reach`] says too.
    pub classification: Classification,
    /// WHAT.
    pub mode: Mode,
    /// Where modes that light surfaces take gradients from.
    pub gradients: Gradients,
    /// Share of light that colours lose at the farthest point of the box ([`crate::mode::DepthCue`]); 0: none.
    pub depth_cue: f64,
    /// Accumulated opacity at which a ray stops; 1 or more: never.
    pub ert: f32,
}

impl<'a> Scene<'a> {
    /// Emission and absorption of exact samples, classified after interpolation, along rays that never stop early.
    pub fn new(volume: &'a Volume, table: &'a Table, frame: &'a RayFrame) -> Self {
        Self {
            volume,
            table,
            frame,
            sampler: Sampler::Exact,
            classification: Classification::Post,
            mode: Mode::EmissionAbsorption,
            gradients: Gradients::Fly,
            depth_cue: 0.0,
            ert: 1.0,
        }
    }

    /// The accumulated opacity at which a ray stops; infinite where it never does. Above zero: a threshold of 0 stops a
    /// ray at the first sample that shows something, and not at the first that a method happens to take.
    pub fn ert_threshold(&self) -> f64 {
        if self.ert >= 1.0 {
            f64::INFINITY
        } else {
            f64::from(self.ert.max(f32::MIN_POSITIVE))
        }
    }
}

/// How far a picture on the CPU has come, and the way to stop it: shared between the one who draws and the one who
/// waits.
#[derive(Debug, Default)]
pub struct Progress {
    rows: AtomicU32,
    cancelled: AtomicBool,
}

impl Progress {
    /// Rows of pixels that are finished.
    pub fn rows_done(&self) -> u32 {
        self.rows.load(Ordering::Relaxed)
    }

    /// Asks to stop at the next row.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// The flag that [`Self::cancel`] sets.
    pub fn cancelled(&self) -> &AtomicBool {
        &self.cancelled
    }

    /// Whether someone asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Starts over, for the next picture.
    pub fn restart(&self) {
        self.rows.store(0, Ordering::Relaxed);
        self.cancelled.store(false, Ordering::Relaxed);
    }

    /// Counts a row as finished.
    ///
    /// # Errors
    /// [`Error::Cancelled`] where someone asked to stop.
    pub fn finish_row(&self) -> Result<()> {
        self.rows.fetch_add(1, Ordering::Relaxed);
        if self.is_cancelled() {
            Err(Error::Cancelled)
        } else {
            Ok(())
        }
    }
}

/// A picture: linear red, green, blue premultiplied by opacity, and opacity; row by row from the top left.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Width and height.
    pub size: [u32; 2],
    /// `size[0] * size[1]` pixels.
    pub rgba: Vec<[f32; 4]>,
}

impl Picture {
    /// How many pixels differ from `other` in any bit, and the largest difference of any channel.
    ///
    /// # Panics
    /// Where the sizes differ.
    pub fn difference(&self, other: &Self) -> Difference {
        assert_eq!(self.size, other.size, "pictures of one size are compared");
        let mut difference = Difference {
            pixels: 0,
            max_abs: 0.0,
        };
        for (a, b) in self.rgba.iter().zip(&other.rgba) {
            difference.pixels += u64::from(a.map(f32::to_bits) != b.map(f32::to_bits));
            for (x, y) in a.iter().zip(b) {
                difference.max_abs = difference.max_abs.max(f64::from((x - y).abs()));
            }
        }
        difference
    }
}

/// How two pictures differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Pixels with any bit different.
    pub pixels: u64,
    /// Largest absolute difference of any channel, linear and premultiplied.
    pub max_abs: f64,
}

/// The work that a picture took, which depends on no machine; sums over all pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counters {
    /// Samples taken.
    pub samples: u64,
    /// Samples that added something.
    pub contributing: u64,
    /// Segments asked for, or steps of a traversal between samples.
    pub skip_steps: u64,
}

impl AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        self.samples += other.samples;
        self.contributing += other.contributing;
        self.skip_steps += other.skip_steps;
    }
}

/// A picture with the work that each pixel took.
#[derive(Debug, Clone)]
pub struct CountedPicture {
    /// The picture: bit-identical to the uncounted one.
    pub picture: Picture,
    /// Sums over all pixels.
    pub counters: Counters,
    /// Samples taken, per pixel, in the picture's order.
    pub samples: Vec<u32>,
    /// Distance from the eye's start plane (local units along the ray, from its start) to the first contributing sample; infinite where there is
    /// none.
    pub first_hit: Vec<f32>,
}
