//! hollowcast renders volumes that are mostly empty and spends no sample where nothing is visible.
#![warn(missing_docs)]

mod atomic_file;
pub mod camera;
pub mod cpu;
pub mod error;
pub mod gpu;
pub mod lattice;
pub mod measure;
pub mod mode;
pub mod octree;
pub mod output;
pub mod reference;
pub mod render;
pub mod report;
pub mod sample;
pub mod scene;
pub mod skip;
mod text_file;
pub mod transfer;
#[cfg(feature = "viewer")]
pub mod viewer;
pub mod volume;

pub use error::{Error, Result};
