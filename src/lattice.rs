//! The one sample lattice of every ray, and the arithmetic that all backends share.
//!
//! Sample `k` of a ray lies at `t_k = t_box + (k + 1/2) * step`, where `t_box` is the ray's *unclamped* entry into the
//! volume's box. In grid coordinates (voxel i's centre at i + 1/2, the box [0, N] per axis) that is
//! `entry + (k + 1/2) * delta`, recomputed from `k`, never accumulated. Nothing else may place a sample: the eye, clip
//! planes and skipping methods only restrict the range of `k`.
//!
//! The functions here are generic over [`Real`], so that the f64 reference, the scalar twin and the SIMD packets run
//! the same operations in the same order; `shaders/shared/ray.inc.wgsl` is their twin on the GPU.

mod clipping;

use std::ops::{Add, Div, Mul, Neg, Sub};

use glam::DVec3;

pub use clipping::{Clipping, MAX_CLIP_PLANES};

/// A number, or a packet of numbers, that rays are computed in.
///
/// Every operation is one correctly rounded IEEE operation per lane and none is fused, so that all implementations of
/// the same width give the same bits.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The result of a comparison: a bool, or one per lane.
    type Mask: Copy;

    /// The nearest representable number, in every lane.
    fn splat(value: f64) -> Self;
    /// Largest integer not above.
    fn floor(self) -> Self;
    /// Smallest integer not below.
    fn ceil(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Magnitude.
    fn abs(self) -> Self;
    /// `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `yes` where `mask` holds, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// The smaller; the second where they compare equal (as the `minps` instruction has it).
    fn min(self, other: Self) -> Self {
        Self::select(self.lt(other), self, other)
    }

    /// The larger; the second where they compare equal.
    fn max(self, other: Self) -> Self {
        Self::select(other.lt(self), self, other)
    }
}

macro_rules! scalar_real {
    ($t:ty) => {
        impl Real for $t {
            type Mask = bool;

            #[inline(always)]
            #[allow(clippy::cast_possible_truncation, clippy::cast_lossless)]
            fn splat(value: f64) -> Self {
                value as $t
            }
            #[inline(always)]
            fn floor(self) -> Self {
                self.floor()
            }
            #[inline(always)]
            fn ceil(self) -> Self {
                self.ceil()
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }
            #[inline(always)]
            fn lt(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn le(self, other: Self) -> bool {
                self <= other
            }
            #[inline(always)]
            fn select(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }
        }
    };
}

scalar_real!(f32);
scalar_real!(f64);

/// Direction components below this magnitude count as exactly zero: the ray is parallel to that axis.
///
/// A unit direction this flat moves less than 2^-20 voxel across any box; without the cut its crossings overflow f32.
pub const PARALLEL: f64 = 1.0 / (1u64 << 40) as f64;

/// A sample this near to the near plane or the box's exit, in steps, counts as inside at the one and outside at the
/// other. Eyes at voxel centres and steps of half a voxel put samples exactly there, and then rounding would decide
/// otherwise in f32 than in f64; this moves the decision to where nobody puts an eye.
pub const EDGE: f64 = 1.0 / 1024.0;

/// The most samples one ray may have: indices stay exact in f32.
pub const MAX_SAMPLES_PER_RAY: f64 = (1u64 << 24) as f64;

/// All rays of one picture: affine in the pixel, in local coordinates (box [0, extent], unit: the smallest spacing).
///
/// Made in f64 by [`crate::camera::Camera::ray_frame`]; rays start on a plane just outside the box (or through the eye,
/// where that is nearer), so that a far camera costs no precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayFrame {
    /// Where the ray through the picture's centre starts.
    pub start: DVec3,
    /// Change of the start per pixel to the right.
    pub start_dx: DVec3,
    /// Change of the start per pixel downwards.
    pub start_dy: DVec3,
    /// Direction of the ray through the picture's centre; unit length.
    pub dir: DVec3,
    /// Change of the direction, before it is normalised, per pixel to the right.
    pub dir_dx: DVec3,
    /// The same, downwards.
    pub dir_dy: DVec3,
    /// Edges of the box.
    pub extent: DVec3,
    /// Voxels per local unit, per axis.
    pub grid_from_local: DVec3,
    /// Distance of two samples, in local units.
    pub step: f64,
    /// Picture width and height in pixels.
    pub size: [u32; 2],
    /// What is cut off the rays.
    pub clipping: Clipping,
    /// How far a sample reaches along its ray to both sides, in steps: 0, or 1/2 where it stands for an interval between
    /// `t_box + k * step` and `t_box + (k + 1) * step`.
    pub reach: f64,
}

