//! Packets: eight rays side by side. [`Packet`] is what the marcher needs beyond arithmetic; [`Lanes`] is its scalar
//! twin, which runs everywhere and which the vector paths equal bit for bit.

use std::ops::{Add, Div, Mul, Neg, Sub};

use bytemuck::Pod;

use super::grid::Grid;
use crate::lattice::Real;

/// Rays per packet.
pub(super) const LANES: usize = 8;

/// A voxel type that packets read in place.
pub(super) trait Voxel: Pod + PartialOrd + Send + Sync {
    /// The stored number; exact.
    fn to_f32(self) -> f32;

    /// The smallest and largest voxel inside [low, high], so that no rounding of an interpolation between voxels inside
    /// them leaves the table's interval; `None` where there is no such voxel.
    fn interval(low: f64, high: f64) -> Option<[Self; 2]>;
}

macro_rules! integer_voxel {
    ($($t:ty),*) => {$(
        impl Voxel for $t {
            #[inline(always)]
            fn to_f32(self) -> f32 {
                f32::from(self)
            }
            fn interval(low: f64, high: f64) -> Option<[Self; 2]> {
                // Casts of floats to integers saturate: infinite ends become the type's own.
                let (low, high) = (low.ceil() as i64, high.floor() as i64);
                let (min, max) = (i64::from(<$t>::MIN), i64::from(<$t>::MAX));
                (low <= high && low <= max && high >= min)
                    .then(|| [low.max(min) as $t, high.min(max) as $t])
            }
        }
    )*};
}

integer_voxel!(u8, i8, u16, i16);

impl Voxel for f32 {
    #[inline(always)]
    fn to_f32(self) -> f32 {
        self
    }

    fn interval(low: f64, high: f64) -> Option<[Self; 2]> {
        // Interpolation may leave its corners by some ulp of the larger (design contract 4).
        let finite = [low, high].map(|v| if v.is_finite() { v.abs() } else { 0.0 });
        let margin = 8.0 * f64::from(f32::EPSILON) * finite[0].max(finite[1]);
        let (low, high) = ((low + margin) as f32, (high - margin) as f32);
        (low <= high).then_some([low, high])
    }
}

/// Eight lanes of single-precision numbers, and how they read voxels and tables.
pub(super) trait Packet: Real {
    /// Eight indices.
    type Index: Copy;

    fn from_lanes(lanes: [f32; LANES]) -> Self;
    fn to_lanes(self) -> [f32; LANES];
    /// Both masks.
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Either mask.
    fn or(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Lane i as bit i.
    fn bits(mask: Self::Mask) -> u32;
    /// The number where the mask holds, else zero.
    fn keep(self, mask: Self::Mask) -> Self;
    /// Lanes, which hold integers from 0 to 2^24, as indices.
    fn to_index(self) -> Self::Index;
    /// `a * factor + b`; vector paths only take volumes where that fits an unsigned 32-bit number.
    fn mul_add_index(a: Self::Index, factor: usize, b: Self::Index) -> Self::Index;
    /// The eight voxels at and above `lower`, `[z][y][x]`, where `lower` is the linear index of the cell's lowest corner.
    /// Neighbours beyond the array's end are replaced by its last voxel.
    fn corners<V: Voxel>(grid: &Grid<'_, V>, lower: Self::Index) -> [[[Self; 2]; 2]; 2];
    /// Bit `index % 32` of word `index / 32`; indices beyond the words read the last one.
    fn test_bits(words: &[u32], index: Self::Index) -> Self::Mask;
    /// Bytes at the indices, as numbers; indices beyond the bytes read the last one.
    fn bytes(bytes: &[u8], index: Self::Index) -> Self;
    /// The columns of the table rows at these lanes (integers); beyond the table: its last row.
    fn rows(table: &[[f32; 8]], row: Self) -> [Self; 8];

    /// Whether the mask holds anywhere.
    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        Self::bits(mask) != 0
    }
}

/// The scalar twin: a loop over eight lanes for every operation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lanes([f32; LANES]);

impl Lanes {
    #[inline(always)]
    fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self(self.0.map(f))
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

macro_rules! lanes_operator {
    ($($trait:ident $method:ident $op:tt),*) => {$(
        impl $trait for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $op b)
            }
        }
    )*};
}

lanes_operator!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl Real for Lanes {
    type Mask = [bool; LANES];

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value as f32; LANES])
    }
    #[inline(always)]
    fn floor(self) -> Self {
        self.map(f32::floor)
    }
    #[inline(always)]
    fn ceil(self) -> Self {
        self.map(f32::ceil)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f32::sqrt)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f32::abs)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        std::array::from_fn(|i| self.0[i] < other.0[i])
    }
    #[inline(always)]
    fn le(self, other: Self) -> Self::Mask {
        std::array::from_fn(|i| self.0[i] <= other.0[i])
    }
    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|i| {
            if mask[i] { yes.0[i] } else { no.0[i] }
        }))
    }
}

impl Packet for Lanes {
    type Index = [usize; LANES];

    #[inline(always)]
    fn from_lanes(lanes: [f32; LANES]) -> Self {
        Self(lanes)
    }
    #[inline(always)]
    fn to_lanes(self) -> [f32; LANES] {
        self.0
    }
    #[inline(always)]
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        std::array::from_fn(|i| a[i] & b[i])
    }
    #[inline(always)]
    fn or(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        std::array::from_fn(|i| a[i] | b[i])
    }
    #[inline(always)]
    fn bits(mask: Self::Mask) -> u32 {
        mask.iter()
            .enumerate()
            .fold(0, |bits, (i, &m)| bits | u32::from(m) << i)
    }
    #[inline(always)]
    fn keep(self, mask: Self::Mask) -> Self {
        Self::select(mask, self, Self::splat(0.0))
    }
    #[inline(always)]
    fn to_index(self) -> Self::Index {
        self.0.map(|v| v as usize)
    }
    #[inline(always)]
    fn mul_add_index(a: Self::Index, factor: usize, b: Self::Index) -> Self::Index {
        std::array::from_fn(|i| a[i] * factor + b[i])
    }
    #[inline(always)]
    fn corners<V: Voxel>(grid: &Grid<'_, V>, lower: Self::Index) -> [[[Self; 2]; 2]; 2] {
        grid.corner_lanes(lower)
            .map(|plane| plane.map(|row| row.map(Self)))
    }
    #[inline(always)]
    fn test_bits(words: &[u32], index: Self::Index) -> Self::Mask {
        index.map(|i| words[(i / 32).min(words.len() - 1)] >> (i % 32) & 1 == 1)
    }
    #[inline(always)]
    fn bytes(bytes: &[u8], index: Self::Index) -> Self {
        Self(index.map(|i| f32::from(bytes[i.min(bytes.len() - 1)])))
    }
    #[inline(always)]
    fn rows(table: &[[f32; 8]], row: Self) -> [Self; 8] {
        let rows = row.0.map(|r| table[(r as usize).min(table.len() - 1)]);
        std::array::from_fn(|column| Self(rows.map(|row| row[column])))
    }
}
