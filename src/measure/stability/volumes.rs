//! Small volumes that are hard for someone: walls where a method looks for none, or none where it looks for walls.

use glam::{DMat3, DVec3};

use crate::volume::{Rescale, Volume, Voxels, phantom};

/// The stored number of matter: that of the phantoms.
pub(super) const MATTER: u8 = phantom::MATERIAL;

/// A volume of unit spacing around these voxels.
pub(super) fn volume(name: &str, dims: [usize; 3], voxels: Voxels) -> Volume {
    Volume {
        name: name.to_owned(),
        dims,
        spacing: DVec3::ONE,
        origin: DVec3::ZERO,
        direction: DMat3::IDENTITY,
        rescale: Rescale::IDENTITY,
        voxels,
        warnings: Vec::new(),
    }
}

/// Bytes, given voxel by voxel.
pub(super) fn bytes(name: &str, dims: [usize; 3], value: impl Fn([usize; 3]) -> u8) -> Volume {
    volume(name, dims, Voxels::U8(numbers(dims, value).into()))
}

/// Numbers of any type, given voxel by voxel, x fastest.
pub(super) fn numbers<T>(dims: [usize; 3], value: impl Fn([usize; 3]) -> T) -> Vec<T> {
    let [nx, ny, nz] = dims;
    (0..nx * ny * nz)
        .map(|i| value([i % nx, i / nx % ny, i / (nx * ny)]))
        .collect()
}

/// A cube of bytes, matter where `is_matter` says so.
pub(super) fn carved(name: &str, n: usize, is_matter: impl Fn([usize; 3]) -> bool) -> Volume {
    bytes(name, [n; 3], |at| if is_matter(at) { MATTER } else { 0 })
}

/// Distance of a voxel's centre from the middle of a cube of `n` voxels.
pub(super) fn radius(at: [usize; 3], n: usize) -> f64 {
    let centre = DVec3::splat(n as f64 * 0.5);
    (DVec3::from_array(at.map(|i| i as f64 + 0.5)) - centre).length()
}

/// Concentric spheres, evenly from the middle to the faces, so that a central ray crosses `walls` of them: each two voxels
/// thick, or half of their distance where that is less (1.44 voxels for 16 walls in 48).
pub(super) fn shells(n: usize, walls: usize) -> Volume {
    let spheres = walls.div_ceil(2) as f64;
    let pitch = n as f64 * 0.48 / spheres;
    carved("shells", n, |at| {
        let r = radius(at, n);
        r < pitch * spheres && r % pitch >= (pitch - 2.0).max(0.5 * pitch)
    })
}

/// A sheet rolled up around z: a ray across it meets wall after wall.
pub(super) fn spiral(n: usize) -> Volume {
    carved("spiral", n, |[x, y, _]| {
        let half = n as f64 * 0.5;
        let (dx, dy) = (x as f64 + 0.5 - half, y as f64 + 0.5 - half);
        let turn = dy.atan2(dx) / std::f64::consts::TAU;
        let r = dx.hypot(dy);
        // Six voxels from layer to layer, two of them matter.
        r < half - 1.0 && (r - 6.0 * turn).rem_euclid(6.0) < 2.0
    })
}

/// A block of matter with a cavity between two planes across each axis, in parts of the edge.
pub(super) fn cavity(n: usize, from: f64, to: f64) -> Volume {
    let inside = |i: usize| (from..to).contains(&((i as f64 + 0.5) / n as f64));
    let wide = |i: usize| (0.1..0.9).contains(&((i as f64 + 0.5) / n as f64));
    carved("cavity", n, |[x, y, z]| !(inside(z) && wide(x) && wide(y)))
}

/// A hollow cube whose wall is `thickness` voxels, of the number `value`.
pub(super) fn case(n: usize, thickness: usize, value: u8) -> Volume {
    bytes("case", [n; 3], |at| {
        let depth = at.iter().map(|&i| i.min(n - 1 - i)).min().unwrap_or(0);
        if (2..2 + thickness).contains(&depth) {
            value
        } else {
            0
        }
    })
}

/// One voxel of matter in every block of `block` voxels, at another corner of each.
pub(super) fn one_per_block(n: usize, block: usize) -> Volume {
    carved("one voxel per block", n, |at| {
        let place: usize = at.iter().map(|i| i / block).sum();
        at.iter()
            .enumerate()
            .all(|(a, i)| i % block == if place >> a & 1 == 0 { 0 } else { block - 1 })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_central_ray_crosses_as_many_walls_as_said() {
        let n = 48;
        for walls in [2, 4, 8, 16] {
            let volume = shells(n, walls);
            let Voxels::U8(voxels) = &volume.voxels else {
                panic!("bytes")
            };
            let row = &voxels[n / 2 * n * (n + 1)..][..n];
            let begins = row.windows(2).filter(|w| w[0] == 0 && w[1] != 0).count();
            assert_eq!(begins + usize::from(row[0] != 0), walls);
        }
    }
}
