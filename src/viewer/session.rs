//! What is kept of a session in a file, and the list of volumes opened last.

use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::camera::Projection;
use crate::error::{Error, Result};
use crate::mode::Mode;
use crate::render::{BackendChoice, MethodChoice};
use crate::sample::{Classification, Gradients, Sampler};
use crate::skip::{Cuts, HalfCut};
use crate::transfer::TransferFunction;
use crate::volume::Source;

use super::command::slices_flag;
use super::look::{Look, Way};
use super::view::View;

/// One volume, and how it is looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    /// Where the volume is from.
    pub source: Source,
    /// What is shown.
    pub look: Look,
    /// How.
    pub way: Way,
    /// The other way that it is compared with.
    pub other: Way,
    /// From where.
    pub view: View,
}

/// A session's file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    hollowcast_session: u32,
    volumes: Vec<Entry>,
}

/// The version of the format that is written and read.
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    source: Source,
    transfer: String,
    clip_box: [String; 3],
    clip_planes: Vec<[f64; 4]>,
    background: Option<[u8; 3]>,
    depth_cue: f64,
    eye: [f64; 3],
    target: [f64; 3],
    up: [f64; 3],
    fov: Option<f64>,
    ortho: Option<f64>,
    way: WayEntry,
    other: WayEntry,
    mode: Mode,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct WayEntry {
    method: String,
    block: usize,
    cut: String,
    cuts: String,
    sampler: Option<String>,
    classification: String,
    gradients: String,
    slices: Option<String>,
    step: f64,
    ert: f32,
    backend: String,
}

/// The text of a session's file.
///
/// # Errors
/// None that values which can be shown cause.
pub fn to_toml(kept: &[Kept]) -> Result<String> {
    let file = File {
        hollowcast_session: VERSION,
        volumes: kept.iter().map(entry).collect(),
    };
    toml::to_string(&file).map_err(|e| Error::setting("session", e.to_string()))
}

/// What a session's file holds.
///
/// # Errors
/// [`Error::Io`], or [`Error::File`] naming the line or field that is wrong.
pub fn read(path: &Path) -> Result<Vec<Kept>> {
    let text = crate::text_file::read(path, crate::text_file::WRITTEN_BYTES)?;
    from_toml(&text).map_err(|e| e.in_file(path))
}

/// Parses the text of a session's file.
///
/// # Errors
/// [`Error::Setting`] naming the line or field that is wrong.
pub fn from_toml(text: &str) -> Result<Vec<Kept>> {
    let file: File = toml::from_str(text).map_err(|e| {
        let before = e.span().and_then(|span| text.get(..span.start));
        let line = before.unwrap_or_default().matches('\n').count() + 1;
        let reason = e.message().trim().replace('\n', " ");
        Error::setting(format!("line {line}"), reason)
    })?;
    if file.hollowcast_session != VERSION {
        let reason = format!("is not {VERSION}, which this version reads");
        return Err(Error::setting("hollowcast_session", reason));
    }
    file.volumes.into_iter().map(kept).collect()
}

fn entry(kept: &Kept) -> Entry {
    let end = |end: Option<f64>| end.map_or(String::new(), |n| format!("{n:?}"));
    let (fov, ortho) = match kept.view.projection {
        Projection::Perspective { fov_y_degrees } => (Some(fov_y_degrees), None),
        Projection::Orthographic { height } => (None, Some(height)),
    };
    Entry {
        source: kept.source.clone(),
        transfer: kept.look.transfer.to_toml(),
        clip_box: kept
            .look
            .clip_box
            .map(|[from, to]| format!("{}:{}", end(from), end(to))),
        clip_planes: kept.look.clip_planes.clone(),
        background: kept.look.background,
        depth_cue: kept.look.depth_cue,
        eye: kept.view.eye.to_array(),
        target: kept.view.target.to_array(),
        up: kept.view.up.to_array(),
        fov,
        ortho,
        way: way_entry(&kept.way),
        other: way_entry(&kept.other),
        mode: kept.look.mode,
    }
}

