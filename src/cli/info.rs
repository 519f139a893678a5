//! `hollowcast info`: what is in a volume, and which method suits it.

use std::fmt::Write;

use hollowcast::Result;
use hollowcast::camera::Orbit;
use hollowcast::mode::Mode;
use hollowcast::octree::{Accelerator, Occupancy};
use hollowcast::sample::Sampler;
use hollowcast::skip::{METHODS, Method, Plan, Skip};
use hollowcast::transfer::{Domain, PRESETS, TABLE_SIZES, TransferFunction};
use hollowcast::volume::{Statistics, Volume, empty_share, enclosed_share};
use serde_json::{Value, json};

use super::progress::Progress;
use super::report;
use super::scene_args;
use super::volume_args::VolumeArgs;

const EXAMPLES: &str = "\
Examples:
  hollowcast info scan.nrrd
  hollowcast info scan.nii.gz --tf ramp:300:2000:0.3 --json
  hollowcast info head.raw --dims 256x256x225 --type uint16 --endian big

A voxel is empty where the transfer function gives its value no opacity; a block where it does so over all values that
interpolation can reach in it. Enclosed emptiness cannot be reached from outside through empty voxels: what skips only
the outside has to march through it.";

/// Tells what is in a volume and which method suits it.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    #[command(flatten)]
    volume: VolumeArgs,

    #[arg(long, value_name = "NAME|RAMP|FILE", default_value = PRESETS[0].name, help = scene_args::tf_help())]
    tf: String,

    /// Edge of the blocks that are counted, in voxels: 2, 4, 8, 16, 32 or 64
    #[arg(long, value_name = "N", default_value = "8", value_parser = scene_args::block)]
    block: usize,

    /// Report as JSON on standard output
    #[arg(long)]
    json: bool,
}

/// Shares of emptiness, 0 to 1.
struct Emptiness {
    voxels: f64,
    blocks: f64,
    enclosed: f64,
}

/// Samples that each method takes per pixel, and the method to take.
struct Recommendation {
    samples_per_pixel: Vec<(Skip, f64)>,
    method: Skip,
    reason: String,
}

/// Pictures are this small where only lengths of segments are counted, and taken from these sides.
const PROBE_EDGE: u32 = 64;
const PROBE_VIEWS: [[f64; 2]; 4] = [[30.0, 20.0], [120.0, -20.0], [240.0, 0.0], [300.0, 70.0]];
/// A method has to leave out this share of the samples of a simpler one to be worth its structures.
const WORTH_IT: f64 = 0.1;

pub(super) fn run(args: &Args) -> Result<()> {
    let volume = args.volume.load()?;
    let progress = Progress::spinner("looking at the voxels");
    let statistics = Statistics::of(&volume);
    let transfer = TransferFunction::from_spec(&args.tf, &statistics)?;
    let domain = Domain::new(&volume, statistics.stored_range, TABLE_SIZES[1])?;
    let table = transfer.bake(&domain, 1.0);
    let accelerator = Accelerator::build(&volume, args.block, Sampler::Exact.apron())?;
    let occupancy = accelerator.cull(&table, Mode::EmissionAbsorption);

    let is_empty = |value: f64| transfer.at(value).1 == 0.0;
    let blocks: usize = occupancy.dims.iter().product();
    let emptiness = Emptiness {
        voxels: empty_share(&volume, is_empty),
        blocks: 1.0 - occupancy.count() as f64 / blocks as f64,
        enclosed: enclosed_share(&volume, is_empty),
    };
    let recommendation = recommend(&volume, &occupancy)?;
    drop(progress);

    if args.json {
        super::print_json(&json(
            args,
            &volume,
            &statistics,
            &emptiness,
            &recommendation,
        ))
    } else {
        super::print(&text(
            args,
            &volume,
            &statistics,
            &emptiness,
            &recommendation,
        ))
    }
}

/// Counts what each method would sample, without sampling: rays go through no voxel, only through blocks.
fn recommend(volume: &Volume, occupancy: &Occupancy) -> Result<Recommendation> {
    let size = [PROBE_EDGE; 2];
    let mut samples_per_pixel = Vec::new();
    // Those that box's own marcher draws: among them the number of samples tells which is faster.
    let comparable = |m: &&Method| m.shader == Skip::Box.method().shader;
    for method in METHODS.iter().filter(comparable) {
        let mut samples = 0u64;
        for [azimuth_degrees, elevation_degrees] in PROBE_VIEWS {
            let camera = Orbit {
                azimuth_degrees,
                elevation_degrees,
                ..Orbit::default()
            }
            .camera(volume.extent());
            let frame = camera.ray_frame(volume, size, 1.0)?;
            let plan = Plan::new(method.skip, occupancy, &frame)?;
            let basis = frame.basis::<f64>();
            for pixel in 0..PROBE_EDGE * PROBE_EDGE {
                let pixel = [pixel % PROBE_EDGE, pixel / PROBE_EDGE];
                let ray = basis.ray(f64::from(pixel[0]), f64::from(pixel[1]));
                let mut segments = plan.segments(&ray, pixel, &|_| true);
                let mut k = 0;
                while let Some(segment) = segments.next(k, f64::NAN) {
                    samples += u64::from(segment.end - segment.start);
                    k = segment.end;
                }
            }
        }
        let pixels = f64::from(PROBE_EDGE * PROBE_EDGE) * PROBE_VIEWS.len() as f64;
        samples_per_pixel.push((method.skip, samples as f64 / pixels));
    }
    Ok(choose(samples_per_pixel))
}

