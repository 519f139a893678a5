//! What is told of work that takes longer than a second, where someone is looking.

use std::fmt::Write;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressState, ProgressStyle};

/// Work shorter than this passes unmentioned.
const PATIENCE: Duration = Duration::from_secs(1);
/// Ticks of the bar, of which there are 1000.
const TICKS: u64 = 1000;

/// A line on stderr that says what is being done; nothing where stderr is no terminal (indicatif sees to that).
pub(super) struct Progress(ProgressBar);

impl Progress {
    /// Work of unknown length.
    pub(super) fn spinner(what: &'static str) -> Self {
        Self::start(ProgressBar::new_spinner(), "{late}", move |state| {
            format!("{what} ... {:.0} s", state.elapsed().as_secs_f64())
        })
    }

    /// Work whose progress is told by [`Self::set`].
    pub(super) fn bar(what: &'static str) -> Self {
        Self::start(ProgressBar::new(TICKS), "{late}", move |state| {
            let fraction = state.fraction();
            let done = (fraction * 30.0) as usize;
            let left = if fraction > 0.0 {
                format!(", about {} s left", state.eta().as_secs())
            } else {
                String::new()
            };
            format!(
                "{what} [{}{}] {:.0} %{left}",
                "#".repeat(done),
                " ".repeat(30 - done.min(30)),
                fraction * 100.0
            )
        })
    }

    fn start(
        bar: ProgressBar,
        template: &str,
        line: impl Fn(&ProgressState) -> String + Clone + Send + Sync + 'static,
    ) -> Self {
        let style = ProgressStyle::with_template(template)
            .expect("the template is a constant")
            .with_key("late", move |state: &ProgressState, out: &mut dyn Write| {
                if state.elapsed() >= PATIENCE {
                    // Writing to indicatif's string cannot fail.
                    let _ = out.write_str(&line(state));
                }
            });
        bar.set_style(style);
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }

    /// How much is done, 0 to 1.
    pub(super) fn set(&self, fraction: f64) {
        self.0.set_position((fraction * TICKS as f64) as u64);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