fn way_entry(way: &Way) -> WayEntry {
    WayEntry {
        method: way.method.name().to_owned(),
        block: way.block,
        cut: way.cuts.half.name().to_owned(),
        cuts: way.cuts.slabs.to_string(),
        sampler: way.sampler.map(|s| s.name().to_owned()),
        classification: way.classification.name().to_owned(),
        gradients: way.gradients.name().to_owned(),
        slices: way.slices.map(slices_flag),
        step: way.step_voxels,
        ert: way.ert,
        backend: way.backend.name().to_owned(),
    }
}

fn kept(entry: Entry) -> Result<Kept> {
    entry.mode.check()?;
    let projection = match (entry.fov, entry.ortho) {
        (Some(fov_y_degrees), None) => Projection::Perspective { fov_y_degrees },
        (None, Some(height)) => Projection::Orthographic { height },
        _ => return Err(Error::setting("fov, ortho", "one of them must be given")),
    };
    let view = View {
        eye: DVec3::from_array(entry.eye),
        target: DVec3::from_array(entry.target),
        up: DVec3::from_array(entry.up),
        projection,
    };
    view.camera(DVec3::ONE).check()?;
    let mut clip_box = [[None; 2]; 3];
    for (range, text) in clip_box.iter_mut().zip(&entry.clip_box) {
        *range = clip_range(text)?;
    }
    Ok(Kept {
        source: entry.source,
        look: Look {
            transfer: TransferFunction::from_toml(&entry.transfer)?,
            mode: entry.mode,
            clip_box,
            clip_planes: entry.clip_planes,
            background: entry.background,
            depth_cue: entry.depth_cue,
        },
        way: way(&entry.way)?,
        other: way(&entry.other)?,
        view,
    })
}

fn clip_range(text: &str) -> Result<[Option<f64>; 2]> {
    let end = |s: &str| match s {
        "" => Some(None),
        number => number.parse().ok().filter(|n| f64::is_finite(*n)).map(Some),
    };
    text.split_once(':')
        .and_then(|(from, to)| Some([end(from)?, end(to)?]))
        .ok_or_else(|| Error::setting("clip_box", "expected FROM:TO per axis"))
}

/// One of named choices.
fn named<T: Copy>(field: &str, given: &str, all: &[T], name: fn(T) -> &'static str) -> Result<T> {
    let found = all.iter().copied().find(|&one| name(one) == given);
    found.ok_or_else(|| unknown(field, given))
}

fn unknown(field: &str, given: &str) -> Error {
    Error::setting(field, format!("\"{}\" is not known", given.escape_debug()))
}

fn way(entry: &WayEntry) -> Result<Way> {
    if !crate::octree::BLOCKS.contains(&entry.block) {
        return Err(unknown("block", &entry.block.to_string()));
    }
    let method = MethodChoice::from_name(&entry.method);
    let slabs = entry.cuts.parse();
    let sampler = entry.sampler.as_ref();
    Ok(Way {
        method: method.ok_or_else(|| unknown("method", &entry.method))?,
        block: entry.block,
        cuts: Cuts {
            half: named("cut", &entry.cut, HalfCut::ALL, HalfCut::name)?,
            slabs: slabs.map_err(|e: String| Error::setting("cuts", e))?,
        },
        sampler: sampler
            .map(|name| named("sampler", name, Sampler::ALL, Sampler::name))
            .transpose()?,
        classification: named(
            "classification",
            &entry.classification,
            Classification::ALL,
            Classification::name,
        )?,
        gradients: named(
            "gradients",
            &entry.gradients,
            Gradients::ALL,
            Gradients::name,
        )?,
        slices: entry.slices.as_ref().map(|s| s.parse()).transpose()?,
        step_voxels: entry.step,
        ert: entry.ert,
        backend: named(
            "backend",
            &entry.backend,
            BackendChoice::ALL,
            BackendChoice::name,
        )?,
    })
}

/// The most files that are remembered.
const MOST_RECENT: usize = 12;

/// Volumes opened last, the last first; kept in the user's cache folder.
#[derive(Debug, Clone, Default)]
pub struct Recent {
    file: Option<PathBuf>,
    /// With the flags that they were read by.
    pub volumes: Vec<Source>,
}

