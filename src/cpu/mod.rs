//! The CPU backend: real-time ray-casting without any GPU.
//!
//! The same three choices, the same lattice and the same contract as everywhere: a [`CpuPlan`] keeps what a skipping
//! method needs of a volume, a table and an occupancy; [`render`] draws a [`Scene`] with it. Rays go eight at a time
//! (the `packet` module) through tiles that rayon spreads over the threads. Every path of instructions and every number of
//! threads gives the same bits, as does every skipping method.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod cells;
mod grid;
mod march;
mod packet;
mod project;
mod table;
mod tile;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use self::cells::Cells;
use self::grid::Grid;
use self::march::{Counted, Job, Pixel, Skipping};
use self::packet::Voxel;
use self::project::Projection;
use self::table::Background;
use self::tile::TileArea;
use crate::error::{Error, Result};
use crate::mode::{Mode, Parameters};
use crate::octree::Occupancy;
use crate::sample::Sampler;
use crate::scene::{CountedPicture, Counters, Picture, Scene};
use crate::skip::beam_masks::{BeamMasks, Collapse};
use crate::skip::distance_map::DistanceMap;
use crate::skip::{Majorants, Skip};
use crate::transfer::Table;
use crate::volume::Volume;
use crate::with_voxels;

/// The instructions that packets are made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Path {
    /// AVX2 registers and gathers.
    Avx2,
    /// Eight scalar numbers side by side: runs everywhere, and what the others are tested against.
    Scalar,
}

impl Path {
    /// All paths, the fastest first.
    pub const ALL: &[Self] = &[Self::Avx2, Self::Scalar];

    /// The fastest path that this processor has.
    pub fn best() -> Self {
        if has_avx2() { Self::Avx2 } else { Self::Scalar }
    }

