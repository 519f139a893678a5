use super::*;
use crate::camera::Orbit;
use crate::mode::MODES;
use crate::transfer::ControlPoint;
use crate::volume::{Statistics, Voxels, phantom};

fn ramp(low: f64, high: f64) -> TransferFunction {
    let point = |value, opacity| ControlPoint {
        value,
        opacity,
        color: [1.0, 0.5, 0.25],
    };
    TransferFunction::new(vec![point(low, 0.0), point(high, 0.3)], 1.0).unwrap()
}

fn settings(volume: &Volume, size: u32) -> Settings {
    Settings {
        size: [size; 2],
        ..Settings::new(Orbit::default().camera(volume.extent()))
    }
}

fn pot() -> (Arc<Volume>, Settings) {
    let volume = Arc::new(phantom::make("pot", [24; 3]).unwrap());
    let settings = settings(&volume, 20);
    (volume, settings)
}

/// A box of one value is the exponential law of every ray's length, to which the truth must come whatever the step.
#[test]
fn a_full_box_is_the_closed_form() {
    let volume = Arc::new(phantom::make("full", [8; 3]).unwrap());
    let [_, high] = Statistics::of(&volume).value_range();
    let mut settings = settings(&volume, 16);
    let point = ControlPoint {
        value: high,
        opacity: 0.2,
        color: [1.0; 3],
    };
    let transfer = TransferFunction::new(vec![point], 1.0).unwrap();
    let mut truths = Truths::new(&volume, &transfer).unwrap().kept_in(None);
    let truth = truths.of(&settings, |_| ()).unwrap();
    settings.step_voxels = 1.0;
    let frame = settings
        .camera
        .ray_frame(&volume, settings.size, 1e-5)
        .unwrap();
    for (i, pixel) in truth.picture.rgba.iter().enumerate() {
        let ray = frame.basis::<f64>().ray((i % 16) as f64, (i / 16) as f64);
        let length = ray.k_end * 1e-5;
        let opacity = 1.0 - 0.8_f64.powf(length);
        for c in pixel {
            assert!(
                (f64::from(*c) - opacity).abs() < 3.0 * BOUND,
                "{i}: {c} for {opacity}"
            );
        }
    }
    // Opacity of a voxel over 1,024 steps: what one sample more or less is.
    assert!(truth.bound < 0.23 / 1024.0, "{}", truth.bound);
    assert_eq!(truth.masked_share(), 0.0);
}