/// The first (and so the simplest) of the methods that no later one beats by enough.
fn choose(samples_per_pixel: Vec<(Skip, f64)>) -> Recommendation {
    let (mut method, mut least) = samples_per_pixel[0];
    let most = least;
    for &(skip, samples) in &samples_per_pixel[1..] {
        if samples < least * (1.0 - WORTH_IT) {
            (method, least) = (skip, samples);
        }
    }
    let reason = if method == Skip::Box {
        "there is too little emptiness to leave out".to_owned()
    } else {
        format!(
            "it leaves out {:.0} % of box's samples",
            100.0 * (1.0 - least / most)
        )
    };
    Recommendation {
        samples_per_pixel,
        method,
        reason,
    }
}

fn json(
    args: &Args,
    volume: &Volume,
    statistics: &Statistics,
    emptiness: &Emptiness,
    recommendation: &Recommendation,
) -> Value {
    let samples: serde_json::Map<String, Value> = recommendation
        .samples_per_pixel
        .iter()
        .map(|&(skip, samples)| (skip.method().name.to_owned(), samples.into()))
        .collect();
    let [low, high] = statistics.value_range();
    let mut object = report::volume_json(volume);
    let more = json!({
        "origin": volume.origin.to_array(),
        "direction": volume.direction.to_cols_array_2d(),
        "rescale": { "slope": volume.rescale.slope, "intercept": volume.rescale.intercept },
        "warnings": volume.warnings,
        "range": [low, high],
        "histogram": {
            "first_stored": statistics.first,
            "width_stored": statistics.width,
            "counts": statistics.histogram,
        },
        "transfer_function": args.tf,
        "block": args.block,
        "empty_voxels": emptiness.voxels,
        "empty_blocks": emptiness.blocks,
        "enclosed_empty_voxels": emptiness.enclosed,
        "samples_per_pixel": samples,
        "recommendation": {
            "method": recommendation.method.method().name,
            "reason": recommendation.reason,
        },
    });
    if let (Value::Object(object), Value::Object(more)) = (&mut object, more) {
        object.extend(more);
    }
    object
}

fn text(
    args: &Args,
    volume: &Volume,
    statistics: &Statistics,
    emptiness: &Emptiness,
    recommendation: &Recommendation,
) -> String {
    let [low, high] = statistics.value_range();
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{name:<16}{value}");
    };
    line("volume", report::volume_words(volume));
    line("spacing", format!("{}", volume.spacing));
    line("origin", format!("{}", volume.origin));
    line("size", format!("{} bytes", volume.bytes()));
    line("range", format!("{low} to {high}"));
    line("histogram", bars(&statistics.histogram));
    line(
        "empty",
        format!(
            "{:.2} % of the voxels, {:.2} % of the blocks of {}",
            100.0 * emptiness.voxels,
            100.0 * emptiness.blocks,
            args.block
        ),
    );
    line(
        "enclosed",
        format!("{:.2} % of the voxels", 100.0 * emptiness.enclosed),
    );
    let samples: Vec<String> = recommendation
        .samples_per_pixel
        .iter()
        .map(|(skip, samples)| format!("{} {samples:.1}", skip.method().name))
        .collect();
    line(
        "samples/pixel",
        format!("{}, one voxel apart", samples.join(", ")),
    );
    line(
        "recommendation",
        format!(
            "--method {}: {}",
            recommendation.method.method().name,
            recommendation.reason
        ),
    );
    text
}

/// The histogram as a row of bars, logarithmic: backgrounds would leave nothing to see of the rest.
fn bars(histogram: &[u64]) -> String {
    const BARS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    const COLUMNS: usize = 64;
    let columns: Vec<f64> = histogram
        .chunks(histogram.len().div_ceil(COLUMNS))
        .map(|bins| (bins.iter().sum::<u64>() as f64).ln_1p())
        .collect();
    let most = columns.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    columns
        .iter()
        .map(|c| BARS[(c / most * 8.0).ceil() as usize])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_simplest_method_that_is_as_good_is_recommended() {
        let of = |samples: [f64; 3]| {
            choose(
                [Skip::Box, Skip::Hull, Skip::HalfSplit]
                    .into_iter()
                    .zip(samples)
                    .collect(),
            )
            .method
        };
        assert_eq!(of([100.0, 95.0, 92.0]), Skip::Box);
        assert_eq!(of([100.0, 50.0, 46.0]), Skip::Hull);
        assert_eq!(of([100.0, 50.0, 40.0]), Skip::HalfSplit);
        assert_eq!(of([0.0, 0.0, 0.0]), Skip::Box);
    }

    #[test]
    fn a_bar_stands_for_any_voxel_at_all() {
        let mut histogram = vec![0; 256];
        histogram[0] = 1_000_000;
        histogram[255] = 1;
        let bars: Vec<char> = bars(&histogram).chars().collect();
        assert_eq!((bars[0], bars[1], bars[63]), ('█', ' ', '▁'));
    }
}
