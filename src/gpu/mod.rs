//! Mechanism of the GPU backend: device, shader composition, mirrored structs, timers, read-back. Knows no method.

pub mod abi;
pub mod buffer;
pub mod device;
pub mod shader;
pub mod texture;
pub mod timer;

pub use device::{AdapterKind, Gpu};
