//! HOW one sample is taken: the interpolation of voxels, and when they get their colour.
//!
//! Each sampler has a WGSL twin of the same name in `shaders/sample/`. All return the table coordinate `x` of a grid
//! position (see [`crate::transfer::Domain`]).

mod classification;
pub mod pre_integrated;

pub use classification::Classification;
pub use pre_integrated::PreIntegrated;

use crate::lattice::Real;

/// The choice of sampler.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sampler {
    /// The adapter's trilinear filter (fractions have 8 bits on most GPUs).
    Hardware,
    /// Eight loads and f32 interpolation.
    Exact,
    /// The voxel that the sample lies in: no interpolation.
    Nearest,
}

impl Sampler {
    /// All samplers.
    pub const ALL: &[Self] = &[Self::Hardware, Self::Exact, Self::Nearest];

    /// The name used by flags, files and shaders.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hardware => "hardware",
            Self::Exact => "exact",
            Self::Nearest => "nearest",
        }
    }

    /// Voxels that a sample may touch beyond those of the (closed) block that it lies in, on each side.
    pub fn apron(self) -> usize {
        match self {
            // A sample up to half a voxel outside its block is the block's too, and lies in a voxel next to it.
            Self::Hardware | Self::Exact | Self::Nearest => 1,
        }
    }
}

/// Interpolates eight neighbours `corners[z][y][x]` at the fraction `f` per axis, x first.
///
/// `a + f * (b - a)` returns `a` exactly where both are equal: uniform data stay uniform.
#[inline(always)]
pub fn trilinear<R: Real>(corners: [[[R; 2]; 2]; 2], f: [R; 3]) -> R {
    lerp(
        bilinear(corners[0], f[0], f[1]),
        bilinear(corners[1], f[0], f[1]),
        f[2],
    )
}

// Functions, not closures: those cannot be told to inline, and a SIMD packet that is passed to a function compiled
// without its instructions costs ten times as much.
#[inline(always)]
fn bilinear<R: Real>(corners: [[R; 2]; 2], fx: R, fy: R) -> R {
    lerp(
        lerp(corners[0][0], corners[0][1], fx),
        lerp(corners[1][0], corners[1][1], fx),
        fy,
    )
}

#[inline(always)]
fn lerp<R: Real>(a: R, b: R, f: R) -> R {
    a + f * (b - a)
}

/// Lower neighbour (not yet clamped to the volume) and fraction of a grid coordinate: voxel i's centre is at i + 1/2.
#[inline(always)]
pub fn cell<R: Real>(grid: R) -> (R, R) {
    let shifted = grid - R::splat(0.5);
    let lower = shifted.floor();
    (lower, shifted - lower)
}
