//! The smooth phantoms as signed distances: negative inside the material.
//!
//! Lengths are in halves of the box's shortest edge, about its centre; z points up.

use glam::{DVec2, DVec3};

use super::MATERIAL;

/// A shape of one or more materials.
pub(super) trait Solid: Sync {
    /// Signed distance to the material at `p` (exact near walls, no larger than the true one elsewhere), and the
    /// stored number of the nearest material.
    fn distance(&self, p: DVec3) -> (f64, u8);

    /// No larger than the straight distance from `p` to any material.
    fn least_distance(&self, p: DVec3) -> f64 {
        self.distance(p).0
    }
}

/// A shape of one material given by a function.
struct One<F>(F);

impl<F: Fn(DVec3) -> f64 + Sync> Solid for One<F> {
    fn distance(&self, p: DVec3) -> (f64, u8) {
        ((self.0)(p), MATERIAL)
    }
}

/// Distance to the surface of a ball, thickened.
fn shell(p: DVec3, radius: f64, half_wall: f64) -> f64 {
    (p.length() - radius).abs() - half_wall
}

fn capsule(p: DVec3, a: DVec3, b: DVec3, radius: f64) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    (p - a - along * t).length() - radius
}

/// A ring about the y axis through `centre`.
fn ring(p: DVec3, centre: DVec3, radius: f64, thickness: f64) -> f64 {
    let q = p - centre;
    DVec2::new(DVec2::new(q.x, q.z).length() - radius, q.y).length() - thickness
}

pub(super) fn sphere() -> impl Solid {
    One(|p: DVec3| shell(p, 0.8, 0.06))
}

/// Three shells, each of its own material.
struct Shells;

impl Solid for Shells {
    fn distance(&self, p: DVec3) -> (f64, u8) {
        [(0.88, 160), (0.6, MATERIAL), (0.32, 240)]
            .into_iter()
            .map(|(radius, material)| (shell(p, radius, 0.04), material))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or((f64::INFINITY, 0))
    }
}

pub(super) fn shells() -> impl Solid {
    Shells
}

/// A body (a hollow ball with a flat rim), a spout whose bore opens into the body, a handle, and a dumbbell inside.
pub(super) fn pot() -> impl Solid {
    const WALL: f64 = 0.045;
    One(|p: DVec3| {
        let body = DVec3::new(0.0, 0.0, -0.08);
        let outer = (p - body).length() - 0.56;
        let inner = (p - body).length() - (0.56 - WALL);
        let (foot, tip) = (DVec3::new(0.42, 0.0, -0.2), DVec3::new(0.84, 0.0, 0.3));
        // Cut off square at the tip, where the bore goes on: open.
        let beyond_tip = (p - tip).dot((tip - foot).normalize());
        let spout = capsule(p, foot, tip, 0.13).max(beyond_tip);
        let bore = capsule(p, foot, tip + (tip - foot) * 0.5, 0.13 - WALL);
        let handle = ring(p, DVec3::new(-0.6, 0.0, -0.05), 0.27, 0.055);
        let opening = (DVec2::new(p.x, p.y).length() - 0.24).max(-p.z);
        let pot = outer
            .min(spout)
            .min(handle)
            .max(-inner)
            .max(-bore)
            .max(-opening);
        let inside = capsule(
            p,
            DVec3::new(-0.15, -0.1, -0.35),
            DVec3::new(0.15, 0.12, -0.12),
            0.05,
        )
        .min((p - DVec3::new(-0.15, -0.1, -0.35)).length() - 0.11)
        .min((p - DVec3::new(0.15, 0.12, -0.12)).length() - 0.13);
        pot.min(inside)
    })
}

pub(super) fn capsules() -> impl Solid {
    One(|p: DVec3| {
        let bone = |ax, ay, az, bx, by, bz, radius| {
            capsule(p, DVec3::new(ax, ay, az), DVec3::new(bx, by, bz), radius)
        };
        let leg = bone(-0.5, 0.0, -0.3, -0.5, 0.0, 0.75, 0.17);
        let heel = bone(-0.7, 0.0, -0.55, -0.3, 0.0, -0.45, 0.2);
        let instep = bone(-0.35, 0.0, -0.45, 0.25, 0.05, -0.55, 0.18);
        let toes = (0..5)
            .map(|i| {
                let y = -0.26 + 0.13 * f64::from(i);
                bone(
                    0.2,
                    y * 0.6,
                    -0.58,
                    0.78 - 0.06 * f64::from(i),
                    y,
                    -0.66,
                    0.055,
                )
            })
            .fold(f64::INFINITY, f64::min);
        leg.min(heel).min(instep).min(toes)
    })
}

/// A sheet of sin x cos y + sin y cos z + sin z cos x = 0, cut off by a ball.
struct Gyroid;

impl Solid for Gyroid {
    fn distance(&self, p: DVec3) -> (f64, u8) {
        const WAVE: f64 = 9.0;
        const HALF_WALL: f64 = 0.035;
        let (sx, cx) = (p.x * WAVE).sin_cos();
        let (sy, cy) = (p.y * WAVE).sin_cos();
        let (sz, cz) = (p.z * WAVE).sin_cos();
        let value = sx * cy + sy * cz + sz * cx;
        let gradient = DVec3::new(cx * cy - sz * sx, cy * cz - sx * sy, cz * cx - sy * sz) * WAVE;
        // To first order, which is near the wall where it counts; the slope is nowhere zero there.
        let sheet = value.abs() / gradient.length().max(WAVE * 0.5) - HALF_WALL;
        (sheet.max(p.length() - 0.9), MATERIAL)
    }

    fn least_distance(&self, p: DVec3) -> f64 {
        // Of the first-order distance nothing is known far from the sheet: only the ball bounds it.
        p.length() - 0.9
    }
}

pub(super) fn gyroid() -> impl Solid {
    Gyroid
}
