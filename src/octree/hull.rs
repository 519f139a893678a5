//! The hull of the active leaves: the faces between them and everything else.

use std::ops::Range;

use rayon::prelude::*;

use super::{Occupancy, bits};

/// A rectangle of the hull, in leaf coordinates (multiply by [`Occupancy::block`] and clamp to the volume for voxels).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Face {
    /// The axis that the face is perpendicular to.
    pub axis: u8,
    /// Whether the outward normal points along +axis: the active side is the lower one.
    pub positive: bool,
    /// Where on the axis the face lies.
    pub plane: u16,
    /// First corner, on the axes (axis + 1) % 3 and (axis + 2) % 3.
    pub min: [u16; 2],
    /// Opposite corner; larger in both.
    pub max: [u16; 2],
}

/// The closed surface around the active leaves of a region, coplanar neighbours merged into rectangles.
///
/// Rectangles that meet may have corners on each other's edges (T-junctions): whoever rasterises them grows each one
/// outward and in its plane, so that no crack opens.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Hull {
    /// Sorted by direction (axis * 2 + positive), then plane.
    pub faces: Vec<Face>,
    /// Where each direction's faces lie in `faces`.
    pub by_direction: [Range<usize>; 6],
}

impl Hull {
    /// The faces between an active leaf of `region` and one that is inactive or outside the region (which closes a half's
    /// hull at the cut).
    ///
    /// # Panics
    /// Where `region` reaches beyond the grid.
    pub fn build(occupancy: &Occupancy, region: [Range<usize>; 3]) -> Self {
        for (axis, range) in region.iter().enumerate() {
            assert!(
                range.end <= occupancy.dims[axis],
                "the region lies within the grid"
            );
        }
        if region.iter().any(Range::is_empty) {
            return Self::default();
        }
        let [x, y, z] = region;
        let layers = [
            Layers::across_x(occupancy, &x, &y, &z),
            Layers::across_y(occupancy, &x, &y, &z),
            Layers::across_z(occupancy, &x, &y, &z),
        ];
        let tasks: Vec<(usize, usize)> = (0..6)
            .flat_map(|direction| (0..layers[direction / 2].count()).map(move |i| (direction, i)))
            .collect();
        let found: Vec<Vec<Face>> = tasks
            .par_iter()
            .with_min_len(8)
            .map(|&(direction, layer)| layers[direction / 2].faces(layer, direction % 2 == 1))
            .collect();

        let mut hull = Self {
            faces: Vec::with_capacity(found.iter().map(Vec::len).sum()),
            ..Self::default()
        };
        for direction in 0..6 {
            let start = hull.faces.len();
            for (task, faces) in tasks.iter().zip(&found) {
                if task.0 == direction {
                    hull.faces.extend_from_slice(faces);
                }
            }
            hull.by_direction[direction] = start..hull.faces.len();
        }
        hull
    }
}

/// The active leaves of a region as one bit image per layer across an axis.
struct Layers {
    axis: usize,
    /// Grid coordinates of the first layer, of a row's bit 0, and of a layer's first row.
    start: [usize; 3],
    rows: usize,
    words_per_row: usize,
    /// Layer by layer, row by row.
    words: Vec<u64>,
}

impl Layers {
    fn new(axis: usize, start: [usize; 3], [layers, bits, rows]: [usize; 3]) -> Self {
        let words_per_row = bits.div_ceil(64);
        Self {
            axis,
            start,
            rows,
            words_per_row,
            words: vec![0; layers * rows * words_per_row],
        }
    }

    /// Rows are along x and follow each other along y.
    fn across_z(
        occupancy: &Occupancy,
        x: &Range<usize>,
        y: &Range<usize>,
        z: &Range<usize>,
    ) -> Self {
        let mut layers = Self::new(2, [z.start, 0, y.start], [z.len(), x.end, y.len()]);
        for (layer, z) in z.clone().enumerate() {
            for (row, y) in y.clone().enumerate() {
                layers.copy_row(layer, row, occupancy.row(y, z), x);
            }
        }
        layers
    }

