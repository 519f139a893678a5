//! How far the reading of a file has come, and the way to stop it: for a window that must not stand still meanwhile.

use std::cell::RefCell;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::error::{Error, Result};

/// Shared between the thread that reads and the one that waits.
#[derive(Debug, Default)]
pub struct Reading {
    read: AtomicU64,
    of: AtomicU64,
    cancelled: AtomicBool,
}

thread_local! {
    /// Who watches what this thread reads: files are opened far below, by a reader per format.
    static WATCHER: RefCell<Option<Arc<Reading>>> = const { RefCell::new(None) };
}

impl Reading {
    /// Runs `work`, whose files this thread reads, under this watch.
    ///
    /// # Errors
    /// Those of `work`; [`Error::Cancelled`] where it was stopped.
    pub fn watch<T>(self: &Arc<Self>, work: impl FnOnce() -> Result<T>) -> Result<T> {
        WATCHER.set(Some(Arc::clone(self)));
        let done = work();
        WATCHER.set(None);
        if self.cancelled.load(Ordering::Relaxed) {
            return Err(Error::Cancelled);
        }
        done
    }

    /// The share of the file's bytes that were read; `None` before the first.
    pub fn fraction(&self) -> Option<f64> {
        let of = self.of.load(Ordering::Relaxed);
        (of > 0).then(|| self.read.load(Ordering::Relaxed) as f64 / of as f64)
    }

    /// Asks to stop at the next bytes.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }
}

/// A file that tells the watcher of its thread how much of it was read.
pub(super) struct Watched {
    file: File,
    watcher: Option<Arc<Reading>>,
}

impl Watched {
    /// A file of so many bytes.
    pub(super) fn new(file: File, len: u64) -> Self {
        let watcher = WATCHER.with_borrow(Clone::clone);
        if let Some(watcher) = &watcher {
            watcher.read.store(0, Ordering::Relaxed);
            watcher.of.store(len, Ordering::Relaxed);
        }
        Self { file, watcher }
    }

    /// The file itself, to be mapped.
    pub(super) fn into_file(self) -> File {
        self.file
    }
}

impl Read for Watched {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = self.file.read(into)?;
        if let Some(watcher) = &self.watcher {
            watcher.read.fetch_add(read as u64, Ordering::Relaxed);
            if watcher.cancelled.load(Ordering::Relaxed) {
                return Err(io::Error::other("stopped"));
            }
        }
        Ok(read)
    }
}

impl Seek for Watched {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Packing, load, phantom, write_nrrd};

    #[test]
    fn reading_is_followed_and_stopped() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pot.nrrd");
        let volume = phantom::make("pot", [32; 3]).unwrap();
        write_nrrd(&volume, &path, Packing::Gzip).unwrap();
        let name = path.display().to_string();
        let reading = Arc::<Reading>::default();
        assert_eq!(reading.fraction(), None);
        reading.watch(|| load(&name, None)).unwrap();
        assert!(reading.fraction().unwrap() > 0.5);
        let stopped = Arc::<Reading>::default();
        stopped.cancel();
        let result = stopped.watch(|| load(&name, None));
        assert!(matches!(result, Err(Error::Cancelled)));
        // Nobody watches any more.
        load(&name, None).unwrap();
    }
}
