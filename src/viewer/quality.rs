//! How good a picture is while something moves: coarser steps and fewer pixels, as far as the frame rate asks for it.

use std::collections::VecDeque;
use std::time::Duration;

/// What a whole frame may take while moving, in ms: drawing the picture, laying out the window, painting and presenting it.
const FRAME_MS: f64 = 70.0;

/// What drawing may take of it even where the window alone takes nearly all: so many ms, or such a share of the window's,
/// by which little is won.
const LEAST_DRAWING_MS: f64 = 12.0;
const LEAST_SHARE: f64 = 0.25;

/// Of how many frames the one counts in which the window took least: what it takes besides waiting for events.
const REMEMBERED: usize = 8;

/// Full pictures that take longer, in ms, are led up to by one between.
const LONG_MS: f64 = 250.0;

/// How long after the last change the picture counts as at rest.
const REST: Duration = Duration::from_millis(150);

/// The longest steps and the fewest pixels along an edge that are taken, as factors.
const MOST_STEP: f64 = 3.0;
const LEAST_SCALE: f64 = 0.2;

/// What a picture is drawn with in place of what was asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// Pixels along an edge, as a factor; at most 1.
    pub scale: f64,
    /// Length of a step, as a factor; at least 1.
    pub step: f64,
}

impl Level {
    /// All that was asked for.
    pub const FULL: Self = Self {
        scale: 1.0,
        step: 1.0,
    };

    /// What share of the full work it takes.
    pub fn work(&self) -> f64 {
        self.scale * self.scale / self.step
    }

    /// The level of this share of the full work: steps grow first by half of what is to be saved, pixels by the rest.
    fn of_work(work: f64) -> Self {
        let work = work.clamp(LEAST_SCALE * LEAST_SCALE / MOST_STEP, 1.0);
        let step = work.powf(-1.0 / 3.0).min(MOST_STEP);
        let scale = (work * step).sqrt().clamp(LEAST_SCALE, 1.0);
        Self { scale, step }
    }

    /// Width and height of the picture that stands for one of `size`.
    pub fn size(&self, size: [u32; 2]) -> [u32; 2] {
        size.map(|n| ((f64::from(n) * self.scale).round() as u32).max(1))
    }

    /// In words, for the status line.
    pub fn words(&self) -> String {
        if *self == Self::FULL {
            "full quality".to_owned()
        } else {
            format!(
                "moving: {:.0} % of the pixels' edge, steps x{:.1}",
                self.scale * 100.0,
                self.step
            )
        }
    }
}

/// Follows what frames take. Times are those since the program's start.
#[derive(Debug, Clone)]
pub struct Quality {
    /// Whether quality gives way to the frame rate at all.
    pub adapts: bool,
    work: f64,
    /// What the last frames took besides drawing the picture, in ms.
    around_ms: VecDeque<f64>,
    /// Whether the picture between the moving and the full one is drawn, or not called for.
    is_led_up_to: bool,
    last_change: Option<Duration>,
}

impl Default for Quality {
    fn default() -> Self {
        Self {
            adapts: true,
            // A guess that errs to the fast side.
            work: 0.1,
            around_ms: VecDeque::new(),
            is_led_up_to: true,
            last_change: None,
        }
    }
}

impl Quality {
    /// Something that the picture shows has changed, and may go on doing so.
    pub fn moved(&mut self, now: Duration) {
        self.last_change = Some(now);
        self.is_led_up_to = false;
    }

    /// What to draw with now, and whether the picture is one on the way: of something that moves, or that leads up to the
    /// full one.
    pub fn level(&self, now: Duration) -> (Level, bool) {
        let is_moving = self.until_rest(now).is_some();
        if !self.adapts {
            (Level::FULL, is_moving)
        } else if is_moving {
            (Level::of_work(self.work), true)
        } else if !self.is_led_up_to && self.aim_ms() / self.work > LONG_MS {
            (Level::of_work(self.work.sqrt()), true)
        } else {
            (Level::FULL, false)
        }
    }