    /// The name used by reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Avx2 => "avx2",
            Self::Scalar => "scalar",
        }
    }

    /// Whether this processor has the instructions and the path takes volumes of these dimensions.
    pub fn is_available(self, dims: [usize; 3]) -> bool {
        match self {
            Self::Scalar => true,
            Self::Avx2 => {
                // Indices of voxels are signed 32-bit numbers, those of cells (whose rows are padded) unsigned ones.
                let voxels = dims.iter().product::<usize>();
                let cells = dims[0].next_multiple_of(32) * dims[1] * dims[2];
                has_avx2() && i32::try_from(voxels).is_ok() && u32::try_from(cells).is_ok()
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2")
}

#[cfg(not(target_arch = "x86_64"))]
fn has_avx2() -> bool {
    false
}

/// Edge of a tile in pixels, measured fastest.
pub const TILE: u32 = 8;

/// What a skipping method keeps of a volume, a table and an occupancy, from picture to picture.
///
/// A camera that moves, a step or an early termination that changes leave it valid; another table needs another plan.
#[derive(Debug)]
pub struct CpuPlan {
    skip: Skip,
    path: Path,
    tile: u32,
    dims: [usize; 3],
    skipping: Skipping,
    background: Option<Background>,
    cells: Option<Cells>,
    majorants: Option<Arc<Majorants>>,
}

impl CpuPlan {
    /// Prepares a method for pictures of `volume` through `table`. `occupancy` tells the blocks that are active for them;
    /// [`Skip::Box`] does not read it.
    ///
    /// # Errors
    /// [`Error::Setting`] where this backend does not have the method, or the occupancy is another volume's.
    pub fn new(skip: Skip, volume: &Volume, table: &Table, occupancy: &Occupancy) -> Result<Self> {
        skip.check_backend("cpu")?;
        if occupancy.volume_dims != volume.dims {
            return Err(Error::setting(
                "occupancy",
                format!(
                    "is of {:?} voxels, the volume of {:?}",
                    occupancy.volume_dims, volume.dims
                ),
            ));
        }
        let layers =
            |collapse| Skipping::Layers(Box::new(BeamMasks::new(occupancy.clone())), collapse);
        let skipping = match skip {
            Skip::Box => Skipping::Box,
            Skip::Hull => layers(Collapse::Hull),
            Skip::HalfSplit => layers(Collapse::Halves),
            Skip::BeamMasks => layers(Collapse::Runs),
            Skip::DistanceMap => Skipping::Distance(DistanceMap::new(occupancy)),
            Skip::KCuts
            | Skip::BeamCells
            | Skip::GridDda
            | Skip::SegmentList
            | Skip::OctreeEncoded
            | Skip::TwoStep
            | Skip::Adaptive
            | Skip::Oracle => unreachable!("refused above"),
        };
        let background = with_voxels!(&volume.voxels, v => Background::find(table, v));
        // The paper's methods are kept as they are; those that look at blocks look at cells too.
        let cells = match (&skipping, background) {
            (Skipping::Layers(_, Collapse::Runs) | Skipping::Distance(_), Some(background)) => {
                with_voxels!(&volume.voxels, v => background
                    .voxels(table)
                    .map(|range| Cells::new(v, volume.dims, range)))
            }
            _ => None,
        };
        let path = Path::ALL
            .iter()
            .find(|path| path.is_available(volume.dims))
            .map_or(Path::Scalar, |&path| path);
        Ok(Self {
            skip,
            path,
            tile: TILE,
            dims: volume.dims,
            skipping,
            background,
            cells,
            majorants: None,
        })
    }

    /// Takes what bounds the blocks of its occupancy, by which the distance map leaves out those that lie no higher than
    /// what a ray has seen. Pictures in another mode than that of `majorants` do not read them, nor does another method.
    pub fn set_majorants(&mut self, majorants: Option<Arc<Majorants>>) {
        self.majorants = match &self.skipping {
            Skipping::Distance(map) => majorants.filter(|m| m.dims() == map.dims),
            Skipping::Box | Skipping::Layers(..) => None,
        };
    }

    /// The same plan by other instructions and in tiles of another edge (pixels): for tests and measurements.
    ///
    /// # Errors
    /// [`Error::Setting`] where this machine or volume does not take the path, or the tile is not a multiple of 4.
    pub fn with(mut self, path: Path, tile: u32) -> Result<Self> {
        if !path.is_available(self.dims) {
            return Err(Error::setting(
                "path",
                format!("{} is not to be had here", path.name()),
            ));
        }
        if tile == 0 || !tile.is_multiple_of(4) {
            return Err(Error::setting("tile", "must be a multiple of 4 pixels"));
        }
        (self.path, self.tile) = (path, tile);
        Ok(self)
    }

    /// The method.
    pub fn skip(&self) -> Skip {
        self.skip
    }

    /// The instructions it runs on.
    pub fn path(&self) -> Path {
        self.path
    }

    /// Bytes that the plan holds beyond the volume; grows as the view first turns to another axis.
    pub fn bytes(&self) -> usize {
        let skipping = match &self.skipping {
            Skipping::Box => 0,
            Skipping::Layers(masks, _) => masks.bytes(),
            Skipping::Distance(map) => map.distances().len(),
        };
        skipping + self.cells.as_ref().map_or(0, Cells::bytes)
    }
}

/// Draws a picture. The same bits for every plan, path and number of threads.
///
/// # Errors
/// [`Error::Setting`] where the scene is not the plan's or asks for a sampler that this backend does not have;
/// [`Error::Cancelled`] once `cancel` is set.
pub fn render(scene: &Scene, plan: &CpuPlan, cancel: &AtomicBool) -> Result<Picture> {
    let mut picture = Picture {
        size: scene.frame.size,
        rgba: Vec::new(),
    };
    render_into(scene, plan, cancel, &mut picture)?;
    Ok(picture)
}

/// [`render`] into a picture of any size, whose memory is used again.
///
/// # Errors
/// As [`render`]; the picture is then undefined.
pub fn render_into(
    scene: &Scene,
    plan: &CpuPlan,
    cancel: &AtomicBool,
    picture: &mut Picture,
) -> Result<()> {
    let [width, height] = scene.frame.size.map(|n| n as usize);
    picture.size = scene.frame.size;
    picture.rgba.resize(width * height, [0.0; 4]);
    draw(scene, plan, cancel, &mut picture.rgba)
}

/// Draws a picture, bit-identical to [`render`]'s, and counts the work.
///
/// # Errors
/// As [`render`].
pub fn render_counted(
    scene: &Scene,
    plan: &CpuPlan,
    cancel: &AtomicBool,
) -> Result<CountedPicture> {
    let [width, height] = scene.frame.size.map(|n| n as usize);
    let mut pixels = vec![Counted::EMPTY; width * height];
    draw(scene, plan, cancel, &mut pixels)?;
    let mut counters = Counters::default();
    for tally in pixels.iter().map(|p| p.tally) {
        counters.samples += tally.samples as u64;
        counters.contributing += tally.contributing as u64;
        counters.skip_steps += tally.skip_steps as u64;
    }
    Ok(CountedPicture {
        picture: Picture {
            size: scene.frame.size,
            rgba: pixels.iter().map(|p| p.rgba).collect(),
        },
        counters,
        samples: pixels.iter().map(|p| p.tally.samples as u32).collect(),
        first_hit: pixels.iter().map(|p| p.tally.first_hit).collect(),
    })
}

/// Checks the scene and draws it into `pixels`, row by row.
fn draw<O: Pixel>(
    scene: &Scene,
    plan: &CpuPlan,
    cancel: &AtomicBool,
    pixels: &mut [O],
) -> Result<()> {
    scene.mode.check_backend("cpu")?;
    scene.classification.check_backend("cpu")?;
    if scene.sampler != Sampler::Exact {
        return Err(Error::setting(
            "sampler",
            format!(
                "the CPU backend does not have {}; it has exact",
                scene.sampler.name()
            ),
        ));
    }
    let reads_table = scene.mode == Mode::EmissionAbsorption;
    let shows_more = plan.background.is_some_and(|b| !b.fits(scene.table));
    if scene.volume.dims != plan.dims || (reads_table && shows_more) {
        return Err(Error::setting(
            "plan",
            "was made for another volume or table",
        ));
    }
    with_voxels!(&scene.volume.voxels, voxels => draw_typed(scene, plan, cancel, voxels, pixels))
}

fn draw_typed<V: Voxel, O: Pixel>(
    scene: &Scene,
    plan: &CpuPlan,
    cancel: &AtomicBool,
    voxels: &[V],
    pixels: &mut [O],
) -> Result<()> {
    let domain = scene.table.domain();
    let rows = table::rows(scene.table);
    let parameters = Parameters::new(&scene.mode, domain, scene.frame.step);
    let projection = Projection::of(scene.mode, parameters);
    let job = Job {
        grid: Grid {
            voxels,
            dims: plan.dims,
        },
        frame: scene.frame,
        rows: &rows,
        base: domain.origin,
        scale: domain.scale,
        snap: domain.snap(),
        // Without a background every table coordinate lies outside.
        background: plan
            .background
            .map_or([f64::INFINITY, f64::NEG_INFINITY], |b| b.x()),
        threshold: scene.ert_threshold(),
        projection,
        skip: &plan.skipping,
        // Cells are of what the table shows.
        cells: plan.cells.as_ref().filter(|_| projection.is_none()),
        majorants: plan
            .majorants
            .as_deref()
            .filter(|m| m.hold_for(&scene.mode, domain)),
    };
    let edge = plan.tile as usize;
    let width = scene.frame.size[0] as usize;
    pixels
        .par_chunks_mut(width * edge)
        .enumerate()
        .for_each(|(band, pixels)| {
            let mut rows: Vec<_> = pixels
                .chunks_mut(width)
                .map(|row| row.chunks_mut(edge))
                .collect();
            let mut tile: Vec<&mut [O]> = Vec::with_capacity(edge);
            for x in (0..scene.frame.size[0]).step_by(edge) {
                if cancel.load(Ordering::Relaxed) {
                    return;
                }
                tile.clear();
                tile.extend(rows.iter_mut().filter_map(Iterator::next));
                let area = TileArea {
                    x,
                    y: (band * edge) as u32,
                };
                draw_tile(plan.path, &job, area, &mut tile);
            }
        });
    if cancel.load(Ordering::Relaxed) {
        return Err(Error::Cancelled);
    }
    Ok(())
}

/// Draws a tile by the instructions of `path`, which the plan has checked.
fn draw_tile<V: Voxel, O: Pixel>(
    path: Path,
    job: &Job<'_, V>,
    area: TileArea,
    rows: &mut [&mut [O]],
) {
    match path {
        #[cfg(target_arch = "x86_64")]
        #[allow(unsafe_code)]
        // SAFETY: a plan has this path only where `Path::is_available` found AVX2.
        Path::Avx2 => unsafe { avx2::tile(job, area, rows) },
        #[cfg(not(target_arch = "x86_64"))]
        Path::Avx2 => unreachable!("a plan's path is available"),
        Path::Scalar => tile::draw::<packet::Lanes, V, O>(job, area, rows),
    }
}

#[cfg(test)]
mod tests;
