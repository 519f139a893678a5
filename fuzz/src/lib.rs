//! What the fuzz targets share: a folder for their files, and what is asked of every answer.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use hollowcast::Result;

use counting::{BUFFERS, peak_of};

#[path = "../../tests/support/counting.rs"]
mod counting;

/// What deflate can make of a byte, twice: as it is unpacked and as it is kept.
const PER_BYTE: usize = 2 * 1032;

/// Runs `read` on an input of `bytes`: it must not take memory that the input does not back, and an error is one line.
///
/// # Panics
/// Where it does: that is what the fuzzer looks for.
pub fn answers<T>(bytes: usize, read: impl FnOnce() -> Result<T>) -> Option<T> {
    let (answer, peak) = peak_of(read);
    assert!(
        peak <= BUFFERS + PER_BYTE * bytes,
        "{peak} bytes were taken for an input of {bytes}"
    );
    match answer {
        Ok(answer) => Some(answer),
        Err(error) => {
            let line = error.to_string();
            assert_eq!(line.lines().count(), 1, "{line}");
            assert!(error.is_bad_input(), "{line}");
            None
        }
    }
}

/// This process's folder for the files that readers are given, in memory where the system has such a place.
fn folder() -> &'static Path {
    static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
        let memory = Path::new("/dev/shm");
        let parent = if memory.is_dir() {
            memory.to_owned()
        } else {
            std::env::temp_dir()
        };
        let folder = parent.join(format!("hollowcast-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for the inputs");
        folder
    });
    &FOLDER
}

/// Writes a file of this name and content.
///
/// # Panics
/// Where it cannot be written.
pub fn file(name: &str, content: &[u8]) -> PathBuf {
    let path = folder().join(name);
    std::fs::write(&path, content).expect("the input is written");
    path
}

/// Opens a volume file both ways: converted, and as it is stored.
pub fn volume(name: &str, content: &[u8]) {
    let path = file(name, content);
    if let Some(volume) = answers(content.len(), || hollowcast::volume::open(&path, None)) {
        assert_eq!(volume.len(), volume.dims.iter().product::<usize>());
    }
    answers(content.len(), || {
        hollowcast::volume::read_stored(&path, None)
    });
}