    /// How long it is until the picture counts as at rest; `None` where it is.
    pub fn until_rest(&self, now: Duration) -> Option<Duration> {
        let since = now.saturating_sub(self.last_change?);
        REST.checked_sub(since).filter(|left| !left.is_zero())
    }

    /// What drawing the picture may take, in ms.
    fn aim_ms(&self) -> f64 {
        let around = self.around_ms.iter().copied().reduce(f64::min);
        let around = around.unwrap_or(FRAME_MS * 0.4);
        (FRAME_MS - around)
            .max(LEAST_DRAWING_MS)
            .max(around * LEAST_SHARE)
    }

    /// Takes notice of what drawing a picture took, in ms.
    pub fn measured(&mut self, level: Level, ms: f64) {
        self.is_led_up_to |= level.work() > self.work * 1.5;
        if ms > 0.0 {
            // Pictures have a fixed cost too, so this overshoots: half the way is taken up, all of it down.
            let aim = level.work() * self.aim_ms() / ms;
            let change = (aim / self.work).clamp(0.2, 1.5);
            self.work = (self.work * change).clamp(Level::of_work(0.0).work(), 1.0);
        }
    }

    /// Takes notice of what a frame took besides drawing the picture, in ms.
    pub fn measured_around(&mut self, ms: f64) {
        self.around_ms.push_back(ms);
        if self.around_ms.len() > REMEMBERED {
            self.around_ms.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(n: u64) -> Duration {
        Duration::from_millis(n)
    }

    /// Drives a renderer whose full picture takes so long, and the window as long in every frame; tells the level that it
    /// comes to and what a frame takes.
    fn settle(full_ms: f64, window_ms: f64) -> (Level, f64) {
        let mut quality = Quality::default();
        let mut took = 0.0;
        for i in 0..40 {
            quality.moved(ms(i * 50));
            let (level, is_moving) = quality.level(ms(i * 50));
            assert!(is_moving);
            took = full_ms * level.work();
            quality.measured(level, took);
            quality.measured_around(window_ms + if i % 3 == 0 { 0.0 } else { 16.0 });
        }
        (quality.level(ms(39 * 50)).0, window_ms + took)
    }

    #[test]
    fn the_frame_time_is_held_as_far_as_coarseness_goes() {
        for (full_ms, window_ms) in [(200.0, 10.0), (500.0, 40.0), (2000.0, 30.0)] {
            let (level, took) = settle(full_ms, window_ms);
            assert!(level.scale < 1.0 && level.step > 1.0);
            assert!(took < FRAME_MS * 1.2, "{full_ms}: {took}");
        }
        // Where nothing need be saved, nothing is.
        let (level, _) = settle(20.0, 5.0);
        assert_eq!(level, Level::FULL);
        // And there is an end to it, as there is where the window alone takes too long.
        let (level, _) = settle(1e6, 0.0);
        assert_eq!((level.scale, level.step), (LEAST_SCALE, MOST_STEP));
        let (_, took) = settle(500.0, 300.0);
        assert!((took - 300.0 * (1.0 + LEAST_SHARE)).abs() < 8.0, "{took}");
    }

    #[test]
    fn the_picture_at_rest_is_the_full_one() {
        let mut quality = Quality::default();
        assert_eq!(quality.level(ms(0)), (Level::FULL, false));
        quality.moved(ms(1000));
        let (moving, is_moving) = quality.level(ms(1100));
        assert!(moving != Level::FULL && is_moving);
        assert!(quality.until_rest(ms(1100)).is_some());
        assert_eq!(quality.until_rest(ms(1150)), None);
        // A full picture would take long: one between comes first, and only once.
        let (between, is_moving) = quality.level(ms(1150));
        assert!(between.work() > moving.work() && between.work() < 1.0 && is_moving);
        quality.measured(between, 100.0);
        assert_eq!(quality.level(ms(1200)), (Level::FULL, false));
        quality.adapts = false;
        quality.moved(ms(2000));
        assert_eq!(quality.level(ms(2001)), (Level::FULL, true));
        assert_eq!(quality.level(ms(2200)), (Level::FULL, false));
    }
}
