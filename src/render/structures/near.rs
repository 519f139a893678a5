//! What is near the eye: the order of slabs, and parts whose faces the near plane may clip.

use std::ops::Range;

use glam::DVec3;

use crate::camera::{Camera, Projection};
use crate::octree::Occupancy;
use crate::scene::Scene;

/// Slabs between `planes` (local coordinates along `axis`), in an order that serves every ray of the camera: outward from
/// the one that the eye is in, or from the first one that parallel rays meet. A ray leaves that slab upwards or downwards
/// and never turns, so that the slabs of the other side are none of its own, whichever side is listed first.
pub(super) fn near_first(
    camera: &Camera,
    axis: usize,
    planes: &[f64],
) -> impl Iterator<Item = usize> {
    let nearest = match camera.projection {
        Projection::Perspective { .. } => planes.partition_point(|&p| p <= camera.eye[axis]),
        Projection::Orthographic { .. } if camera.forward()[axis] > 0.0 => 0,
        Projection::Orthographic { .. } => planes.len(),
    };
    (nearest..=planes.len()).chain((0..nearest).rev())
}

/// Whether an active block of a region lies where rays start, give or take the larger of one sample and half a voxel:
/// its front face may be clipped there.
pub(super) fn starts_near(
    occupancy: &Occupancy,
    region: &[Range<usize>; 3],
    camera: &Camera,
    scene: &Scene,
) -> bool {
    let block_size = scene.volume.voxel_size() * occupancy.block as f64;
    // Faces grow up to half a voxel and are clipped a 64th before the eye's plane, more towards a wide picture's corners.
    let reach = scene.frame.step.max(0.5) + 1.0;
    let is_touched = |low: DVec3, high: DVec3| match camera.projection {
        Projection::Perspective { .. } => {
            camera.eye.cmpge(low - reach).all() && camera.eye.cmple(high + reach).all()
        }
        Projection::Orthographic { .. } => {
            // Depth of the box before the eye's plane: from its nearest to its farthest corner.
            let forward = camera.forward();
            let centre = ((low + high) * 0.5 - camera.eye).dot(forward);
            let half = ((high - low) * 0.5).dot(forward.abs());
            (centre - half..=centre + half).contains(&0.0) || (centre.abs() - half).abs() <= reach
        }
    };
    // Only blocks near the eye (or its plane) are looked at one by one.
    let bounds = |b: [usize; 3], e: [usize; 3]| {
        let v = |b: [usize; 3]| DVec3::from_array(b.map(|n| n as f64)) * block_size;
        is_touched(v(b), v(e))
    };
    if !bounds(
        region.clone().map(|r| r.start),
        region.clone().map(|r| r.end),
    ) {
        return false;
    }
    region[2].clone().any(|z| {
        bounds(
            [region[0].start, region[1].start, z],
            [region[0].end, region[1].end, z + 1],
        ) && region[1].clone().any(|y| {
            bounds([region[0].start, y, z], [region[0].end, y + 1, z + 1])
                && region[0]
                    .clone()
                    .any(|x| occupancy.get([x, y, z]) && bounds([x, y, z], [x + 1, y + 1, z + 1]))
        })
    })
}
