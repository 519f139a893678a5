//! The lines of a results file.

use std::fmt::Write as _;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::file::Paper;
use crate::measure::machine::Machine;
use crate::measure::statistics::Quartiles;
use crate::render::BackendInfo;
use crate::volume::Volume;

/// One line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Record {
    /// The first.
    Header(Header),
    /// Before a scene's cases.
    Scene(SceneRecord),
    /// A measured case.
    Case(Box<CaseRecord>),
    /// For the report: a row, whole or not at all.
    Pictures {
        /// The row.
        pictures: Vec<PictureRecord>,
    },
}

/// What was measured, and on what.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// The suite's name.
    pub suite: String,
    /// Names the content of its file.
    pub suite_hash: String,
    /// Processor, system, versions and commit.
    pub machine: MachineRecord,
    /// The backends that there are.
    pub adapters: Vec<AdapterRecord>,
    /// Backends that the suite asks for and that are not here, with the reason.
    pub missing: Vec<(String, String)>,
}

/// A machine and a program, as [`Machine`] has them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MachineRecord {
    /// The processor's model.
    pub cpu: String,
    /// Threads that run at once.
    pub cores: usize,
    /// The operating system.
    pub os: String,
    /// This crate's version.
    pub hollowcast: String,
    /// wgpu's.
    pub wgpu: Option<String>,
    /// The commit that the program was built from.
    pub commit: Option<String>,
}

impl From<Machine> for MachineRecord {
    fn from(machine: Machine) -> Self {
        Self {
            cpu: machine.cpu,
            cores: machine.cores,
            os: machine.os.to_owned(),
            hollowcast: machine.hollowcast.to_owned(),
            wgpu: machine.wgpu.map(str::to_owned),
            commit: machine.commit.map(str::to_owned),
        }
    }
}

/// A backend.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct AdapterRecord {
    /// As the suite asks for it.
    pub asked: String,
    /// `gpu`, `cpu` or `reference`.
    pub backend: String,
    /// The adapter's name.
    pub name: String,
    /// Driver name and version.
    pub driver: String,
    /// Whether it runs on the processor.
    pub is_software: bool,
}

impl AdapterRecord {
    /// What answered to `asked`.
    pub fn new(asked: &str, info: &BackendInfo) -> Self {
        Self {
            asked: asked.to_owned(),
            backend: info.backend.to_owned(),
            name: info.adapter.clone(),
            driver: info.driver.clone(),
            is_software: info.is_software,
        }
    }
}

/// A scene as it was drawn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SceneRecord {
    /// Its name in the suite.
    pub name: String,
    /// Its title, with what was drawn in its place.
    pub title: String,
    /// The volume that the suite names.
    pub volume: String,
    /// The phantom that was drawn in its place, where it was missing.
    pub stand_in: Option<String>,
    /// Names its voxels and their spacing.
    pub voxels_sha256: String,
    /// Voxels along x, y, z, as drawn.
    pub dims: [usize; 3],
    /// Bytes of its voxels.
    pub bytes: usize,
    /// Reading or making it, in ms.
    pub load_ms: f64,
    /// Which of the main paper's data it stands beside.
    pub paper: Option<Paper>,
    /// Scenes of one family differ in size alone.
    pub family: Option<String>,
}

impl SceneRecord {
    /// What names a volume's voxels, in hexadecimal.
    pub fn voxels_sha256(volume: &Volume) -> String {
        let mut hash = Sha256::new();
        // Numbers print as what reads back the same.
        hash.update(format!(
            "{:?} {:?} {:?} {:?} ",
            volume.voxels.voxel_type(),
            volume.dims,
            volume.spacing,
            volume.rescale,
        ));
        hash.update(volume.voxels.as_bytes());
        hash.finalize().iter().fold(String::new(), |mut hex, byte| {
            // Writing to a String cannot fail.
            let _ = write!(hex, "{byte:02x}");
            hex
        })
    }
}

