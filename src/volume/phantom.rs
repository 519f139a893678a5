//! Phantoms: volumes with a closed form, made by name and size.
//!
//! Smooth walls go over about 1.5 voxels from 0 to the material's number (by signed distance), as they do in scans, so
//! that trilinear samples behave as they do there. The background is exactly 0. Voxels are u8, spacing is 1.

mod shapes;

use glam::DVec3;
use rayon::prelude::*;

use self::shapes::Solid;
use super::raw::parse_dims;
use super::{MAX_DIM, Rescale, Volume, Voxels};
use crate::error::{Error, Result};

/// The stored number of a phantom's material.
pub const MATERIAL: u8 = 200;

/// The stored number of `slab`, everywhere.
pub const SLAB: u8 = 100;

/// The most voxels that a phantom may have: 4 GiB of them.
const MAX_VOXELS: usize = 1 << 32;

/// Every phantom's name, with a line that says what it is.
pub const NAMES: &[(&str, &str)] = &[
    ("sphere", "a hollow sphere with one wall"),
    ("shells", "three hollow spheres around one centre"),
    (
        "pot",
        "a teapot with spout, handle and an open lid, and something inside",
    ),
    ("capsules", "solid capsules laid out like a foot: no cavity"),
    (
        "gyroid",
        "the sheet of a gyroid: cavities everywhere, all connected",
    ),
    ("menger", "a Menger sponge"),
    ("checkerboard", "every other voxel, in all directions"),
    ("noise", "a hash of every voxel: nothing can be skipped"),
    ("empty", "nothing"),
    ("full", "one material everywhere"),
    ("thin", "a spherical shell one voxel thick"),
    (
        "slab",
        "half the material everywhere, for chords in closed form",
    ),
    ("ramp", "linear in x, from 0 on"),
];

/// A phantom from `NAME:SIZE` or `NAME:XxYxZ`.
///
/// # Errors
/// [`Error::Setting`] where there is no such phantom or size.
pub fn from_spec(spec: &str) -> Result<Volume> {
    let (name, size) = spec.split_once(':').ok_or_else(|| {
        Error::setting(
            "phantom",
            format!(
                "\"{}\" is not of the form NAME:SIZE or NAME:XxYxZ, as in pot:256",
                spec.escape_debug()
            ),
        )
    })?;
    let dims = match size.parse() {
        Ok(edge) => [edge; 3],
        Err(_) => parse_dims(size)?,
    };
    make(name, dims)
}

/// Makes a phantom of `dims` voxels.
///
/// # Errors
/// [`Error::Setting`] where there is no phantom of this name or `dims` is out of range.
pub fn make(name: &str, dims: [usize; 3]) -> Result<Volume> {
    let voxels = dims.iter().try_fold(1_usize, |n, &d| n.checked_mul(d));
    if dims.iter().any(|d| !(1..=MAX_DIM).contains(d)) || voxels.is_none_or(|n| n > MAX_VOXELS) {
        return Err(Error::setting(
            "phantom size",
            format!("1 to {MAX_DIM} voxels per axis and at most {MAX_VOXELS} in all are possible"),
        ));
    }
    let shortest = dims.iter().copied().min().unwrap_or(1);
    let data = match name {
        "sphere" => solid(dims, &shapes::sphere()),
        "shells" => solid(dims, &shapes::shells()),
        "pot" => solid(dims, &shapes::pot()),
        "capsules" => solid(dims, &shapes::capsules()),
        "gyroid" => solid(dims, &shapes::gyroid()),
        "menger" => menger(dims),
        "checkerboard" => fill(dims, |[x, y, z]| ((x + y + z) % 2) as u8 * MATERIAL),
        "noise" => fill(dims, |[x, y, z]| hash((z * dims[1] + y) * dims[0] + x)),
        "empty" => fill(dims, |_| 0),
        "full" => fill(dims, |_| MATERIAL),
        "thin" => {
            // All voxels whose centre is at most half a voxel from the sphere: closed against steps across faces.
            let (centre, radius) = (centre(dims), shortest as f64 * 0.4);
            fill(dims, |at| {
                let off = ((grid_position(at) - centre).length() - radius).abs();
                if off <= 0.5 { MATERIAL } else { 0 }
            })
        }
        "slab" => fill(dims, |_| SLAB),
        "ramp" => {
            let last = (dims[0] - 1).max(1);
            // Whole steps as long as they fit: then the data are linear to the bit.
            let step = 255 / last;
            fill(dims, |[x, _, _]| {
                if step > 0 {
                    (x * step) as u8
                } else {
                    (x as f64 * 255.0 / last as f64).round() as u8
                }
            })
        }
        _ => {
            let names: Vec<&str> = NAMES.iter().map(|(name, _)| *name).collect();
            return Err(Error::setting(
                "phantom",
                format!(
                    "\"{}\" is none of {}",
                    name.escape_debug(),
                    names.join(", ")
                ),
            ));
        }
    };
    let [x, y, z] = dims;
    Ok(Volume {
        name: format!("phantom:{name}:{x}x{y}x{z}"),
        dims,
        spacing: DVec3::ONE,
        origin: DVec3::ZERO,
        direction: glam::DMat3::IDENTITY,
        rescale: Rescale::IDENTITY,
        voxels: Voxels::U8(data.into()),
        warnings: Vec::new(),
    })
}

