//! What the window asks the thread that draws for, and what comes back.

use std::sync::Arc;

use eframe::egui::ColorImage;

use crate::error::Error;
use crate::render::{BackendInfo, FrameTimes, Preparation, Settings};
use crate::sample::Sampler;
use crate::scene::Counters;
use crate::transfer::TransferFunction;
use crate::volume::Volume;

use super::direct::Canvas;
use super::look::Way;
use super::quality::Level;
use super::verdict::Verdict;

/// How much larger differences are shown.
pub const GAIN: f32 = 16.0;

/// What to draw.
#[derive(Debug, Clone)]
pub struct Request {
    /// Told with every reply.
    pub ticket: u64,
    /// The volume.
    pub volume: Arc<Volume>,
    /// Its transfer function.
    pub transfer: TransferFunction,
    /// One picture, or two that are compared.
    pub pictures: Vec<(Way, Settings)>,
    /// Behind the pictures, linear.
    pub backdrop: [f32; 3],
    /// What quality the settings are of.
    pub level: Level,
    /// Whether another picture will follow at once: this one is not stopped for it, and nothing more is found out of it.
    pub is_moving: bool,
    /// Whether the difference of two pictures is to be shown.
    pub difference: bool,
}

/// What comes back.
#[derive(Debug)]
pub enum Reply {
    /// The pictures of a request.
    Frame(Box<Frame>),
    /// What the first picture of a request took.
    Details(Box<Details>),
    /// How its method compares.
    Weighed(u64, Verdict),
    /// Nothing could be drawn.
    Failed(Error),
}

/// The pictures of a request.
#[derive(Debug)]
pub struct Frame {
    /// The request's.
    pub ticket: u64,
    /// The request's.
    pub level: Level,
    /// The request's.
    pub is_moving: bool,
    /// As many as were asked for.
    pub drawn: Vec<Drawn>,
    /// How two of one size differ.
    pub compared: Option<Compared>,
    /// From taking the request to sending the reply, in ms.
    pub whole_ms: f64,
}

impl Frame {
    /// What drawing took, in ms: of a moving picture all that it keeps the window waiting; at rest, where structures may have
    /// been built first, the frames themselves.
    pub fn drawing_ms(&self) -> f64 {
        if self.is_moving {
            self.whole_ms
        } else {
            let drawn = self.drawn.iter();
            drawn.map(|d| d.times.frame_ms + d.read_back_ms).sum()
        }
    }
}

/// A picture, and how it was made.
#[derive(Debug)]
pub struct Drawn {
    /// For the screen.
    pub shown: Pixels,
    /// As drawn: with the method that auto chose.
    pub settings: Settings,
    /// As drawn.
    pub sampler: Sampler,
    /// What drew it.
    pub backend: BackendInfo,
    /// What the frame took.
    pub times: FrameTimes,
    /// What fetching the picture took, in ms.
    pub read_back_ms: f64,
    /// What structures took.
    pub preparation: Preparation,
}

/// A picture as the window takes it.
#[derive(Debug)]
pub enum Pixels {
    /// As bytes, to be sent to the adapter.
    Image(ColorImage),
    /// Where it was drawn.
    Canvas(Canvas),
}

/// How two pictures differ.
#[derive(Debug)]
pub struct Compared {
    /// Pixels with any bit different.
    pub pixels: u64,
    /// Largest difference of a channel.
    pub max_abs: f64,
    /// Peak signal-to-noise ratio in dB.
    pub psnr_db: f64,
    /// The difference [`GAIN`] times, where it was asked for.
    pub image: Option<ColorImage>,
}

/// What a picture took of samples.
#[derive(Debug)]
pub struct Details {
    /// The request's.
    pub ticket: u64,
    /// As counted.
    pub settings: Settings,
    /// Sums over all pixels.
    pub counters: Counters,
    /// Samples per pixel, as heat up to `most`.
    pub heat: ColorImage,
    /// The most samples of a pixel.
    pub most: u32,
    /// Distance of the first contributing sample from where the ray starts, per pixel, local units.
    pub first_hit: Vec<f32>,
}

/// What the worker is at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Nothing.
    Idle,
    /// Opening a backend or building structures.
    Building,
    /// Drawing.
    Drawing,
    /// Counting samples.
    Counting,
    /// Trying other methods.
    Weighing,
}
