//! HOW one sample is taken: the interpolation of voxels, and when they get their colour.
//!
//! Each sampler has a WGSL twin of the same name in `shaders/sample/`, as has each source of gradients in
//! `shaders/gradient/`. All samplers return the table coordinate `x` of a grid
//! position (see [`crate::transfer::Domain`]).

mod classification;
pub(crate) mod gradients;
pub mod pre_integrated;

use crate::lattice::Real;

pub use classification::Classification;
pub use gradients::Gradients;
pub use pre_integrated::PreIntegrated;

/// The choice of sampler.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sampler {
    /// The adapter's trilinear filter (fractions have 8 bits on most GPUs).
    Hardware,
    /// Eight loads and f32 interpolation.
    Exact,
    /// The voxel that the sample lies in: no interpolation.
    Nearest,
    /// The cubic B-spline of 64 voxels, by eight fetches of the adapter's trilinear filter (Sigg & Hadwiger, GPU Gems 2,
    /// 2005).
    ///
    /// Of the cubic filters it is the one whose weights are not negative: what it returns lies between the least and the
    /// greatest of the voxels, so that blocks tell exactly what can be left out. A Catmull-Rom spline passes through the
    /// voxels but leaves their range, and with it every promise of a block. The price is that the B-spline smooths: at a
    /// voxel's centre it returns 8/27 of that voxel and the rest of its 26 neighbours.
    Tricubic,
    /// The same eight fetches, each computed in f32 from eight loads.
    TricubicExact,
}

impl Sampler {
    /// All samplers.
    pub const ALL: &[Self] = &[
        Self::Hardware,
        Self::Exact,
        Self::Nearest,
        Self::Tricubic,
        Self::TricubicExact,
    ];

    /// The name used by flags, files and shaders.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hardware => "hardware",
            Self::Exact => "exact",
            Self::Nearest => "nearest",
            Self::Tricubic => "tricubic",
            Self::TricubicExact => "tricubic-exact",
        }
    }

    /// The file in `shaders/sample/` that takes it.
    pub fn shader(self) -> &'static str {
        match self {
            Self::TricubicExact => "tricubic_exact",
            _ => self.name(),
        }
    }

    /// Whether it needs an adapter that filters the volume's format.
    pub fn is_filtered(self) -> bool {
        matches!(self, Self::Hardware | Self::Tricubic)
    }

    /// Voxels that a sample may touch beyond those of the (closed) block that it lies in, on each side.
    pub fn apron(self) -> usize {
        match self {
            // A sample up to half a voxel outside its block is the block's too, and lies in a voxel next to it.
            Self::Hardware | Self::Exact | Self::Nearest => 1,
            // There too: a fetch goes one voxel farther on each side than a trilinear one.
            Self::Tricubic | Self::TricubicExact => 2,
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

/// Weights of the cubic B-spline for the voxels from one below the lower neighbour to one above the upper, at the fraction
/// `f` between those two. None is negative, and their sum is 1.
pub fn bspline(f: f64) -> [f64; 4] {
    let g = 1.0 - f;
    [
        g * g * g,
        4.0 + f * f * (3.0 * f - 6.0),
        4.0 + g * g * (3.0 * g - 6.0),
        f * f * f,
    ]
    .map(|w| w / 6.0)
}

/// Lower neighbour (not yet clamped to the volume) and fraction of a grid coordinate: voxel i's centre is at i + 1/2.
#[inline(always)]
pub fn cell<R: Real>(grid: R) -> (R, R) {
    let shifted = grid - R::splat(0.5);
    let lower = shifted.floor();
    (lower, shifted - lower)
}
