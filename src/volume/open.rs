//! Which reader a file needs: by its content first, by its extension where that is silent.

use std::path::Path;

use super::header::{Header, Stored};
use super::payload::{open_file, read_head};
use super::{RawLayout, Volume, metaimage, nifti, nrrd, phantom, raw};
use crate::error::{Error, Result};

/// Opens a volume file: NRRD, `MetaImage`, NIfTI-1 or -2, `VolPack` .den, or raw voxels.
///
/// With `raw` the file is taken as raw voxels of that layout, whatever it looks like. Of files with more than three
/// dimensions the first volume is taken, and missing dimensions are 1.
///
/// # Errors
/// [`crate::Error::Io`] where the file cannot be read, [`crate::Error::File`] where its content is not what its format
/// asks for or not supported, [`crate::Error::Limit`] where there is not enough memory.
pub fn open(path: &Path, raw: Option<&RawLayout>) -> Result<Volume> {
    header(path, raw)?.into_volume()
}

/// Reads all numbers of a volume file as they are stored: every time step, in the file's own type.
///
/// # Errors
/// As [`open`].
pub fn read_stored(path: &Path, raw: Option<&RawLayout>) -> Result<Stored> {
    header(path, raw)?.into_stored()
}

/// Opens a file, or makes a phantom where `spec` is `phantom:NAME:SIZE` or `phantom:NAME:XxYxZ`.
///
/// # Errors
/// As [`open`]; [`crate::Error::Setting`] where there is no such phantom.
pub fn load(spec: &str, raw: Option<&RawLayout>) -> Result<Volume> {
    match spec.strip_prefix("phantom:") {
        Some(phantom) => phantom::from_spec(phantom),
        None => open(Path::new(spec), raw),
    }
}

fn header(path: &Path, layout: Option<&RawLayout>) -> Result<Header> {
    if layout.is_some() {
        return raw::header(path, layout);
    }
    let head = read_head(path, 1 << 10)?;
    if head.is_empty() {
        return Err(Error::file(path, "format", "is none: the file is empty"));
    }
    if nrrd::is_nrrd(&head) {
        return nrrd::header(path);
    }
    if metaimage::is_metaimage(&head) {
        return metaimage::header(path);
    }
    let (_, len) = open_file(path)?;
    if let Some(header) = raw::den_header(path, &head, len) {
        return Ok(header);
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let name = name.to_ascii_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    let has = |extensions: &[&str]| extensions.iter().any(|e| name.ends_with(e));
    if has(&[".nii", ".hdr", ".img"]) || nifti::is_nifti(path) {
        nifti::header(path)
    } else if has(&[".mha", ".mhd"]) {
        metaimage::header(path)
    } else {
        raw::header(path, None)
    }
}
