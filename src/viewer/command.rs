//! The command line that draws the same picture, bit for bit.

use crate::lattice::Clipping;
use crate::mode::{Light, Lighting, Mode, Window};
use crate::output::srgb_from_linear;
use crate::render::{Choice, Settings, SliceCount};
use crate::sample::{Classification, Sampler};
use crate::skip::Skip;
use crate::transfer::{PRESETS, TransferFunction};
use crate::volume::{Source, Statistics};

use super::look::Look;
use super::view::View;
use crate::camera::Projection;

/// A picture as it was or will be drawn: all that the command is told.
#[derive(Debug)]
pub struct Drawn<'a> {
    /// The volume, and how it is read.
    pub source: &'a Source,
    /// Of the volume: what presets and modes follow from.
    pub statistics: &'a Statistics,
    /// What is shown.
    pub look: &'a Look,
    /// From where.
    pub view: &'a View,
    /// The settings, with the method that was drawn by.
    pub settings: &'a Settings,
    /// The sampler that was used.
    pub sampler: Sampler,
    /// The backend that drew: `gpu`, `cpu` or `reference`.
    pub backend: &'a str,
}

impl Drawn<'_> {
    /// The arguments after `hollowcast`, without an output file.
    pub fn arguments(&self) -> Vec<String> {
        let settings = self.settings;
        let mut words = vec!["render".to_owned(), self.source.volume.clone()];
        if self.source.pad_cube {
            words.push("--pad-cube".to_owned());
        }
        let mut flag = |name: &str, value: String| words.extend([name.to_owned(), value]);
        reading(&mut flag, self.source);
        flag("--backend", self.backend.to_owned());
        match settings.slices {
            Some(count) => {
                flag("--renderer", "slices".to_owned());
                flag("--slices", slices_flag(count));
            }
            None => flag("--method", settings.skip.method().name.to_owned()),
        }
        if settings.skip.reads_blocks() {
            flag("--block", settings.block.to_string());
        }
        if let Some(cut) = Choice::of(settings).cut_words() {
            let name = if settings.skip == Skip::KCuts {
                "--cuts"
            } else {
                "--cut"
            };
            flag(name, cut);
        }
        flag("--sampler", self.sampler.name().to_owned());
        if settings.classification != Classification::Post {
            let name = settings.classification.name();
            flag("--classification", name.to_owned());
        }
        flag("--step", format!("{:?}", settings.step_voxels));
        let ert = if settings.ert >= 1.0 {
            "off".to_owned()
        } else {
            format!("{:?}", settings.ert)
        };
        flag("--ert", ert);
        let [width, height] = settings.size;
        flag("--size", format!("{width}x{height}"));
        flag("--camera", camera(self.view));
        if self.look.mode.takes_table() {
            flag("--tf", transfer(&self.look.transfer, self.statistics));
            flag("--table-size", settings.table_entries.to_string());
        }
        self.mode(&mut flag);
        if settings.mode.takes_gradients() {
            flag("--gradients", settings.gradients.name().to_owned());
        }
        if settings.depth_cue > 0.0 {
            flag("--depth-cue", format!("{:?}", settings.depth_cue));
        }
        if settings.clipping != Clipping::NONE {
            if self.look.clip_box != [[None; 2]; 3] {
                let end = |end: Option<f64>| end.map_or(String::new(), |n| format!("{n:?}"));
                let ranges = self.look.clip_box;
                let ranges = ranges.map(|[from, to]| format!("{}:{}", end(from), end(to)));
                flag("--clip-box", ranges.join(","));
            }
            for plane in &self.look.clip_planes {
                flag("--clip-plane", numbers(plane));
            }
        }
        if let Some([r, g, b]) = self.look.background {
            flag("--background", format!("#{r:02x}{g:02x}{b:02x}"));
        }
        words
    }

    /// The whole line, quoted for a shell.
    pub fn line(&self, output: &str) -> String {
        let mut words = vec!["hollowcast".to_owned()];
        words.extend(self.arguments());
        words.extend(["-o".to_owned(), output.to_owned()]);
        words
            .iter()
            .map(|word| quoted(word))
            .collect::<Vec<_>>()
            .join(" ")
    }

    fn mode(&self, flag: &mut impl FnMut(&str, String)) {
        let mode = self.look.mode;
        flag("--mode", mode.name().to_owned());
        let suited = (mode.row().suited_to)(self.statistics);
        match (mode, suited) {
            (Mode::EmissionAbsorption, _) => {}
            (Mode::Shaded(lighting), _) => lit(flag, &lighting),
            (Mode::Grey(w) | Mode::Mip(w) | Mode::Minip(w) | Mode::Mean(w), _) => window(flag, w),
            (Mode::Normals { iso }, _) => flag("--iso", format!("{iso:?}")),
            (
                Mode::Phong {
                    iso,
                    color,
                    lighting,
                },
                Mode::Phong { color: usual, .. },
            ) => {
                flag("--iso", format!("{iso:?}"));
                colored(flag, "--surface-color", color, usual);
                lit(flag, &lighting);
            }
            (
                Mode::TwoSurfaces {
                    outer,
                    iso,
                    color,
                    lighting,
                },
                Mode::TwoSurfaces {
                    outer: usual_outer,
                    color: usual,
                    ..
                },
            ) => {
                flag("--iso", format!("{:?}", outer.iso));
                flag("--iso2", format!("{iso:?}"));
                flag("--outer-opacity", format!("{:?}", outer.opacity));
                colored(flag, "--outer-color", outer.color, usual_outer.color);
                colored(flag, "--surface-color", color, usual);
                lit(flag, &lighting);
            }
            (Mode::Phong { .. } | Mode::TwoSurfaces { .. }, _) => {
                unreachable!("a row makes its own mode")
            }
        }
    }
}

