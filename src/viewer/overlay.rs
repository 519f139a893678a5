//! What is drawn over the picture: the octree's active leaves, the hull's faces and the plane of the cut.

use glam::{DMat4, DVec3};

use crate::camera::Camera;
use crate::error::Result;
use crate::mode::Mode;
use crate::octree::{Accelerator, Face, Hull, Occupancy};
use crate::render::Settings;
use crate::sample::Sampler;
use crate::skip::half_axis;
use crate::transfer::{Domain, TransferFunction};
use crate::volume::{Volume, statistics};

/// The most rectangles that are drawn; of more, every n-th is.
pub const MOST: usize = 6000;

/// A rectangle in local coordinates, its corners in turn.
pub type Rectangle = [DVec3; 4];

/// What stands of the blocks of one volume, transfer function, mode and block size.
#[derive(Debug)]
pub struct Overlay {
    occupancy: Occupancy,
    /// Edges of a block, local units.
    block: DVec3,
    /// Edges of the box, local units.
    extent: DVec3,
}

/// What an overlay follows from.
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    /// The transfer function.
    pub transfer: TransferFunction,
    /// The mode.
    pub mode: Mode,
    /// Block edge in voxels.
    pub block: usize,
    /// The step, for which the table is baked.
    pub step_voxels: f64,
    /// Entries of the table.
    pub table_entries: usize,
    /// Voxels around a block that samples in it may touch.
    pub apron: usize,
}

impl Key {
    /// What a picture's overlay follows from.
    pub fn of(transfer: &TransferFunction, settings: &Settings, sampler: Sampler) -> Self {
        Self {
            transfer: transfer.clone(),
            mode: settings.mode,
            block: settings.block,
            step_voxels: settings.step_voxels,
            table_entries: settings.table_entries,
            apron: sampler.apron(),
        }
    }
}

impl Overlay {
    /// Classifies the volume's blocks.
    ///
    /// # Errors
    /// [`crate::Error::Setting`] for a block or table size that there is not.
    pub fn new(volume: &Volume, key: &Key) -> Result<Self> {
        let accelerator = Accelerator::build(volume, key.block, key.apron)?;
        let range = statistics::stored_range(volume);
        let domain = Domain::new(volume, range, key.table_entries)?;
        let table = key.transfer.bake(&domain, key.step_voxels);
        Ok(Self {
            occupancy: accelerator.cull(&table, key.mode),
            block: volume.voxel_size() * key.block as f64,
            extent: volume.extent(),
        })
    }

    /// Active leaves and all of them.
    pub fn counts(&self) -> [usize; 2] {
        [self.occupancy.count(), self.occupancy.dims.iter().product()]
    }

