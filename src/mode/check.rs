//! What of a mode can be wrong, and what a user should know of it.

use super::{MODES, Mode, ModeRow, Window};
use crate::error::{Error, Result};
use crate::volume::Statistics;

impl Mode {
    /// Checks that a backend has this mode.
    ///
    /// # Errors
    /// [`Error::Setting`] that names the modes that it has.
    pub fn check_backend(&self, backend: &str) -> Result<()> {
        let has = |row: &&ModeRow| row.backends.contains(&backend);
        if has(&self.row()) {
            return Ok(());
        }
        let those: Vec<&str> = MODES.iter().filter(has).map(|row| row.name).collect();
        Err(Error::setting(
            "mode",
            format!(
                "the {backend} backend does not have {}; it has {}; {} have it",
                self.name(),
                those.join(", "),
                self.row().backends.join(", ")
            ),
        ))
    }

    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::Setting`] that names the one that is out of range.
    pub fn check(&self) -> Result<()> {
        match self {
            Self::EmissionAbsorption => Ok(()),
            Self::Shaded(lighting) => lighting.check(),
            Self::Grey(window) | Self::Mip(window) | Self::Minip(window) | Self::Mean(window) => {
                window.check()
            }
            Self::Normals { iso } => check_finite("iso", *iso),
            Self::Phong {
                iso,
                color,
                lighting,
            } => {
                check_finite("iso", *iso)?;
                check_color("surface color", color)?;
                lighting.check()
            }
            Self::TwoSurfaces {
                outer,
                iso,
                color,
                lighting,
            } => {
                check_finite("iso", outer.iso)?;
                check_finite("iso2", *iso)?;
                if *iso <= outer.iso {
                    return Err(Error::setting(
                        "iso2",
                        format!(
                            "{iso} must lie above iso, {}: the inner surface lies in the outer one",
                            outer.iso
                        ),
                    ));
                }
                if !(outer.opacity > 0.0 && outer.opacity <= 1.0) {
                    return Err(Error::setting(
                        "outer opacity",
                        "must lie above 0 and not above 1",
                    ));
                }
                check_color("outer color", &outer.color)?;
                check_color("surface color", color)?;
                lighting.check()
            }
        }
    }

    /// What a user should know who draws data of these statistics: that no surface is there, for one.
    pub fn warning(&self, statistics: &Statistics) -> Option<String> {
        let [low, high] = statistics.value_range();
        let about = |name: &str, iso: f64| {
            if iso > high {
                Some(format!(
                    "{name} {iso} lies above all data ({low} to {high}): nothing is hit"
                ))
            } else if iso <= low {
                Some(format!(
                    "{name} {iso} lies below all data ({low} to {high}): the whole box is solid"
                ))
            } else {
                None
            }
        };
        match self {
            Self::Normals { iso } | Self::Phong { iso, .. } => about("iso", *iso),
            Self::TwoSurfaces { outer, iso, .. } => {
                about("iso", outer.iso).or_else(|| about("iso2", *iso))
            }
            Self::Grey(window) | Self::Mip(window) | Self::Mean(window) => {
                let Window {
                    low: from,
                    high: to,
                } = window;
                (*from >= high).then(|| {
                    format!(
                        "window {from}:{to} lies above all data ({low} to {high}): nothing is seen"
                    )
                })
            }
            Self::Minip(Window {
                low: from,
                high: to,
            }) => (*to <= low).then(|| {
                format!("window {from}:{to} lies below all data ({low} to {high}): nothing is seen")
            }),
            Self::EmissionAbsorption | Self::Shaded(_) => None,
        }
    }
}

impl Window {
    fn check(self) -> Result<()> {
        let Self { low, high } = self;
        check_finite("window", low)?;
        check_finite("window", high)?;
        if low < high {
            Ok(())
        } else {
            Err(Error::setting(
                "window",
                format!("{low}:{high} is empty; its lower end must lie below its upper one"),
            ))
        }
    }
}

fn check_finite(field: &str, number: f64) -> Result<()> {
    if number.is_finite() {
        Ok(())
    } else {
        Err(Error::setting(field, "must be a finite number"))
    }
}

fn check_color(field: &str, color: &[f64; 3]) -> Result<()> {
    if color.iter().all(|c| (0.0..=1.0).contains(c)) {
        Ok(())
    } else {
        Err(Error::setting(
            field,
            "red, green and blue must lie between 0 and 1",
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mode::{Light, Lighting, Outer};

    #[test]
    fn parameters_out_of_range_are_named() {
        let named = |mode: Mode, field: &str| {
            let error = mode.check().unwrap_err().to_string();
            assert!(error.starts_with(field), "{error}");
        };
        let window = |low, high| Window { low, high };
        named(Mode::Mip(window(3.0, 3.0)), "window");
        named(Mode::Mean(window(4.0, 3.0)), "window");
        named(Mode::Grey(window(f64::NAN, 3.0)), "window");
        named(Mode::Normals { iso: f64::INFINITY }, "iso");
        let lighting = Lighting::default();
        let dark = Lighting {
            light: Light::From([0.0; 3]),
            ..lighting
        };
        named(Mode::Shaded(dark), "light");
        let two = |outer_iso, iso, opacity| Mode::TwoSurfaces {
            outer: Outer {
                iso: outer_iso,
                color: [0.5; 3],
                opacity,
            },
            iso,
            color: [1.0; 3],
            lighting,
        };
        named(two(5.0, 5.0, 0.5), "iso2");
        named(two(5.0, 6.0, 0.0), "outer opacity");
    }
}
