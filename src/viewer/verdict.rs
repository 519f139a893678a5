//! What the chosen method is worth here, in one line.

use crate::render::Choice;
use crate::skip::Skip;

/// Gains below this are not worth a word.
const WORTH_A_WORD: f64 = 1.1;

/// Frame times of the same picture by several choices.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// What the picture is drawn by.
    pub current: Choice,
    /// Choices with their frame times in ms; box is among them.
    pub rows: Vec<(Choice, f64)>,
}

impl Verdict {
    fn ms(&self, choice: &Choice) -> Option<f64> {
        self.rows.iter().find(|(c, _)| c == choice).map(|r| r.1)
    }

    fn box_ms(&self) -> Option<f64> {
        let row = self.rows.iter().find(|(c, _)| c.skip == Skip::Box);
        row.map(|r| r.1)
    }

    /// A choice that is worth changing to.
    pub fn better(&self) -> Option<Choice> {
        let now = self.ms(&self.current)?;
        let best = self.rows.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        (now > best.1 * WORTH_A_WORD).then_some(best.0)
    }

    /// What was measured, a line for each.
    pub fn details(&self) -> String {
        let mut lines = vec!["least frame time of this picture, smaller:".to_owned()];
        let rows = self.rows.iter();
        lines.extend(rows.map(|(choice, ms)| format!("{}: {ms:.1} ms", choice.words())));
        lines.join("\n")
    }

    /// One line.
    pub fn words(&self) -> String {
        let (Some(base), Some(now)) = (self.box_ms(), self.ms(&self.current)) else {
            return String::new();
        };
        let name = |choice: &Choice| choice.skip.method().name;
        let times = |ms: f64| format!("{:.1}x box", base / ms);
        let current = if self.current.skip == Skip::Box {
            format!("box takes {base:.1} ms here")
        } else {
            format!("{} is {} here", name(&self.current), times(now))
        };
        match self.better().and_then(|c| Some((c, self.ms(&c)?))) {
            Some((better, ms)) if better.skip == Skip::Box => {
                format!(
                    "{current}; box itself takes {:.0} % of its time",
                    100.0 * ms / now
                )
            }
            Some((better, ms)) => {
                format!("{current}; {} would be {}", better.words(), times(ms))
            }
            None => format!("{current}; nothing that auto knows of is faster"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::skip::Cuts;

    fn choice(skip: Skip) -> Choice {
        Choice {
            skip,
            block: 8,
            cuts: Cuts::default(),
        }
    }

    #[test]
    fn a_faster_way_is_named_and_a_slower_one_is_not() {
        let [base, half, beam] = [Skip::Box, Skip::HalfSplit, Skip::BeamMasks].map(choice);
        let verdict = Verdict {
            current: half,
            rows: vec![(base, 34.0), (half, 10.0), (beam, 6.8)],
        };
        assert_eq!(verdict.better(), Some(beam));
        let words = verdict.words();
        assert!(
            words.starts_with("half-split is 3.4x box here; beam-masks"),
            "{words}"
        );
        assert!(words.ends_with("would be 5.0x box"), "{words}");
        assert!(
            verdict
                .details()
                .contains("half-split, blocks of 8, cut middle: 10.0 ms")
        );
        let content = Verdict {
            current: beam,
            ..verdict.clone()
        };
        assert_eq!(content.better(), None);
        assert!(content.words().contains("nothing"));
        let full = Verdict {
            current: half,
            rows: vec![(base, 5.0), (half, 10.0)],
        };
        assert_eq!(full.better(), Some(base));
        assert!(full.words().contains("50 %"), "{}", full.words());
    }
}
