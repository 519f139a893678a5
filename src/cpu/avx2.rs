//! Packets in AVX2 registers: the one place with intrinsics.
//!
//! Plain `core::arch` instead of a portable crate: the shared arithmetic ([`Real`]) makes constants without a token that
//! proves the instruction set, which crates with runtime dispatch (fearless_simd) ask for, and crates without (wide) are
//! bound at compile time; gathers, half of this file, none of them has.
//!
//! # Safety
//!
//! Two arguments cover every `unsafe` block here.
//!
//! *Instruction set.* A [`Wide`] exists only below [`tile`], which is entered only where the processor has AVX2
//! (`Path::is_available`, checked when a plan is made): its constructors are private to `cpu`, and every method inlines
//! into that function.
//!
//! *Bounds.* Every gather and load clamps or tests its indices, unsigned, in the same function.
#![allow(unsafe_code)]

use std::any::TypeId;
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::grid::Grid;
use super::march::{Job, Pixel};
use super::packet::{LANES, Packet, Voxel};
use super::tile::TileArea;
use crate::lattice::Real;

/// Draws a tile with AVX2 packets.
#[target_feature(enable = "avx2")]
pub(super) fn tile<V: Voxel, O: Pixel>(job: &Job<'_, V>, area: TileArea, rows: &mut [&mut [O]]) {
    super::tile::draw::<Wide, V, O>(job, area, rows);
}

/// Eight numbers in a register.
#[derive(Clone, Copy)]
pub(super) struct Wide(__m256);

macro_rules! wide_operator {
    ($($trait:ident $method:ident $intrinsic:ident),*) => {$(
        impl $trait for Wide {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: instruction set, see above.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    )*};
}

wide_operator!(Add add _mm256_add_ps, Sub sub _mm256_sub_ps, Mul mul _mm256_mul_ps, Div div _mm256_div_ps);

impl Neg for Wide {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: instruction set, see above.
        Self(unsafe { _mm256_xor_ps(self.0, _mm256_set1_ps(-0.0)) })
    }
}

