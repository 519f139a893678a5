//! Emission and absorption (Yu et al. 2016, equations 6 and 7): `C += (1 - A) c`, `A += (1 - A) a`, front to back,
//! colours premultiplied by opacity.

use crate::lattice::Real;

/// Accumulated colour and opacity, premultiplied.
#[derive(Debug, Clone, Copy)]
pub struct State<R> {
    /// Red, green, blue, opacity.
    pub rgba: [R; 4],
}

impl<R: Real> State<R> {
    /// Nothing seen yet.
    #[inline(always)]
    pub fn init() -> Self {
        Self {
            rgba: [R::splat(0.0); 4],
        }
    }

    /// Adds one sample behind those so far. A sample that is all zero changes no bit.
    #[inline(always)]
    pub fn add(&mut self, sample: [R; 4]) {
        let remaining = R::splat(1.0) - self.rgba[3];
        for (sum, c) in self.rgba.iter_mut().zip(sample) {
            *sum = *sum + remaining * c;
        }
    }

    /// Where the accumulated opacity has reached `threshold`, the rest of the ray is left out. Infinity: never.
    #[inline(always)]
    pub fn done(&self, threshold: R) -> R::Mask {
        threshold.le(self.rgba[3])
    }
}