#[test]
fn a_truth_does_not_hang_on_what_it_does_not_read_and_is_kept() {
    let (volume, settings) = pot();
    let transfer = ramp(40.0, 255.0);
    let folder = tempfile::tempdir().unwrap();
    let make = |settings: &Settings| {
        let mut truths = Truths::new(&volume, &transfer)
            .unwrap()
            .kept_in(Some(folder.path()));
        let mut told = Vec::new();
        let truth = truths.of(settings, |done| told.push(done)).unwrap();
        assert!(told.iter().all(|d| (0.0..=1.0).contains(d)) && told.is_sorted());
        (truth, told.len())
    };
    let (first, work) = make(&settings);
    assert!(work > 0 && first.bound <= BOUND && first.step_voxels <= COARSEST_STEP / 4.0);
    let other = Settings {
        step_voxels: 2.0,
        ert: 0.5,
        block: 16,
        skip: Skip::Hull,
        sampler: Some(Sampler::Nearest),
        ..settings
    };
    assert_eq!(make(&other), (first.clone(), 0));
    // A file that was damaged is computed anew, and another size is another truth.
    let path = std::fs::read_dir(folder.path())
        .unwrap()
        .next()
        .unwrap()
        .unwrap()
        .path();
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[100] ^= 1;
    std::fs::write(&path, &bytes).unwrap();
    assert_eq!(make(&settings), (first.clone(), work));
    std::fs::write(&path, b"").unwrap();
    assert_eq!(make(&settings), (first.clone(), work));
    let larger = Settings {
        size: [21, 20],
        ..settings
    };
    assert_eq!(make(&larger).0.picture.size, [21, 20]);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn errors_of_coarser_steps_fall_towards_the_truth() {
    let (volume, settings) = pot();
    let transfer = ramp(40.0, 255.0);
    let mut truths = Truths::new(&volume, &transfer).unwrap().kept_in(None);
    let truth = truths.of(&settings, |_| ()).unwrap();
    let mut renderer = Renderer::new(BackendChoice::Reference).unwrap();
    renderer.set_volume(Arc::clone(&volume)).unwrap();
    renderer.set_transfer(transfer);
    let error = |renderer: &mut Renderer, step_voxels: f64| {
        let settings = Settings {
            step_voxels,
            ert: 1.0,
            ..settings
        };
        let picture = renderer.render(&settings).unwrap().picture;
        crate::measure::metrics::metrics([(&picture, &truth)]).rms
    };
    let errors = [1.0, 0.5, 0.25, 0.125].map(|step| error(&mut renderer, step));
    assert!(errors.windows(2).all(|e| e[1] < 0.5 * e[0]), "{errors:?}");
    assert!(errors[3] < 1e-3, "{errors:?}");
}

#[test]
fn every_mode_has_a_truth_and_masks_little() {
    let (volume, settings) = pot();
    let statistics = Statistics::of(&volume);
    let mut truths = Truths::new(&volume, &ramp(40.0, 255.0))
        .unwrap()
        .kept_in(None);
    for row in MODES {
        let mode = (row.suited_to)(&statistics);
        let truth = truths.of(&Settings { mode, ..settings }, |_| ()).unwrap();
        let share = truth.masked_share();
        let first_surface = matches!(row.name, "normals" | "phong" | "two-surfaces");
        // Silhouettes of a small picture are a good part of it.
        assert!(
            share <= if first_surface { 0.3 } else { 0.0 },
            "{}: {share}",
            row.name
        );
        assert!(!first_surface || share > 0.0, "{}", row.name);
        assert!(truth.bound <= 0.004, "{}: {}", row.name, truth.bound);
    }
}

/// A wall of voxels between 0 and 255 without any between: a peak of the transfer function is passed within a hundredth
/// of a voxel, which the first pictures all miss.
#[test]
fn a_peak_that_coarse_steps_miss_is_found() {
    let stored: Vec<u8> = (0..512usize)
        .map(|i| if i % 8 < 4 { 0 } else { 255 })
        .collect();
    let volume = Arc::new(Volume {
        voxels: Voxels::U8(stored.into()),
        ..phantom::make("full", [8; 3]).unwrap()
    });
    let point = |value, opacity| ControlPoint {
        value,
        opacity,
        color: [1.0; 3],
    };
    let peak = vec![point(126.0, 0.0), point(127.0, 0.99), point(128.0, 0.0)];
    let transfer = TransferFunction::new(peak, 1.0).unwrap();
    let mut truths = Truths::new(&volume, &transfer).unwrap().kept_in(None);
    let settings = Settings {
        table_entries: 4096,
        ..settings(&volume, 12)
    };
    let truth = truths.of(&settings, |_| ()).unwrap();
    assert!(truth.step_voxels < COARSEST_STEP / 4.0);
    let fine = Settings {
        step_voxels: 1.0 / 2048.0,
        ert: 1.0,
        ..settings
    };
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    reference.set_volume(Arc::clone(&volume)).unwrap();
    reference.set_transfer(transfer);
    let fine = reference.render(&fine).unwrap().picture;
    assert!(truth.masked_share() < 0.1, "{}", truth.masked_share());
    for (i, (a, b)) in truth.picture.rgba.iter().zip(&fine.rgba).enumerate() {
        let difference = (a[3] - b[3]).abs();
        assert!(truth.masked[i] || difference < 2e-3, "{i}: {a:?} {b:?}");
    }
}