/// A case as it was measured. Times are medians of each view's runs, averaged over the views; so are quartiles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CaseRecord {
    /// The command that measures it again, and its name.
    pub command: String,
    /// The scene by name.
    pub scene: String,
    /// `gpu`, `cpu` or `reference`.
    pub backend: String,
    /// The method's name.
    pub method: String,
    /// What `auto` chose for the first view, in words.
    pub chosen: Option<String>,
    /// Whether the method's pictures are those of box, bit for bit.
    pub lossless: bool,
    /// Block edge in voxels (without meaning for box and auto).
    pub block: usize,
    /// The step as the suite names it.
    pub step: String,
    /// The step in voxels of the smallest spacing.
    pub step_voxels: f64,
    /// The sampler.
    pub sampler: String,
    /// The classification, if it is not the usual one.
    pub classification: Option<String>,
    /// The mode.
    pub mode: String,
    /// Opacity at which rays stop, as the suite names it.
    pub ert: String,
    /// Width and height of the pictures.
    pub size: [u32; 2],
    /// Views.
    pub views: usize,
    /// Timed runs of the first view, those included that noise made run again.
    pub runs: usize,
    /// A frame after the structures stand, without read-back.
    pub frame_ms: Quartiles,
    /// Of it, finding the segments.
    pub raster_ms: f64,
    /// Of it, marching them.
    pub cast_ms: f64,
    /// What the adapter's own clock tells of a frame, where it has one.
    pub gpu_ms: Option<f64>,
    /// The standard error of the median frame time over it ([`crate::measure::statistics::noise`]), the mean of the views;
    /// `None` of fewer than three runs.
    pub noise: Option<f64>,
    /// Fetching a picture.
    pub read_back_ms: f64,
    /// Box's `frame_ms` with the same settings, measured in turns with this case.
    pub box_ms: f64,
    /// Building the structures for all views.
    pub preprocess_ms: f64,
    /// Classifying and culling them: what follows an edit of the table.
    pub cull_ms: f64,
    /// Memory of all that stands besides the volume.
    pub structure_bytes: u64,
    /// Samples taken, per pixel.
    pub samples: f64,
    /// Samples that added something, per pixel.
    pub contributing: f64,
    /// Segments asked for, or steps of a traversal, per pixel.
    pub skip_steps: f64,
    /// Pixels with any bit different from box's, over all views.
    pub differing_pixels_vs_box: u64,
    /// Largest difference of any channel from box's.
    pub max_abs_vs_box: f64,
    /// How far the first view's picture is from the truth, where that was measured.
    pub error: Option<ErrorRecord>,
}

/// How far a picture is from the truth: see [`crate::measure::metrics`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ErrorRecord {
    /// Width and height of the picture that was held against the truth.
    pub size: [u32; 2],
    /// Largest difference of any channel.
    pub max_abs: f64,
    /// Mean absolute difference.
    pub mean_abs: f64,
    /// Root of the mean squared difference.
    pub rms: f64,
    /// Share of pixels off by more than 1/255.
    pub off_share: f64,
    /// Structural similarity; `None` where the picture is too small for it.
    pub ssim: Option<f64>,
    /// FLIP; likewise.
    pub flip: Option<f64>,
    /// Pixels at a discontinuity, which are left out, over all pixels.
    pub masked_share: f64,
    /// How far the truth itself may be off, by its last two refinements.
    pub truth_bound: f64,
}

/// What a picture for the report shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum What {
    /// What was drawn.
    Picture,
    /// Its absolute difference from the truth, times the scale.
    Difference,
    /// Its samples per pixel as a heat map, the scale being the most.
    Samples,
}

/// A picture for the report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PictureRecord {
    /// The command that draws it again (that it is different from the truth by, or takes samples for).
    pub command: String,
    /// The scene by name.
    pub scene: String,
    /// `gpu`, `cpu` or `reference`.
    pub backend: String,
    /// The method's name; `truth` for the truth itself.
    pub method: String,
    /// Block edge in voxels.
    pub block: usize,
    /// The step.
    pub step: String,
    /// The mode.
    pub mode: String,
    /// What is shown.
    pub what: What,
    /// Amplification of a difference, most samples of a map, 1 of a picture.
    pub scale: f64,
    /// Width and height.
    pub size: [u32; 2],
    /// A PNG, in base64.
    pub png: String,
}
