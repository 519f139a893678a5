//! Measuring.

pub mod verify;