    /// All faces of the active leaves that nothing active lies before, leaf by leaf.
    pub fn leaves(&self) -> Vec<Rectangle> {
        let [nx, ny, nz] = self.occupancy.dims;
        let dims = [nx, ny, nz];
        let all =
            (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
        let mut rectangles = Vec::new();
        for at in all.filter(|&at| self.occupancy.get(at)) {
            for axis in 0..3 {
                for positive in [false, true] {
                    let mut beside = at;
                    let outside = if positive {
                        beside[axis] += 1;
                        beside[axis] >= dims[axis]
                    } else {
                        let outside = beside[axis] == 0;
                        beside[axis] = beside[axis].saturating_sub(1);
                        outside
                    };
                    if outside || !self.occupancy.get(beside) {
                        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                        rectangles.push(self.rectangle(&Face {
                            axis: axis as u8,
                            positive,
                            plane: (at[axis] + usize::from(positive)) as u16,
                            min: [at[u], at[v]].map(|n| n as u16),
                            max: [at[u] + 1, at[v] + 1].map(|n| n as u16),
                        }));
                    }
                }
            }
        }
        rectangles
    }

    /// The faces that are rasterised: those of both halves' hulls.
    pub fn hull(&self, camera: &Camera) -> Vec<Rectangle> {
        let axis = half_axis(camera.forward());
        let cut = self.occupancy.half_cut(axis);
        let [mut below, mut above] = [self.occupancy.whole(), self.occupancy.whole()];
        below[axis].end = cut;
        above[axis].start = cut;
        let halves = [below, above].map(|half| Hull::build(&self.occupancy, half));
        halves
            .iter()
            .flat_map(|half| half.faces.iter().map(|face| self.rectangle(face)))
            .collect()
    }

    /// The plane that half-split cuts at, as far as the box goes.
    pub fn cut(&self, camera: &Camera) -> Rectangle {
        let axis = half_axis(camera.forward());
        let plane = self.occupancy.half_cut(axis);
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        self.rectangle(&Face {
            axis: axis as u8,
            positive: true,
            plane: plane as u16,
            min: [0; 2],
            max: [u, v].map(|a| self.occupancy.dims[a] as u16),
        })
    }

    fn rectangle(&self, face: &Face) -> Rectangle {
        let axis = usize::from(face.axis);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let corner = |cu: u16, cv: u16| {
            let mut at = DVec3::ZERO;
            at[axis] = f64::from(face.plane);
            at[u] = f64::from(cu);
            at[v] = f64::from(cv);
            // The last block of an axis ends with the volume.
            (at * self.block).min(self.extent)
        };
        let ([u0, v0], [u1, v1]) = (face.min, face.max);
        [
            corner(u0, v0),
            corner(u1, v0),
            corner(u1, v1),
            corner(u0, v1),
        ]
    }
}

/// The edges of the box [0, extent].
pub fn box_edges(extent: DVec3) -> [[DVec3; 2]; 12] {
    let corner =
        |i: usize| DVec3::from_array(std::array::from_fn(|a| (i >> a & 1) as f64)) * extent;
    let mut edges = [[DVec3::ZERO; 2]; 12];
    let mut n = 0;
    for i in 0..8 {
        for axis in 0..3 {
            if i >> axis & 1 == 0 {
                edges[n] = [corner(i), corner(i | 1 << axis)];
                n += 1;
            }
        }
    }
    edges
}

/// Where local points lie in a picture, in parts of its width and height from the top left.
#[derive(Debug, Clone, Copy)]
pub struct Projector(DMat4);

impl Projector {
    /// For a picture of these proportions.
    pub fn new(camera: &Camera, size: [u32; 2]) -> Self {
        Self(camera.clip_from_local(size))
    }

    /// Both ends of a line as far as it lies before the camera; `None` where none of it does.
    pub fn line(&self, ends: [DVec3; 2]) -> Option<[[f64; 2]; 2]> {
        let [a, b] = ends.map(|end| self.0 * end.extend(1.0));
        // clip.z is positive in front of the near plane, whatever the projection.
        let (a, b) = match (a.z > 0.0, b.z > 0.0) {
            (true, true) => (a, b),
            (false, false) => return None,
            (true, false) => (a, a.lerp(b, a.z / (a.z - b.z))),
            (false, true) => (b.lerp(a, b.z / (b.z - a.z)), b),
        };
        Some([a, b].map(|clip| [0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Orbit;
    use crate::volume::{Statistics, phantom};

    #[test]
    fn leaves_hull_and_cut_lie_where_the_blocks_do() {
        let volume = phantom::make("pot", [40, 40, 28]).unwrap();
        let camera = Orbit::default().camera(volume.extent());
        let transfer = TransferFunction::from_spec("opaque", &Statistics::of(&volume)).unwrap();
        let key = Key::of(&transfer, &Settings::new(camera), Sampler::Exact);
        let overlay = Overlay::new(&volume, &key).unwrap();
        let [active, all] = overlay.counts();
        assert!(active > 0 && active < all && all == 5 * 5 * 4);
        assert_eq!(overlay.leaves().len(), overlay.occupancy.exposed_faces());
        let inside = |r: &Rectangle| {
            r.iter()
                .all(|p| p.cmpge(DVec3::ZERO).all() && p.cmple(volume.extent()).all())
        };
        assert!(overlay.leaves().iter().all(inside) && overlay.hull(&camera).iter().all(inside));
        let axis = half_axis(camera.forward());
        assert!(
            overlay
                .cut(&camera)
                .iter()
                .all(|p| p[axis] == 16.0 || p[axis] == 24.0)
        );
    }

    #[test]
    fn lines_are_cut_off_behind_the_camera() {
        let extent = DVec3::splat(10.0);
        let camera = Orbit::default().camera(extent);
        let projector = Projector::new(&camera, [100, 100]);
        let centre = extent * 0.5;
        let [from, _] = projector.line([centre, camera.eye * 3.0]).unwrap();
        assert!((from[0] - 0.5).abs() < 1e-9 && (from[1] - 0.5).abs() < 1e-9);
        assert!(
            projector
                .line([camera.eye * 2.0, camera.eye * 3.0])
                .is_none()
        );
        let drawn = box_edges(extent)
            .iter()
            .filter_map(|&e| projector.line(e))
            .count();
        assert_eq!(drawn, 12);
    }
}