impl Recent {
    /// Those of the user.
    pub fn load() -> Self {
        Self::kept_in(crate::render::cache_file("recent.json"))
    }

    /// Those that a file keeps.
    fn kept_in(file: Option<PathBuf>) -> Self {
        let text = file.as_deref().map(std::fs::read_to_string);
        let text = text.and_then(std::result::Result::ok).unwrap_or_default();
        Self {
            file,
            volumes: serde_json::from_str(&text).unwrap_or_default(),
        }
    }

    /// Puts a volume first, and remembers it where that is possible.
    pub fn add(&mut self, source: &Source) {
        self.volumes.retain(|s| s != source);
        self.volumes.insert(0, source.clone());
        self.volumes.truncate(MOST_RECENT);
        if let Some(file) = &self.file {
            let text = serde_json::json!(self.volumes).to_string();
            let folder = file.parent().map(std::fs::create_dir_all);
            if let Some(Err(error)) = folder {
                tracing::debug!("{}: {error}", file.display());
            }
            if let Err(error) = std::fs::write(file, text) {
                tracing::debug!("{}: {error}", file.display());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mode::MODES;
    use crate::render::SliceCount;
    use crate::volume::{Statistics, phantom};

    fn some(row: usize) -> Kept {
        let volume = phantom::make("pot", [12; 3]).unwrap();
        let statistics = Statistics::of(&volume);
        let mut look = Look::of(&statistics).unwrap();
        look.mode = (MODES[row].suited_to)(&statistics);
        look.clip_box[1] = [Some(1.5), None];
        look.clip_planes = vec![[1.0, 0.0, -0.1, 2.0]];
        look.background = Some([1, 2, 255]);
        look.depth_cue = 0.25;
        let mut view = View::home(volume.extent(), volume.voxel_size());
        if row == 3 {
            view.toggle_parallel(volume.voxel_size());
        }
        Kept {
            source: Source {
                pad_cube: row == 1,
                ..Source::new("phantom:pot:12")
            },
            look,
            way: Way {
                sampler: Some(Sampler::Nearest),
                classification: Classification::PreIntegrated,
                gradients: Gradients::Half,
                slices: (row == 2).then_some(SliceCount::Exactly(77)),
                step_voxels: 0.3,
                ..Way::default()
            },
            other: Way::default(),
            view,
        }
    }

    #[test]
    fn what_is_written_reads_back_the_same() {
        let all: Vec<Kept> = (0..MODES.len()).map(some).collect();
        assert_eq!(from_toml(&to_toml(&all).unwrap()).unwrap(), all);
    }

    #[test]
    fn volumes_opened_last_are_remembered_once_and_the_last_comes_first() {
        let folder = tempfile::tempdir().unwrap();
        let file = Some(folder.path().join("cache/recent.json"));
        let mut recent = Recent::kept_in(file.clone());
        let raw = some(1).source;
        for source in [&Source::new("a.nrrd"), &raw, &Source::new("a.nrrd")] {
            recent.add(source);
        }
        assert_eq!(recent.volumes, [Source::new("a.nrrd"), raw]);
        assert_eq!(Recent::kept_in(file).volumes, recent.volumes);
    }

    #[test]
    fn what_is_wrong_is_named_in_one_line() {
        let good = to_toml(&[some(0)]).unwrap();
        for (from, to, named) in [
            (
                "hollowcast_session = 1",
                "hollowcast_session = 9",
                "hollowcast_session",
            ),
            ("method = \"auto\"", "method = \"magic\"", "method"),
            ("block = 8", "block = 9", "block"),
            ("up = [", "op = [", "line"),
            ("backend = \"auto\"", "backend = \"abacus\"", "backend"),
            ("gradients = \"half\"", "gradients = \"third\"", "gradients"),
        ] {
            assert!(good.contains(from), "{from} in {good}");
            let error = from_toml(&good.replace(from, to)).unwrap_err();
            let line = error.to_string();
            assert!(
                error.is_bad_input() && line.contains(named) && !line.contains('\n'),
                "{line}"
            );
        }
    }
}