    /// Rows are along x and follow each other along z.
    fn across_y(
        occupancy: &Occupancy,
        x: &Range<usize>,
        y: &Range<usize>,
        z: &Range<usize>,
    ) -> Self {
        let mut layers = Self::new(1, [y.start, 0, z.start], [y.len(), x.end, z.len()]);
        for (row, z) in z.clone().enumerate() {
            for (layer, y) in y.clone().enumerate() {
                layers.copy_row(layer, row, occupancy.row(y, z), x);
            }
        }
        layers
    }

    /// Rows are along y, so bits have to be transposed, and follow each other along z.
    fn across_x(
        occupancy: &Occupancy,
        x: &Range<usize>,
        y: &Range<usize>,
        z: &Range<usize>,
    ) -> Self {
        let mut layers = Self::new(0, [x.start, y.start, z.start], [x.len(), y.len(), z.len()]);
        for (row, z) in z.clone().enumerate() {
            for y_word in 0..layers.words_per_row {
                let first_y = y.start + y_word * 64;
                for x_word in x.start / 64..x.end.div_ceil(64) {
                    let mut square = [0; 64];
                    for (bits, y) in square.iter_mut().zip(first_y..y.end) {
                        *bits = occupancy.row(y, z)[x_word];
                    }
                    if square == [0; 64] {
                        continue;
                    }
                    bits::transpose(&mut square);
                    for (x_bit, bits) in square.into_iter().enumerate() {
                        let x_here = x_word * 64 + x_bit;
                        if x.contains(&x_here) {
                            let at = layers.at(x_here - x.start, row) + y_word;
                            layers.words[at] = bits;
                        }
                    }
                }
            }
        }
        layers
    }

    fn copy_row(&mut self, layer: usize, row: usize, bits: &[u64], range: &Range<usize>) {
        let at = self.at(layer, row);
        for (word, out) in self.words[at..][..self.words_per_row]
            .iter_mut()
            .enumerate()
        {
            *out = bits[word] & bits::word_mask(range, word);
        }
    }

    fn at(&self, layer: usize, row: usize) -> usize {
        (layer * self.rows + row) * self.words_per_row
    }

    fn count(&self) -> usize {
        self.words.len() / (self.rows * self.words_per_row)
    }

    /// The merged faces on one side of a layer.
    fn faces(&self, layer: usize, positive: bool) -> Vec<Face> {
        let words_per_layer = self.rows * self.words_per_row;
        let image = |layer: usize| &self.words[layer * words_per_layer..][..words_per_layer];
        let mut exposed = image(layer).to_vec();
        let beyond = if positive {
            Some(layer + 1).filter(|&next| next < self.count())
        } else {
            layer.checked_sub(1)
        };
        if let Some(beyond) = beyond {
            for (bits, covered) in exposed.iter_mut().zip(image(beyond)) {
                *bits &= !covered;
            }
        }

        let plane = (self.start[0] + layer + usize::from(positive)) as u16;
        let mut faces = Vec::new();
        take_rectangles(&mut exposed, self.words_per_row, |bits, rows| {
            let mut corners = [bits, rows];
            // Across y, the rows' axis (z) comes before the bits' axis (x) in cyclic order.
            let mut starts = [self.start[1], self.start[2]];
            if self.axis == 1 {
                corners.swap(0, 1);
                starts.swap(0, 1);
            }
            faces.push(Face {
                axis: self.axis as u8,
                positive,
                plane,
                min: [0, 1].map(|i| (starts[i] + corners[i].start) as u16),
                max: [0, 1].map(|i| (starts[i] + corners[i].end) as u16),
            });
        });
        faces
    }
}

