//! Truths as files, named by a hash of all that they depend on.
//!
//! A file holds a line that names the format, width and height (u32), step and bound (f64), the pixels (four f32 each), a byte
//! for each that says whether it is masked, and the SHA-256 of all that; numbers are little-endian.

use std::fs;
use std::io::Write;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::Truth;
use crate::output::write_atomically;
use crate::render::Settings;
use crate::scene::Picture;
use crate::transfer::TransferFunction;
use crate::volume::Volume;

/// Changed whenever refinement or the file is.
const FORMAT: &[u8] = b"hollowcast truth 2\n";
const DIGEST: usize = 32;
/// Bytes of the folder beyond which the oldest files go.
const LIMIT: u64 = 1 << 30;

/// What all truths of one volume and transfer function share.
#[derive(Clone)]
pub(super) struct Key(Sha256);

impl Key {
    pub(super) fn new(volume: &Volume, transfer: &TransferFunction) -> Self {
        let mut hash = Sha256::new();
        hash.update(FORMAT);
        hash.update(env!("CARGO_PKG_VERSION"));
        // Numbers print as what reads back the same.
        hash.update(format!(
            "{:?} {:?} {:?} {:?} {transfer:?}",
            volume.voxels.voxel_type(),
            volume.dims,
            volume.spacing,
            volume.rescale,
        ));
        hash.update(volume.voxels.as_bytes());
        Self(hash)
    }

    /// The file of the truth of these settings: all but what a truth does not read.
    pub(super) fn name(&self, settings: &Settings) -> String {
        let mut hash = self.0.clone();
        let read = Settings {
            step_voxels: 0.0,
            ..*settings
        };
        hash.update(format!("{read:?}"));
        let digest = hash.finalize();
        let first: [u8; 16] = std::array::from_fn(|i| digest[i]);
        format!("{:032x}.truth", u128::from_be_bytes(first))
    }
}

/// What a file holds; nothing where it is missing, damaged or of another size.
pub(super) fn read(path: &Path, size: [u32; 2]) -> Option<Truth> {
    let bytes = fs::read(path).ok()?;
    let (content, digest) = bytes.split_at_checked(bytes.len().checked_sub(DIGEST)?)?;
    if Sha256::digest(content).as_slice() != digest {
        tracing::warn!("{}: damaged; it is computed anew", path.display());
        return None;
    }
    let mut rest = content.strip_prefix(FORMAT)?;
    let found = [
        u32::from_le_bytes(take(&mut rest)?),
        u32::from_le_bytes(take(&mut rest)?),
    ];
    let step_voxels = f64::from_le_bytes(take(&mut rest)?);
    let bound = f64::from_le_bytes(take(&mut rest)?);
    let pixels = size[0] as usize * size[1] as usize;
    if found != size || rest.len() != pixels * 17 {
        return None;
    }
    let (rgba, masked) = rest.split_at(pixels * 16);
    let channel = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let rgba = rgba
        .chunks_exact(16)
        .map(|pixel| std::array::from_fn(|c| channel(&pixel[4 * c..])));
    Some(Truth {
        picture: Picture {
            size,
            rgba: rgba.collect(),
        },
        masked: masked.iter().map(|&m| m != 0).collect(),
        step_voxels,
        bound,
    })
}

fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (first, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(*first)
}

/// Keeps a truth; a cache that cannot be written costs the next run some work, nothing else.
pub(super) fn write(path: &Path, truth: &Truth) {
    let mut bytes = FORMAT.to_vec();
    for n in truth.picture.size {
        bytes.extend(n.to_le_bytes());
    }
    bytes.extend(truth.step_voxels.to_le_bytes());
    bytes.extend(truth.bound.to_le_bytes());
    for channel in truth.picture.rgba.as_flattened() {
        bytes.extend(channel.to_le_bytes());
    }
    bytes.extend(truth.masked.iter().map(|&m| u8::from(m)));
    let digest = Sha256::digest(&bytes);
    bytes.extend_from_slice(&digest);
    if let Some(folder) = path.parent() {
        // What fails here fails again below, and is told there.
        let _ = fs::create_dir_all(folder);
        make_room(folder, bytes.len() as u64);
    }
    if let Err(error) = write_atomically(path, |file| file.write_all(&bytes)) {
        tracing::debug!("{error}");
    }
}

/// Deletes the oldest truths where the folder would grow beyond its limit.
fn make_room(folder: &Path, bytes: u64) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    let mut files: Vec<_> = entries
        .flatten()
        .filter(|e| e.path().extension().is_some_and(|e| e == "truth"))
        .filter_map(|e| {
            let about = e.metadata().ok()?;
            Some((about.modified().ok()?, about.len(), e.path()))
        })
        .collect();
    files.sort();
    let mut all: u64 = bytes + files.iter().map(|(_, bytes, _)| bytes).sum::<u64>();
    for (_, bytes, path) in files {
        if all <= LIMIT {
            break;
        }
        // Another process may have been faster.
        let _ = fs::remove_file(path);
        all -= bytes;
    }
}
