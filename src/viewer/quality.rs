//! How good a picture is while something moves: coarser steps and fewer pixels, as far as the frame rate asks for it.

use std::time::Duration;

/// What drawing may take while moving, in ms: the window itself takes time too, on a software adapter about as much.
const TARGET_MS: f64 = 45.0;

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
    last_change: Option<Duration>,
}

impl Default for Quality {
    fn default() -> Self {
        Self {
            adapts: true,
            // A guess that errs to the fast side.
            work: 0.1,
            last_change: None,
        }
    }
}

impl Quality {
    /// Something that the picture shows has changed, and may go on doing so.
    pub fn moved(&mut self, now: Duration) {
        self.last_change = Some(now);
    }

    /// What to draw with now.
    pub fn level(&self, now: Duration) -> Level {
        if self.adapts && self.until_rest(now).is_some() {
            Level::of_work(self.work)
        } else {
            Level::FULL
        }
    }

    /// How long it is until the picture counts as at rest; `None` where it is.
    pub fn until_rest(&self, now: Duration) -> Option<Duration> {
        let since = now.saturating_sub(self.last_change?);
        REST.checked_sub(since).filter(|left| !left.is_zero())
    }

    /// Takes notice of what a frame took, fetching and showing it included.
    pub fn measured(&mut self, level: Level, ms: f64) {
        if ms > 0.0 {
            // Frames have a fixed cost too, so this overshoots: half the way is taken up, all of it down.
            let aim = level.work() * TARGET_MS / ms;
            let change = (aim / self.work).clamp(0.2, 1.5);
            self.work = (self.work * change).clamp(Level::of_work(0.0).work(), 1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(n: u64) -> Duration {
        Duration::from_millis(n)
    }

    /// Drives a renderer whose full frame takes so long, fixed costs apart.
    fn settle(full_ms: f64, fixed_ms: f64) -> (Level, f64) {
        let mut quality = Quality::default();
        let mut took = 0.0;
        for i in 0..40 {
            quality.moved(ms(i * 50));
            let level = quality.level(ms(i * 50));
            took = fixed_ms + full_ms * level.work();
            quality.measured(level, took);
        }
        (quality.level(ms(39 * 50)), took)
    }

    #[test]
    fn the_frame_time_is_held_as_far_as_coarseness_goes() {
        for full_ms in [200.0, 500.0, 2000.0] {
            let (level, took) = settle(full_ms, 10.0);
            assert!(level.scale < 1.0 && level.step > 1.0);
            assert!(took < TARGET_MS * 1.2, "{full_ms}: {took}");
        }
        // Where nothing need be saved, nothing is.
        let (level, _) = settle(20.0, 5.0);
        assert_eq!(level, Level::FULL);
        // And there is an end to it.
        let (level, _) = settle(1e6, 0.0);
        assert_eq!((level.scale, level.step), (LEAST_SCALE, MOST_STEP));
    }

    #[test]
    fn the_picture_at_rest_is_the_full_one() {
        let mut quality = Quality::default();
        assert_eq!(quality.level(ms(0)), Level::FULL);
        quality.moved(ms(1000));
        assert_ne!(quality.level(ms(1100)), Level::FULL);
        assert!(quality.until_rest(ms(1100)).is_some());
        assert_eq!(quality.until_rest(ms(1150)), None);
        assert_eq!(quality.level(ms(1150)), Level::FULL);
        quality.adapts = false;
        quality.moved(ms(2000));
        assert_eq!(quality.level(ms(2001)), Level::FULL);
    }
}
