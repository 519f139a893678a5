//! Where voxels lie: in memory of our own, or in a mapped file.

use std::fmt;
use std::ops::Deref;

use bytemuck::Pod;
use memmap2::Mmap;

/// A read-only array of voxels, owned or memory-mapped.
pub enum Store<T> {
    /// Held in memory.
    Owned(Vec<T>),
    /// A range of a mapped file whose bytes are in this machine's order and aligned for `T`.
    Mapped {
        /// The mapped file.
        map: Mmap,
        /// Offset of the first voxel in bytes.
        offset: usize,
        /// Number of voxels.
        len: usize,
    },
}

impl<T: Pod> Deref for Store<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        match self {
            Self::Owned(voxels) => voxels,
            Self::Mapped { map, offset, len } => {
                bytemuck::cast_slice(&map[*offset..*offset + *len * size_of::<T>()])
            }
        }
    }
}

impl<T> From<Vec<T>> for Store<T> {
    fn from(voxels: Vec<T>) -> Self {
        Self::Owned(voxels)
    }
}

impl<T> fmt::Debug for Store<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Owned(voxels) => write!(f, "Owned({} voxels)", voxels.len()),
            Self::Mapped { len, .. } => write!(f, "Mapped({len} voxels)"),
        }
    }
}
