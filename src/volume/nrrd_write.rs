//! Writing a volume as an attached NRRD.

use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;

use super::nrrd::{INTERCEPT_KEY, SLOPE_KEY};
use super::{Rescale, Volume};
use crate::atomic_file::write_atomically;
use crate::error::Result;

/// How a written file holds its voxels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Packing {
    /// As they are: can be memory-mapped when read.
    Raw,
    /// gzip.
    Gzip,
}

/// Writes a volume as an attached NRRD. An older file of that name is replaced only when the new one is complete.
///
/// A [`Rescale`] goes into key/value lines of our own, for the format has no field for it.
///
/// # Errors
/// [`crate::Error::Io`] where the file cannot be written.
pub fn write_nrrd(volume: &Volume, path: &Path, packing: Packing) -> Result<()> {
    write_atomically(path, |out| {
        out.write_all(header(volume, packing).as_bytes())?;
        let voxels = volume.voxels.as_bytes();
        match packing {
            Packing::Raw => out.write_all(voxels),
            Packing::Gzip => {
                let mut packer = GzEncoder::new(out, Compression::new(6));
                packer.write_all(voxels)?;
                packer.finish().map(|_| ())
            }
        }
    })
}

fn header(volume: &Volume, packing: Packing) -> String {
    use std::fmt::Write as _;
    let [x, y, z] = volume.dims;
    let vector = |v: glam::DVec3| format!("({},{},{})", v.x, v.y, v.z);
    let axis = |i: usize| vector(volume.direction.col(i) * volume.spacing[i]);
    let mut lines = format!(
        "type: {}\ndimension: 3\nspace dimension: 3\nsizes: {x} {y} {z}\nspace directions: {} {} {}\n\
         kinds: domain domain domain\nendian: {}\nencoding: {}\nspace origin: {}\n",
        volume.voxels.voxel_type().name(),
        axis(0),
        axis(1),
        axis(2),
        if cfg!(target_endian = "big") {
            "big"
        } else {
            "little"
        },
        match packing {
            Packing::Raw => "raw",
            Packing::Gzip => "gzip",
        },
        vector(volume.origin),
    );
    if volume.rescale != Rescale::IDENTITY {
        let Rescale { slope, intercept } = volume.rescale;
        // Writing to a string cannot fail.
        let _ = write!(
            lines,
            "{SLOPE_KEY}:={slope}\n{INTERCEPT_KEY}:={intercept}\n"
        );
    }
    // A comment fills the header up so that voxels are aligned for every type, which a reader needs to map them.
    let magic = "NRRD0005\n";
    let fill = (4 - (magic.len() + lines.len() + "#\n\n".len()) % 4) % 4;
    format!("{magic}{lines}#{}\n\n", " ".repeat(fill))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Voxels, open, phantom};
    use glam::{DMat3, DVec3};

    #[test]
    fn what_is_written_reads_back_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("volume.nrrd");
        let noise = phantom::make("noise", [7, 5, 3]).unwrap();
        let bytes = noise.voxels.as_bytes().to_vec();
        for voxels in [
            Voxels::U8(bytes.clone().into()),
            Voxels::I8(
                bytes
                    .iter()
                    .map(|b| b.cast_signed())
                    .collect::<Vec<_>>()
                    .into(),
            ),
            Voxels::U16(
                bytes
                    .iter()
                    .map(|b| u16::from(*b) * 257)
                    .collect::<Vec<_>>()
                    .into(),
            ),
            Voxels::I16(
                bytes
                    .iter()
                    .map(|b| i16::from(*b) * -100)
                    .collect::<Vec<_>>()
                    .into(),
            ),
            Voxels::F32(
                bytes
                    .iter()
                    .map(|b| f32::from(*b) * 0.3)
                    .collect::<Vec<_>>()
                    .into(),
            ),
        ] {
            let volume = Volume {
                name: path.display().to_string(),
                spacing: DVec3::new(0.25, 1.5, 3.0),
                origin: DVec3::new(-1.0, 0.5, 1e-3),
                direction: DMat3::IDENTITY,
                rescale: Rescale {
                    slope: 0.1,
                    intercept: -1024.0,
                },
                dims: noise.dims,
                voxels,
                warnings: Vec::new(),
            };
            for packing in [Packing::Gzip, Packing::Raw] {
                write_nrrd(&volume, &path, packing).unwrap();
                let read = open(&path, None).unwrap();
                assert_eq!(read.voxels.as_bytes(), volume.voxels.as_bytes());
                assert_eq!(read.voxels.voxel_type(), volume.voxels.voxel_type());
                assert_eq!(
                    (
                        read.dims,
                        read.spacing,
                        read.origin,
                        read.direction,
                        read.rescale
                    ),
                    (
                        volume.dims,
                        volume.spacing,
                        volume.origin,
                        volume.direction,
                        volume.rescale
                    )
                );
                assert!(read.warnings.is_empty(), "{:?}", read.warnings);
            }
            // Written last: raw, and so mapped.
            let read = open(&path, None).unwrap();
            assert!(format!("{:?}", read.voxels).contains("Mapped"));
        }
        assert_eq!(folder.path().read_dir().unwrap().count(), 1);
    }

    #[test]
    fn a_failed_write_leaves_the_older_file() {
        let folder = tempfile::tempdir().unwrap();
        let volume = phantom::make("full", [2; 3]).unwrap();
        let path = folder.path().join("taken");
        std::fs::create_dir(&path).unwrap();
        std::fs::write(path.join("kept"), "x").unwrap();
        assert!(write_nrrd(&volume, &path, Packing::Raw).is_err());
        assert_eq!(std::fs::read_to_string(path.join("kept")).unwrap(), "x");
        assert_eq!(folder.path().read_dir().unwrap().count(), 1);
    }
}