impl Real for Wide {
    type Mask = __m256;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: instruction set, see above.
        Self(unsafe { _mm256_set1_ps(value as f32) })
    }
    #[inline(always)]
    fn floor(self) -> Self {
        // SAFETY: instruction set, see above.
        Self(unsafe { _mm256_floor_ps(self.0) })
    }
    #[inline(always)]
    fn ceil(self) -> Self {
        // SAFETY: instruction set, see above.
        Self(unsafe { _mm256_ceil_ps(self.0) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: instruction set, see above.
        Self(unsafe { _mm256_sqrt_ps(self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: instruction set, see above.
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> __m256 {
        // SAFETY: instruction set, see above.
        unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn le(self, other: Self) -> __m256 {
        // SAFETY: instruction set, see above.
        unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn select(mask: __m256, yes: Self, no: Self) -> Self {
        // SAFETY: instruction set, see above.
        Self(unsafe { _mm256_blendv_ps(no.0, yes.0, mask) })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: instruction set, see above.
        Self(unsafe { _mm256_min_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: instruction set, see above.
        Self(unsafe { _mm256_max_ps(self.0, other.0) })
    }
}

impl Packet for Wide {
    type Index = __m256i;

    #[inline(always)]
    fn from_lanes(lanes: [f32; LANES]) -> Self {
        // SAFETY: instruction set, see above; the array has the eight floats that are read.
        Self(unsafe { _mm256_loadu_ps(lanes.as_ptr()) })
    }
    #[inline(always)]
    fn to_lanes(self) -> [f32; LANES] {
        let mut lanes = [0.0; LANES];
        // SAFETY: instruction set, see above; the array has the eight floats that are written.
        unsafe { _mm256_storeu_ps(lanes.as_mut_ptr(), self.0) };
        lanes
    }
    #[inline(always)]
    fn and(a: __m256, b: __m256) -> __m256 {
        // SAFETY: instruction set, see above.
        unsafe { _mm256_and_ps(a, b) }
    }
    #[inline(always)]
    fn or(a: __m256, b: __m256) -> __m256 {
        // SAFETY: instruction set, see above.
        unsafe { _mm256_or_ps(a, b) }
    }
    #[inline(always)]
    fn bits(mask: __m256) -> u32 {
        // SAFETY: instruction set, see above.
        unsafe { _mm256_movemask_ps(mask) as u32 }
    }
    #[inline(always)]
    fn keep(self, mask: __m256) -> Self {
        Self(Self::and(self.0, mask))
    }
    #[inline(always)]
    fn to_index(self) -> __m256i {
        // SAFETY: instruction set, see above.
        unsafe { _mm256_cvttps_epi32(self.0) }
    }
    #[inline(always)]
    fn mul_add_index(a: __m256i, factor: usize, b: __m256i) -> __m256i {
        // SAFETY: instruction set, see above.
        unsafe { _mm256_add_epi32(_mm256_mullo_epi32(a, _mm256_set1_epi32(factor as i32)), b) }
    }

    #[inline(always)]
    fn corners<V: Voxel>(grid: &Grid<'_, V>, lower: __m256i) -> [[[Self; 2]; 2]; 2] {
        // A gather reads this many voxels from the index on.
        let read = (4 / size_of::<V>()).max(2);
        let strides = [
            0,
            grid.dims[0],
            grid.dims[0] * grid.dims[1],
            grid.dims[0] * (grid.dims[1] + 1),
        ];
        // The largest index from which all four gathers stay inside; negative where none does.
        let limit = grid.voxels.len() as i64 - (strides[3] + read) as i64;
        let limit = limit.clamp(-1, i64::from(i32::MAX)) as i32;
        // SAFETY: instruction set, see above.
        let inside = unsafe {
            let least = _mm256_min_epu32(lower, _mm256_set1_epi32(limit));
            _mm256_movemask_epi8(_mm256_cmpeq_epi32(least, lower)) == -1
        };
        // A negative limit is a large unsigned number, to be ruled out apart.
        if !(inside && limit >= 0) {
            let mut lanes = [0u32; LANES];
            // SAFETY: instruction set, see above; the array has the 32 bytes that are written.
            unsafe { _mm256_storeu_si256(lanes.as_mut_ptr().cast(), lower) };
            return grid
                .corner_lanes_at_end(lanes)
                .map(|plane| plane.map(|row| row.map(Self::from_lanes)));
        }
        // SAFETY: every lane of `lower` is at most `limit`, so at `lower + stride` there are `read` voxels or more.
        let pair = |stride: usize| unsafe { gather_pair(grid.voxels.as_ptr().add(stride), lower) };
        [
            [pair(strides[0]), pair(strides[1])],
            [pair(strides[2]), pair(strides[3])],
        ]
    }

    #[inline(always)]
    fn test_bits(words: &[u32], index: __m256i) -> __m256 {
        // SAFETY: instruction set, see above; word indices are clamped, unsigned, to the last word, and there are at most
        // 2^27 of them (an index has 32 bits).
        unsafe {
            let last = _mm256_set1_epi32(words.len() as i32 - 1);
            let word = _mm256_min_epu32(_mm256_srli_epi32::<5>(index), last);
            let word = _mm256_i32gather_epi32::<4>(words.as_ptr().cast(), word);
            // Bit i goes to the sign: shift left by 31 - i, that is, by the low bits of !i.
            let shift = _mm256_andnot_si256(index, _mm256_set1_epi32(31));
            let sign = _mm256_sllv_epi32(word, shift);
            _mm256_castsi256_ps(_mm256_srai_epi32::<31>(sign))
        }
    }

    #[inline(always)]
    fn bytes(bytes: &[u8], index: __m256i) -> Self {
        // A gather reads four bytes: those that end with the wanted one where it is not among the first three.
        if bytes.len() < 4 {
            let mut lanes = [0u32; LANES];
            // SAFETY: instruction set, see above; the array has the 32 bytes that are written.
            unsafe { _mm256_storeu_si256(lanes.as_mut_ptr().cast(), index) };
            let lanes = lanes.map(|i| f32::from(bytes[(i as usize).min(bytes.len() - 1)]));
            return Self::from_lanes(lanes);
        }
        assert!(
            i32::try_from(bytes.len()).is_ok(),
            "gathers have signed indices"
        );
        // SAFETY: instruction set, see above; addresses are clamped, unsigned, to the last that has four bytes.
        unsafe {
            let last = _mm256_set1_epi32(bytes.len() as i32 - 1);
            let index = _mm256_min_epu32(index, last);
            let address = _mm256_min_epu32(index, _mm256_sub_epi32(last, _mm256_set1_epi32(3)));
            let word = _mm256_i32gather_epi32::<1>(bytes.as_ptr().cast(), address);
            let shift = _mm256_slli_epi32::<3>(_mm256_sub_epi32(index, address));
            let byte = _mm256_and_si256(_mm256_srlv_epi32(word, shift), _mm256_set1_epi32(0xff));
            Self(_mm256_cvtepi32_ps(byte))
        }
    }

    /// Eight loads of a row each and a transposition: eight gathers would be three times as many loads.
    #[inline(always)]
    fn rows(table: &[[f32; 8]], row: Self) -> [Self; 8] {
        assert!(!table.is_empty());
        let mut index = [0u32; LANES];
        // SAFETY: instruction set, see above; indices are clamped, unsigned, to the last row.
        unsafe {
            let last = _mm256_set1_epi32(table.len() as i32 - 1);
            let row = _mm256_min_epu32(_mm256_cvttps_epi32(row.0), last);
            _mm256_storeu_si256(index.as_mut_ptr().cast(), row);
            let at = |lane: usize, half: usize| {
                _mm_loadu_ps(
                    table
                        .as_ptr()
                        .add(index[lane] as usize)
                        .cast::<f32>()
                        .add(half * 4),
                )
            };
            let mut columns = [row_zero(); 8];
            for half in 0..2 {
                // Lanes 0 to 3 below, 4 to 7 above; then a 4x4 transposition in each.
                let r: [__m256; 4] =
                    std::array::from_fn(|i| _mm256_set_m128(at(i + 4, half), at(i, half)));
                let low = [
                    _mm256_unpacklo_ps(r[0], r[1]),
                    _mm256_unpacklo_ps(r[2], r[3]),
                ];
                let high = [
                    _mm256_unpackhi_ps(r[0], r[1]),
                    _mm256_unpackhi_ps(r[2], r[3]),
                ];
                columns[half * 4] = Self(_mm256_shuffle_ps::<0x44>(low[0], low[1]));
                columns[half * 4 + 1] = Self(_mm256_shuffle_ps::<0xee>(low[0], low[1]));
                columns[half * 4 + 2] = Self(_mm256_shuffle_ps::<0x44>(high[0], high[1]));
                columns[half * 4 + 3] = Self(_mm256_shuffle_ps::<0xee>(high[0], high[1]));
            }
            columns
        }
    }
}

#[inline(always)]
fn row_zero() -> Wide {
    Wide::splat(0.0)
}

/// The voxels at `base + index` and the ones after, as numbers.
///
/// # Safety
/// The processor has AVX2; from each index on, as a signed number, `max(2, 4 / size_of::<V>())` voxels can be read.
#[inline(always)]
unsafe fn gather_pair<V: Voxel>(base: *const V, index: __m256i) -> [Wide; 2] {
    let is = |t: TypeId| TypeId::of::<V>() == t;
    // SAFETY: the caller's promises; each branch reads as many bytes as the promise covers.
    unsafe {
        if is(TypeId::of::<f32>()) {
            // Four 64-bit gathers' worth in two: lanes 0, 1, 4, 5 and 2, 3, 6, 7, so that one shuffle sorts each result.
            let order = _mm256_permute4x64_epi64::<0b11_01_10_00>(index);
            let quad = |i: __m128i| _mm256_castpd_ps(_mm256_i32gather_pd::<4>(base.cast(), i));
            let low = quad(_mm256_castsi256_si128(order));
            let high = quad(_mm256_extracti128_si256::<1>(order));
            return [
                Wide(_mm256_shuffle_ps::<0x88>(low, high)),
                Wide(_mm256_shuffle_ps::<0xdd>(low, high)),
            ];
        }
        let [a, b] = if is(TypeId::of::<u8>()) {
            let pair = _mm256_i32gather_epi32::<1>(base.cast(), index);
            let byte = _mm256_set1_epi32(0xff);
            [
                _mm256_and_si256(pair, byte),
                _mm256_and_si256(_mm256_srli_epi32::<8>(pair), byte),
            ]
        } else if is(TypeId::of::<i8>()) {
            let pair = _mm256_i32gather_epi32::<1>(base.cast(), index);
            [
                _mm256_srai_epi32::<24>(_mm256_slli_epi32::<24>(pair)),
                _mm256_srai_epi32::<24>(_mm256_slli_epi32::<16>(pair)),
            ]
        } else if is(TypeId::of::<u16>()) {
            let pair = _mm256_i32gather_epi32::<2>(base.cast(), index);
            [
                _mm256_and_si256(pair, _mm256_set1_epi32(0xffff)),
                _mm256_srli_epi32::<16>(pair),
            ]
        } else {
            assert!(is(TypeId::of::<i16>()), "five voxel types");
            let pair = _mm256_i32gather_epi32::<2>(base.cast(), index);
            [
                _mm256_srai_epi32::<16>(_mm256_slli_epi32::<16>(pair)),
                _mm256_srai_epi32::<16>(pair),
            ]
        };
        [Wide(_mm256_cvtepi32_ps(a)), Wide(_mm256_cvtepi32_ps(b))]
    }
}