/// One ray (or one per lane) on its lattice, in grid coordinates.
#[derive(Debug, Clone, Copy)]
pub struct Ray<R> {
    /// Where the ray enters the box; sample k lies at `entry + (k + 1/2) * delta`.
    pub entry: [R; 3],
    /// Grid increment from one sample to the next; exactly 0 on axes that the ray is parallel to.
    pub delta: [R; 3],
    /// First index in front of the near plane; an integer, at least 0.
    pub k_near: R,
    /// One past the last index inside the box; an integer. The ray misses the box where `k_end <= k_near`.
    pub k_end: R,
    /// Unclamped entry into the box, in local units along the ray from its start.
    pub t_box: R,
    /// Where the part of the ray that is drawn begins and ends, in steps from its entry into the box: what the near plane,
    /// clip planes and the box's exit leave.
    pub drawn: [R; 2],
    /// See [`RayFrame::reach`].
    pub reach: R,
}

impl<R: Real> Ray<R> {
    /// Grid position of sample `k` (an integer).
    #[inline(always)]
    pub fn at(&self, k: R) -> [R; 3] {
        let s = k + R::splat(0.5);
        [
            self.entry[0] + s * self.delta[0],
            self.entry[1] + s * self.delta[1],
            self.entry[2] + s * self.delta[2],
        ]
    }

    /// Grid position of the end that intervals `k - 1` and `k` share, moved to the nearest point that is drawn: beyond
    /// the box, where clamped voxels go on, a ray meets blocks that no method looks for.
    #[inline(always)]
    pub fn interval_end(&self, k: R) -> [R; 3] {
        self.at(k.max(self.drawn[0]).min(self.drawn[1]) - R::splat(0.5))
    }
}

/// A [`RayFrame`] rounded to the numbers that rays are computed in.
#[derive(Debug, Clone, Copy)]
pub struct RayBasis<R> {
    start: [[R; 3]; 3],
    dir: [[R; 3]; 3],
    extent: [R; 3],
    grid_from_local: [R; 3],
    step: R,
    centre: [R; 2],
    clipping: Clipping,
    reach: R,
}

impl RayFrame {
    /// Rounds the frame to `R`.
    pub fn basis<R: Real>(&self) -> RayBasis<R> {
        let v = |v: DVec3| v.to_array().map(R::splat);
        RayBasis {
            start: [v(self.start), v(self.start_dx), v(self.start_dy)],
            dir: [v(self.dir), v(self.dir_dx), v(self.dir_dy)],
            extent: v(self.extent),
            grid_from_local: v(self.grid_from_local),
            step: R::splat(self.step),
            centre: [
                R::splat(f64::from(self.size[0]) * 0.5 - 0.5),
                R::splat(f64::from(self.size[1]) * 0.5 - 0.5),
            ],
            clipping: self.clipping,
            reach: R::splat(self.reach),
        }
    }

    /// The most samples any ray of this frame can take: the box's diagonal over the step.
    pub fn max_samples(&self) -> f64 {
        (self.extent.length() / self.step).ceil() + 1.0
    }
}