/// Takes an image's set bits apart into rectangles (columns, rows), each bit in one: runs of a row, extended over the
/// rows below as long as these hold the whole run.
fn take_rectangles(
    image: &mut [u64],
    words_per_row: usize,
    mut take: impl FnMut(Range<usize>, Range<usize>),
) {
    let rows = image.len() / words_per_row;
    for row in 0..rows {
        let mut from = 0;
        while let Some(run) = bits::next_run(&image[row * words_per_row..][..words_per_row], from) {
            from = run.end;
            let words = run.start / 64..run.end.div_ceil(64);
            let mut end = row + 1;
            while end < rows
                && words.clone().all(|word| {
                    let mask = bits::word_mask(&run, word);
                    image[end * words_per_row + word] & mask == mask
                })
            {
                for word in words.clone() {
                    image[end * words_per_row + word] &= !bits::word_mask(&run, word);
                }
                end += 1;
            }
            take(run, row..end);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;
    use crate::octree::testing::AnyOccupancy;
    use proptest::prelude::*;

    /// Every unit face of the region's hull by the definition: (axis, positive, plane, in-plane coordinates).
    fn unit_faces(occupancy: &Occupancy, region: &[Range<usize>; 3]) -> Vec<(Face, u32)> {
        let active =
            |at: [usize; 3]| (0..3).all(|a| region[a].contains(&at[a])) && occupancy.get(at);
        let mut faces = Vec::new();
        for z in region[2].clone() {
            for y in region[1].clone() {
                for x in region[0].clone() {
                    for direction in 0..6 {
                        let (axis, positive) = (direction / 2, direction % 2 == 1);
                        let at = [x, y, z];
                        let mut beyond = at;
                        beyond[axis] =
                            beyond[axis].wrapping_add_signed(if positive { 1 } else { -1 });
                        if active(at) && !active(beyond) {
                            let corner = [1, 2].map(|i| at[(axis + i) % 3] as u16);
                            faces.push((
                                Face {
                                    axis: axis as u8,
                                    positive,
                                    plane: (at[axis] + usize::from(positive)) as u16,
                                    min: corner,
                                    max: corner.map(|c| c + 1),
                                },
                                1,
                            ));
                        }
                    }
                }
            }
        }
        faces
    }

    proptest! {
        #[test]
        fn rectangles_cover_every_exposed_unit_face_once_and_nothing_else(any in AnyOccupancy::strategy()) {
            let (occupancy, region) = (any.occupancy(), any.region());
            let hull = Hull::build(&occupancy, region.clone());
            let mut covered: HashMap<Face, u32> = HashMap::new();
            for face in &hull.faces {
                for u in face.min[0]..face.max[0] {
                    for v in face.min[1]..face.max[1] {
                        let unit = Face { min: [u, v], max: [u + 1, v + 1], ..*face };
                        *covered.entry(unit).or_default() += 1;
                    }
                }
            }
            let expected: HashMap<Face, u32> = unit_faces(&occupancy, &region).into_iter().collect();
            prop_assert_eq!(covered, expected);
        }

        #[test]
        fn faces_are_sorted_by_direction_and_plane(any in AnyOccupancy::strategy()) {
            let hull = Hull::build(&any.occupancy(), any.region());
            let direction = |f: &Face| usize::from(f.axis) * 2 + usize::from(f.positive);
            prop_assert!(hull.faces.is_sorted_by_key(|f| (direction(f), f.plane)));
            let mut next = 0;
            for (d, range) in hull.by_direction.iter().enumerate() {
                prop_assert_eq!(range.start, next);
                prop_assert!(hull.faces[range.clone()].iter().all(|f| direction(f) == d));
                next = range.end;
            }
            prop_assert_eq!(next, hull.faces.len());
        }
    }

    #[test]
    fn a_full_region_has_six_faces() {
        let mut occupancy = Occupancy::new([300, 5, 7], 2);
        for z in 0..4 {
            for y in 0..3 {
                for x in 0..150 {
                    occupancy.set([x, y, z]);
                }
            }
        }
        let hull = Hull::build(&occupancy, [30..131, 0..3, 1..4]);
        let face = |axis, positive, plane, min, max| Face {
            axis,
            positive,
            plane,
            min,
            max,
        };
        assert_eq!(
            hull.faces,
            [
                face(0, false, 30, [0, 1], [3, 4]),
                face(0, true, 131, [0, 1], [3, 4]),
                face(1, false, 0, [1, 30], [4, 131]),
                face(1, true, 3, [1, 30], [4, 131]),
                face(2, false, 1, [30, 0], [131, 3]),
                face(2, true, 4, [30, 0], [131, 3]),
            ]
        );
    }
}