/// The count of slices, as `--slices` reads it.
pub(super) fn slices_flag(count: SliceCount) -> String {
    match count {
        SliceCount::PerVoxel => "voxel".to_owned(),
        SliceCount::Exactly(count) => count.to_string(),
    }
}

/// How the volume is read, where not just so.
fn reading(flag: &mut impl FnMut(&str, String), source: &Source) {
    if let Some(crop) = &source.crop {
        flag("--crop", crop.to_string());
    }
    if let Some(n) = source.downsample {
        flag("--downsample", n.to_string());
    }
    if let Some(raw) = &source.raw {
        flag("--dims", raw.dims.map(|n| n.to_string()).join("x"));
        flag("--type", raw.scalar.name().to_owned());
        flag("--endian", raw.endian.name().to_owned());
        flag("--skip-bytes", raw.skip_bytes.to_string());
        flag("--spacing", numbers(&raw.spacing.to_array()));
    }
}

fn window(flag: &mut impl FnMut(&str, String), window: Window) {
    flag("--window", format!("{:?}:{:?}", window.low, window.high));
}

fn lit(flag: &mut impl FnMut(&str, String), lighting: &Lighting) {
    let light = match lighting.light {
        Light::Headlight => "headlight".to_owned(),
        Light::From(direction) => numbers(&direction),
    };
    flag("--light", light);
    flag("--ka", format!("{:?}", lighting.ambient));
    flag("--kd", format!("{:?}", lighting.diffuse));
    flag("--ks", format!("{:?}", lighting.specular));
    flag("--shininess", format!("{:?}", lighting.shininess));
}

/// A colour that was chosen; the mode's own is not sRGB in eight bits and is what no flag means.
fn colored(flag: &mut impl FnMut(&str, String), name: &str, color: [f64; 3], usual: [f64; 3]) {
    if color != usual {
        let [r, g, b] = srgb(color);
        flag(name, format!("#{r:02x}{g:02x}{b:02x}"));
    }
}

/// The nearest 8-bit sRGB colour to a linear one.
pub(super) fn srgb(linear: [f64; 3]) -> [u8; 3] {
    linear.map(|c| (srgb_from_linear(c.clamp(0.0, 1.0)) * 255.0).round() as u8)
}

/// As `--camera` reads it: each number as the shortest text that reads back the same.
fn camera(view: &View) -> String {
    let place = |name: &str, v: glam::DVec3| format!("{name}={}", numbers(&v.to_array()));
    let rays = match view.projection {
        Projection::Perspective { fov_y_degrees } => format!("fov={fov_y_degrees:?}"),
        Projection::Orthographic { height } => format!("ortho={height:?}"),
    };
    let parts = [
        place("eye", view.eye),
        place("target", view.target),
        place("up", view.up),
        rays,
    ];
    parts.join(";")
}

/// A preset by its name, where it is one; else the text of its file.
fn transfer(transfer: &TransferFunction, statistics: &Statistics) -> String {
    let preset = PRESETS.iter().find(|preset| {
        preset
            .transfer_function(statistics)
            .is_ok_and(|t| t == *transfer)
    });
    match preset {
        Some(preset) => preset.name.to_owned(),
        None => transfer.to_toml().trim_end().to_owned(),
    }
}

fn numbers(numbers: &[f64]) -> String {
    let texts: Vec<String> = numbers.iter().map(|n| format!("{n:?}")).collect();
    texts.join(",")
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,+".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_that_a_shell_would_take_apart_are_quoted() {
        assert_eq!(quoted("a/b-c_1.png"), "a/b-c_1.png");
        assert_eq!(quoted("eye=1;up=2"), "'eye=1;up=2'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
        assert_eq!(quoted(""), "''");
    }

    #[test]
    fn every_srgb_colour_is_found_again() {
        for byte in 0..=255u8 {
            let linear = super::super::look::linear([byte; 3]).map(f64::from);
            assert_eq!(srgb(linear), [byte; 3]);
        }
    }
}