impl<R: Real> RayBasis<R> {
    /// The ray through pixel (x, y), both integers, (0, 0) at the top left. A function of the pixel alone.
    #[inline(always)]
    pub fn ray(&self, x: R, y: R) -> Ray<R> {
        let zero = R::splat(0.0);
        let one = R::splat(1.0);
        let far = R::splat(1e30);
        let px = x - self.centre[0];
        let py = y - self.centre[1];
        let v = [
            affine(&self.dir, 0, px, py),
            affine(&self.dir, 1, px, py),
            affine(&self.dir, 2, px, py),
        ];
        let norm = one / (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();

        let mut t_in = -far;
        let mut t_out = far;
        let mut origin = [zero; 3];
        let mut d = [zero; 3];
        for a in 0..3 {
            origin[a] = affine(&self.start, a, px, py);
            let raw = v[a] * norm;
            let parallel = raw.abs().lt(R::splat(PARALLEL));
            d[a] = R::select(parallel, zero, raw);
            // A parallel ray is inside this slab for ever or never: divide by one and replace the result.
            let inverse = one / R::select(parallel, one, raw);
            let t0 = (zero - origin[a]) * inverse;
            let t1 = (self.extent[a] - origin[a]) * inverse;
            let below = origin[a].lt(zero);
            let above = self.extent[a].lt(origin[a]);
            let parallel_in = R::select(below, far, R::select(above, far, -far));
            t_in = t_in.max(R::select(parallel, parallel_in, t0.min(t1)));
            t_out = t_out.min(R::select(parallel, far, t0.max(t1)));
        }

        let missed = t_out.lt(t_in);
        let t_box = R::select(missed, zero, t_in);
        let length = R::select(missed, zero, t_out - t_in);
        let half_and_edge = R::splat(0.5 + EDGE);
        let mut k_near = ((zero - t_box) / self.step - half_and_edge)
            .ceil()
            .max(zero);
        let mut k_end = (length / self.step - half_and_edge).ceil().max(zero);
        let mut drawn = [((zero - t_box) / self.step).max(zero), length / self.step];
        for plane in self.clipping.planes() {
            let [nx, ny, nz, distance] = plane.map(R::splat);
            let height = nx * origin[0] + ny * origin[1] + nz * origin[2] + distance;
            let along = nx * d[0] + ny * d[1] + nz * d[2];
            let parallel = along.abs().lt(R::splat(PARALLEL));
            let t = (zero - height) / R::select(parallel, one, along);
            let s = (t - t_box) / self.step;
            let k = (s - half_and_edge).ceil();
            // Where the ray passes the plane, one of its sides begins with the sample that the other ends before.
            let enters = R::select(zero.lt(along), k_near.max(k), k_near);
            let leaves = R::select(zero.lt(along), k_end, k_end.min(k));
            let beside = R::select(height.lt(zero), zero, k_end);
            k_near = R::select(parallel, k_near, enters);
            k_end = R::select(parallel, beside, leaves).max(zero);
            let from = R::select(zero.lt(along), drawn[0].max(s), drawn[0]);
            let to = R::select(zero.lt(along), drawn[1], drawn[1].min(s));
            drawn = [
                R::select(parallel, drawn[0], from),
                R::select(parallel, drawn[1], to),
            ];
        }
        let k_near = k_near.min(k_end);
        let mut entry = [zero; 3];
        let mut delta = [zero; 3];
        for a in 0..3 {
            entry[a] = (origin[a] + t_box * d[a]) * self.grid_from_local[a];
            delta[a] = d[a] * self.step * self.grid_from_local[a];
        }
        Ray {
            entry,
            delta,
            k_near,
            k_end,
            t_box,
            drawn,
            reach: self.reach,
        }
    }
}

/// A vector that is affine in the pixel. A function, not a closure: see [`crate::sample::trilinear`].
#[inline(always)]
fn affine<R: Real>(m: &[[R; 3]; 3], axis: usize, px: R, py: R) -> R {
    m[0][axis] + px * m[1][axis] + py * m[2][axis]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(dir: DVec3, start: DVec3, step: f64) -> RayFrame {
        RayFrame {
            start,
            start_dx: DVec3::ZERO,
            start_dy: DVec3::ZERO,
            dir: dir.normalize(),
            dir_dx: DVec3::ZERO,
            dir_dy: DVec3::ZERO,
            extent: DVec3::new(8.0, 6.0, 4.0),
            grid_from_local: DVec3::ONE,
            step,
            size: [1, 1],
            clipping: Clipping::NONE,
            reach: 0.0,
        }
    }

    #[test]
    fn an_axis_parallel_ray_takes_every_sample_of_its_chord() {
        let ray = frame(DVec3::X, DVec3::new(-3.0, 2.0, 2.0), 0.5)
            .basis::<f64>()
            .ray(0.0, 0.0);
        assert_eq!((ray.k_near, ray.k_end), (0.0, 16.0));
        assert_eq!(ray.at(0.0), [0.25, 2.0, 2.0]);
        assert_eq!(ray.delta, [0.5, 0.0, 0.0]);
    }

    #[test]
    fn a_clip_plane_and_its_reverse_share_the_samples_out() {
        let mut frame = frame(DVec3::new(1.0, 0.2, 0.1), DVec3::new(-3.0, 2.0, 2.0), 0.25);
        let whole = frame.basis::<f64>().ray(0.0, 0.0);
        let clipped = |normal: DVec3, offset: f64| {
            let mut frame = frame;
            frame.clipping.keep(normal, offset).unwrap();
            frame.basis::<f64>().ray(0.0, 0.0)
        };
        // The second plane has a sample on it, which the kept side above takes.
        for (normal, offset) in [
            (DVec3::new(1.0, -0.3, 0.2), 3.3),
            (DVec3::X, whole.at(7.0)[0]),
        ] {
            let above = clipped(normal, offset);
            let below = clipped(-normal, -offset);
            assert_eq!((above.k_end, below.k_near), (whole.k_end, whole.k_near));
            assert_eq!(above.k_near, below.k_end);
            assert_eq!(above.at(9.0), whole.at(9.0));
            let height = |k: f64| normal.dot(DVec3::from_array(whole.at(k))) - offset;
            assert!(height(above.k_near) >= -1e-9 && height(above.k_near - 1.0) < 0.0);
        }
        // Parallel planes keep all or nothing.
        frame.dir = DVec3::X;
        let side = |sign: f64| {
            let mut frame = frame;
            frame.clipping.keep(sign * DVec3::Y, sign * 1.0).unwrap();
            let ray = frame.basis::<f32>().ray(0.0, 0.0);
            ray.k_end - ray.k_near
        };
        assert_eq!((side(1.0), side(-1.0)), (32.0, 0.0));
    }

    #[test]
    fn a_parallel_ray_outside_the_slab_misses() {
        for z in [-0.1, 4.1] {
            let ray = frame(DVec3::X, DVec3::new(-3.0, 2.0, z), 0.5)
                .basis::<f32>()
                .ray(0.0, 0.0);
            assert!(ray.k_end <= ray.k_near, "z = {z}");
            assert!(ray.at(0.0).iter().all(|c| c.is_finite()));
        }
    }

    #[test]
    fn the_near_plane_restricts_the_range_but_does_not_move_the_lattice() {
        let outside = frame(DVec3::new(1.0, 0.2, 0.1), DVec3::new(0.0, 2.0, 2.0), 0.3)
            .basis::<f64>()
            .ray(0.0, 0.0);
        let d = DVec3::new(1.0, 0.2, 0.1).normalize();
        let inside = frame(d, DVec3::new(0.0, 2.0, 2.0) + d * 3.0, 0.3)
            .basis::<f64>()
            .ray(0.0, 0.0);
        assert_eq!(outside.k_end, inside.k_end);
        assert_eq!(inside.k_near, 10.0); // (9 + 1/2) * 0.3 < 3 <= (10 + 1/2) * 0.3
        for a in 0..3 {
            assert!((outside.at(7.0)[a] - inside.at(7.0)[a]).abs() < 1e-12);
        }
    }
}
