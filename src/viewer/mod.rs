//! The window: volumes to look at, methods to compare, and what they take, with one's own eyes.
//!
//! What is shown and how it is drawn is plain data ([`look`], [`view`], [`quality`], [`history`], [`session`], [`editor`]);
//! a thread of its own draws it ([`worker`]), others load, save and time ([`jobs`]); the rest puts it on the screen. The
//! picture that is saved and the one that the copied command line draws ([`command`]) are the same to the bit.

pub mod actions;
pub mod app;
mod asking;
mod canvas;
mod captions;
pub mod command;
mod dialogs;
mod direct;
pub mod document;
pub mod editor;
pub mod history;
pub mod image;
pub mod jobs;
pub mod look;
mod mode_panel;
pub mod overlay;
mod panels;
mod path_dialog;
pub mod quality;
mod receiving;
mod renderers;
pub mod reply;
mod rows;
pub mod session;
mod shortcuts;
mod status;
mod sweep;
pub mod transfer_panel;
pub mod verdict;
pub mod view;
mod way_panel;
mod window;
pub mod worker;

pub use app::{App, Compare};
pub use direct::WindowGpu;
pub use window::{Options, run};
