//! Which blocks a mode can leave out.

use std::ops::RangeInclusive;

use super::{Mode, Window};
use crate::transfer::{Domain, Table};

/// What makes a block contribute to pictures in a mode. Two modes of the same activity share what was culled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Activity {
    /// Something in it is visible by the table.
    Visible,
    /// Something in it lies beyond a table coordinate.
    Beyond {
        /// The coordinate.
        x: f64,
        /// 1: above it; -1: below it.
        direction: f64,
    },
}

impl Activity {
    pub(super) fn of(mode: &Mode, domain: &Domain) -> Self {
        let direction = domain.direction();
        // Shaders round: what they take for the end of a window lies within two snaps of it (Parameters::window_dead), so
        // that one is given away here; what they take for solid lies a snap below at most.
        let snap = domain.snap();
        let above = |value: f64| Self::Beyond {
            x: domain.x_from_value(value) + direction * snap,
            direction,
        };
        let solid = |iso: f64| Self::Beyond {
            x: domain.x_from_value(iso) - direction * snap,
            direction,
        };
        match *mode {
            Mode::EmissionAbsorption | Mode::Shaded(_) => Self::Visible,
            Mode::Grey(Window { low, .. })
            | Mode::Mip(Window { low, .. })
            | Mode::Mean(Window { low, .. }) => above(low),
            Mode::Minip(Window { high, .. }) => Self::Beyond {
                x: domain.x_from_value(high) - direction * snap,
                direction: -direction,
            },
            Mode::Normals { iso } | Mode::Phong { iso, .. } => solid(iso),
            Mode::TwoSurfaces { outer, .. } => solid(outer.iso),
        }
    }

    /// Whether a block whose samples have table coordinates in `range` can contribute.
    pub fn is_active(self, table: &Table, range: RangeInclusive<f64>) -> bool {
        match self {
            Self::Visible => table.is_visible(range),
            Self::Beyond { x, direction } if direction > 0.0 => x < *range.end(),
            Self::Beyond { x, .. } => *range.start() < x,
        }
    }

    /// Whether what was culled for `old` and its table holds for this one and its own.
    pub fn is_that_of(self, table: &Table, old: Self, old_table: &Table) -> bool {
        self == old
            && match self {
                Self::Visible => table.shows_the_same_as(old_table),
                Self::Beyond { .. } => table.domain() == old_table.domain(),
            }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::{ControlPoint, TransferFunction};
    use crate::volume::{Rescale, phantom};

    /// An 8-bit table over values `slope * stored`.
    fn table(slope: f64) -> Table {
        let mut volume = phantom::make("empty", [4; 3]).unwrap();
        volume.rescale = Rescale {
            slope,
            intercept: 0.0,
        };
        let domain = Domain::new(&volume, [0.0, 255.0], 256).unwrap();
        let point = ControlPoint {
            value: 0.0,
            opacity: 1.0,
            color: [1.0; 3],
        };
        TransferFunction::new(vec![point], 1.0)
            .unwrap()
            .bake(&domain, 1.0)
    }

    #[test]
    fn a_block_is_active_from_the_threshold_on() {
        let window = Window {
            low: 40.0,
            high: 80.0,
        };
        let iso = Mode::Normals { iso: 40.0 };
        let up = table(1.0);
        for mode in [Mode::Grey(window), Mode::Mip(window), Mode::Mean(window)] {
            assert!(!mode.is_active(&up, 0.0..=40.0), "{mode:?}");
            assert!(mode.is_active(&up, 0.0..=41.0), "{mode:?}");
        }
        assert!(iso.is_active(&up, 0.0..=40.0) && !iso.is_active(&up, 0.0..=39.0));
        assert!(Mode::Minip(window).is_active(&up, 79.0..=255.0));
        assert!(!Mode::Minip(window).is_active(&up, 80.0..=255.0));
    }

    #[test]
    fn falling_data_values_turn_it_round() {
        let window = Window {
            low: -80.0,
            high: -40.0,
        };
        let iso = Mode::Normals { iso: -40.0 };
        let down = table(-1.0);
        let mip = Mode::Mip(window);
        assert!(!mip.is_active(&down, 80.0..=255.0) && mip.is_active(&down, 79.0..=255.0));
        assert!(iso.is_active(&down, 40.0..=255.0) && !iso.is_active(&down, 41.0..=255.0));
        let minip = Mode::Minip(window);
        assert!(!minip.is_active(&down, 0.0..=40.0) && minip.is_active(&down, 0.0..=41.0));
    }
}