fn grid_position(voxel: [usize; 3]) -> DVec3 {
    DVec3::from_array(voxel.map(|i| i as f64 + 0.5))
}

fn centre(dims: [usize; 3]) -> DVec3 {
    DVec3::from_array(dims.map(|d| d as f64 * 0.5))
}

fn fill(dims: [usize; 3], value: impl Fn([usize; 3]) -> u8 + Sync) -> Vec<u8> {
    let [nx, ny, nz] = dims;
    let mut data = vec![0; nx * ny * nz];
    data.par_chunks_mut(nx).enumerate().for_each(|(row, line)| {
        let (y, z) = (row % ny, row / ny);
        for (x, voxel) in line.iter_mut().enumerate() {
            *voxel = value([x, y, z]);
        }
    });
    data
}

/// Voxels per edge of the cubes that are left empty without asking for each voxel.
const CELL: usize = 8;

/// Voxelises a solid whose unit is half the shortest edge of the box, about the box's centre.
fn solid(dims: [usize; 3], shape: &dyn Solid) -> Vec<u8> {
    let [nx, ny, nz] = dims;
    let centre = centre(dims);
    let unit = dims.iter().copied().min().unwrap_or(1) as f64 * 0.5;
    // Signed distance is at most the straight distance: a cell whose centre is farther from the wall than its corners
    // is empty, and so are most cells of a hollow shape.
    let reach = CELL as f64 * 0.5 * 3_f64.sqrt() + 1.0;
    let cells_x = nx.div_ceil(CELL);
    let mut data = vec![0; nx * ny * nz];
    data.par_chunks_mut(nx * ny)
        .enumerate()
        .for_each(|(z, slice)| {
            let cell_z = (z / CELL * CELL) as f64 + CELL as f64 * 0.5;
            let mut skip = vec![false; cells_x];
            for (y, line) in slice.chunks_mut(nx).enumerate() {
                if y % CELL == 0 {
                    for (cell, skip) in skip.iter_mut().enumerate() {
                        let middle = (cell * CELL) as f64 + CELL as f64 * 0.5;
                        let at = DVec3::new(middle, y as f64 + CELL as f64 * 0.5, cell_z);
                        *skip = shape.least_distance((at - centre) / unit) * unit > reach;
                    }
                }
                for (cell, run) in line.chunks_mut(CELL).enumerate() {
                    if skip[cell] {
                        continue;
                    }
                    for (i, voxel) in run.iter_mut().enumerate() {
                        let at = grid_position([cell * CELL + i, y, z]);
                        let (distance, material) = shape.distance((at - centre) / unit);
                        let cover = (0.5 - distance * unit / 1.5).clamp(0.0, 1.0);
                        *voxel = (cover * f64::from(material)).round() as u8;
                    }
                }
            }
        });
    data
}

/// The sponge of the depth that the shortest edge resolves; voxels are in or out.
fn menger(dims: [usize; 3]) -> Vec<u8> {
    let shortest = dims.iter().copied().min().unwrap_or(1);
    let depth = (1..=5).take_while(|&d| 3_usize.pow(d) <= shortest).count() as u32;
    let cells = 3_usize.pow(depth);
    // One sponge in the cube at the box's centre, so that it keeps its shape in any box.
    let place = |i: usize, axis: usize| {
        let margin = (dims[axis] - shortest) / 2;
        i.checked_sub(margin)
            .filter(|&i| i < shortest)
            .map(|i| i * cells / shortest)
    };
    fill(dims, |[x, y, z]| {
        let (Some(mut x), Some(mut y), Some(mut z)) = (place(x, 0), place(y, 1), place(z, 2))
        else {
            return 0;
        };
        for _ in 0..depth {
            let middles = [x, y, z].iter().filter(|&&i| i % 3 == 1).count();
            if middles >= 2 {
                return 0;
            }
            (x, y, z) = (x / 3, y / 3, z / 3);
        }
        MATERIAL
    })
}

/// Eight bits that look random, from a voxel's index: the finaliser of `MurmurHash3` (public domain).
fn hash(index: usize) -> u8 {
    let mut h = index as u64 ^ 0x9E37_79B9_7F4A_7C15;
    h = (h ^ (h >> 33)).wrapping_mul(0xFF51_AFD7_ED55_8CCD);
    h = (h ^ (h >> 33)).wrapping_mul(0xC4CE_B9FE_1A85_EC53);
    (h ^ (h >> 33)) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{empty_share, enclosed_share};

    fn data(name: &str, dims: [usize; 3]) -> Vec<u8> {
        make(name, dims).unwrap().voxels.as_bytes().to_vec()
    }

    #[test]
    fn every_listed_phantom_can_be_made_in_any_shape_of_box() {
        for (name, _) in NAMES {
            for dims in [[1, 1, 1], [5, 3, 2], [24, 17, 40]] {
                assert_eq!(data(name, dims).len(), dims.iter().product::<usize>());
            }
        }
        for bad in [
            "pot",
            "pot:0",
            "teapot:4",
            "pot:4x4",
            "full:70000x1x1",
            "full:65536",
        ] {
            assert!(from_spec(bad).is_err(), "{bad}");
        }
        assert_eq!(from_spec("pot:3x4x5").unwrap().dims, [3, 4, 5]);
    }

    #[test]
    fn hollow_shapes_enclose_space_and_open_ones_do_not() {
        for (name, hollow) in [
            ("sphere", true),
            ("shells", true),
            ("thin", true),
            ("pot", false),
            ("capsules", false),
            ("gyroid", false),
            ("menger", false),
            ("empty", false),
            ("full", false),
        ] {
            let volume = make(name, [48; 3]).unwrap();
            assert_eq!(
                enclosed_share(&volume, |v| v == 0.0) > 0.0,
                hollow,
                "{name}"
            );
        }
    }

    #[test]
    fn the_pot_has_a_cavity_with_something_inside_that_stands_free_of_the_wall() {
        // Filled in from outside at a coarser threshold, the something is an island: more than one solid part.
        let volume = make("pot", [96; 3]).unwrap();
        let bytes = volume.voxels.as_bytes();
        let mut seen: Vec<bool> = bytes.iter().map(|&v| v < 100).collect();
        let mut parts = 0;
        for start in 0..bytes.len() {
            if seen[start] {
                continue;
            }
            parts += 1;
            let mut stack = vec![start];
            seen[start] = true;
            while let Some(i) = stack.pop() {
                for step in [1, 96, 96 * 96] {
                    for j in [i.wrapping_sub(step), i + step] {
                        if j < bytes.len() && !seen[j] {
                            seen[j] = true;
                            stack.push(j);
                        }
                    }
                }
            }
        }
        assert_eq!(parts, 2);
        assert!(empty_share(&volume, |v| v == 0.0) > 0.7);
    }

    #[test]
    fn smooth_walls_are_steep_but_not_sharp() {
        // The middle row of a sphere crosses two walls; next voxels differ by no more than 1 / 1.5 of the material (240).
        for name in ["sphere", "shells", "pot", "capsules", "gyroid"] {
            let bytes = data(name, [64; 3]);
            let steepest = bytes
                .chunks(64)
                .flat_map(|line| line.windows(2).map(|w| w[0].abs_diff(w[1])))
                .max()
                .unwrap();
            assert!((100..=160).contains(&steepest), "{name}: {steepest}");
        }
    }

    #[test]
    fn cells_left_out_are_empty() {
        // The same shape without the shortcut.
        for shape in [
            &shapes::sphere() as &dyn Solid,
            &shapes::pot(),
            &shapes::capsules(),
            &shapes::gyroid(),
            &shapes::shells(),
        ] {
            let dims = [40, 33, 47];
            let unit = 33.0 * 0.5;
            let direct = fill(dims, |at| {
                let (distance, material) =
                    shape.distance((grid_position(at) - centre(dims)) / unit);
                let cover = (0.5 - distance * unit / 1.5).clamp(0.0, 1.0);
                (cover * f64::from(material)).round() as u8
            });
            assert_eq!(solid(dims, shape), direct);
        }
    }

    #[test]
    fn a_ramp_is_linear_to_the_bit() {
        let line = &data("ramp", [64, 1, 1]);
        assert!(line.windows(2).all(|w| w[1] - w[0] == line[1]));
        assert_eq!(line[0], 0);
        assert!(line[1] > 0);
    }

    #[test]
    fn noise_uses_every_number() {
        let mut bytes = data("noise", [32; 3]);
        bytes.sort_unstable();
        bytes.dedup();
        assert_eq!(bytes.len(), 256);
    }
}
