//! Tuning for a budget, and the truth that it is measured against.

mod command_line;

use std::path::Path;
use std::sync::Arc;

use hollowcast::camera::Orbit;
use hollowcast::measure::budget::{self, Budget};
use hollowcast::measure::truth::Truths;
use hollowcast::measure::tune;
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::sample::Classification;
use hollowcast::transfer::TransferFunction;
use hollowcast::volume::{Statistics, Volume, phantom};

struct Scene {
    settings: Settings,
    renderer: Renderer,
    truths: Truths,
}

fn scene(volume: Volume) -> Scene {
    let volume = Arc::new(volume);
    let transfer = TransferFunction::from_spec("translucent", &Statistics::of(&volume)).unwrap();
    let mut renderer = Renderer::new(BackendChoice::Cpu).unwrap();
    renderer.set_volume(Arc::clone(&volume)).unwrap();
    renderer.set_transfer(transfer.clone());
    Scene {
        truths: Truths::new(&volume, &transfer).unwrap().kept_in(None),
        settings: Settings {
            size: [24, 24],
            ..Settings::new(Orbit::default().camera(volume.extent()))
        },
        renderer,
    }
}

fn plan(scene: &Scene, budget: Budget, error_views: usize) -> budget::Plan {
    budget::Plan {
        budget,
        tuning: tune::Plan {
            blocks: vec![8],
            cuts: false,
            views: vec![scene.settings.camera],
            settings: scene.settings,
            rounds: 1,
        },
        error_views,
        classifications: Classification::ALL.to_vec(),
        thresholds: budget::THRESHOLDS.to_vec(),
        error_size: scene.settings.size,
    }
}

#[test]
fn a_budget_is_kept_or_refused_by_name() {
    let mut scene = scene(phantom::make("pot", [16; 3]).unwrap());
    let mut search = |budget, error_views| {
        let plan = plan(&scene, budget, error_views);
        let renderers = std::slice::from_mut(&mut scene.renderer);
        budget::search(renderers, &mut scene.truths, &plan, &mut |_| ())
    };
    let coarse = search(Budget::MaxError(0.05), 3).unwrap();
    assert!(coarse.error <= 0.05 && coarse.views >= 3);
    let fine = search(Budget::MaxError(0.005), 3).unwrap();
    assert!(fine.error <= 0.005, "{fine:?}");
    assert!(
        fine.accuracy.step_voxels < coarse.accuracy.step_voxels
            || fine.accuracy.ert > coarse.accuracy.ert
    );
    let psnr = search(Budget::Psnr(40.0), 0).unwrap();
    assert!(psnr.error <= 0.01 && psnr.views == 1, "{psnr:?}");
    let timed = search(Budget::BudgetMs(1e6), 0).unwrap();
    assert!(timed.error <= fine.error, "{timed:?}");
    for (budget, named) in [
        (
            Budget::MaxError(1e-7),
            "max-error: nothing stays inside 0.0000001; nearest comes",
        ),
        (
            Budget::Psnr(200.0),
            "psnr: nothing stays inside 200 dB; nearest comes",
        ),
        (
            Budget::BudgetMs(1e-6),
            "budget-ms: nothing is drawn in 0.000001 ms",
        ),
        (
            Budget::MaxError(-1.0),
            "max-error: must be a positive number",
        ),
    ] {
        let error = search(budget, 0).unwrap_err();
        assert!(
            error.is_bad_input() && error.to_string().starts_with(named),
            "{error}"
        );
    }
}

/// The command's exit code and what it printed.
fn hollowcast(folder: &Path, args: &[&str]) -> (i32, String, String) {
    let output = command_line::output(folder, args);
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let code = output.status.code().unwrap();
    (code, text(output.stdout), text(output.stderr))
}

/// With a peak in the table that steps between samples miss, the values between two samples must be looked up together.
#[test]
fn classifications_are_searched_too() {
    let volume = Arc::new(phantom::make("ramp", [24, 8, 8]).unwrap());
    let table = "reference_length_voxels = 1.0\npoints = [\
                 { value = 0, opacity = 0, color = [1, 1, 1] }, { value = 118, opacity = 0, color = [1, 1, 1] },\
                 { value = 120, opacity = 0.9, color = [1, 1, 1] }, { value = 122, opacity = 0, color = [1, 1, 1] }]\n";
    let transfer = TransferFunction::from_toml(table).unwrap();
    let mut renderer = Renderer::new(BackendChoice::Reference).unwrap();
    renderer.set_volume(Arc::clone(&volume)).unwrap();
    renderer.set_transfer(transfer.clone());
    let mut scene = Scene {
        truths: Truths::new(&volume, &transfer).unwrap().kept_in(None),
        settings: Settings {
            size: [12, 12],
            ..Settings::new(Orbit::default().camera(volume.extent()))
        },
        renderer,
    };
    let mut search = |classifications: &[Classification]| {
        let plan = budget::Plan {
            classifications: classifications.to_vec(),
            thresholds: vec![1.0],
            ..plan(&scene, Budget::MaxError(0.05), 0)
        };
        let renderers = std::slice::from_mut(&mut scene.renderer);
        budget::search(renderers, &mut scene.truths, &plan, &mut |_| ())
    };
    let post = search(&[Classification::Post]).unwrap();
    let pre_integrated = search(&[Classification::PreIntegrated]).unwrap();
    let of = |found: &budget::Found| found.accuracy.classification;
    assert_eq!(of(&post), Classification::Post);
    assert_eq!(of(&pre_integrated), Classification::PreIntegrated);
    assert!(pre_integrated.accuracy.step_voxels > post.accuracy.step_voxels);
    assert!(pre_integrated.error <= 0.05, "{pre_integrated:?}");
    let pre = search(&[Classification::Pre]).unwrap_err();
    assert!(pre.to_string().contains("nothing stays inside"), "{pre}");
    // Which of the others is faster is for the clock to say.
    let all = search(Classification::ALL).unwrap();
    assert!(
        of(&all) != Classification::Pre && all.error <= 0.05,
        "{all:?}"
    );
}

#[test]
fn the_command_tells_truths_and_draws_with_profiles_that_keep_a_budget() {
    let folder = tempfile::tempdir().unwrap();
    let run = |args: &str| hollowcast(folder.path(), &args.split(' ').collect::<Vec<_>>());
    let (code, out, err) = run("truth phantom:pot:16 --size 24 -o t.npy --against cpu --json");
    assert_eq!((code, err.lines().count()), (0, 0), "{err}");
    let told: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert!(told["bound"].as_f64().unwrap() <= 1e-4, "{out}");
    assert_eq!(told["masked_share"], 0.0);
    let measured = &told["measured"];
    let error = measured["error"]["max_abs"].as_f64().unwrap();
    assert!(error > 0.0 && error < 0.1, "{out}");
    for field in ["psnr_db", "ssim", "flip"] {
        assert!(measured[field].is_f64(), "{field}: {out}");
    }
    assert!(folder.path().join("t.npy").is_file());
    assert_eq!(
        std::fs::read_dir(folder.path().join("cache/hollowcast/truth"))
            .unwrap()
            .count(),
        1
    );

    let tune = "tune phantom:pot:16 --size 24 --views 1 --repeat 1 --blocks 8 --backends cpu --error-views 2 --error-size 24";
    let (code, out, err) = run(&format!("{tune} --max-error 0.01 -o p.toml --json"));
    assert_eq!(code, 0, "{err}");
    let told: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert!(told["error"].as_f64().unwrap() <= 0.01, "{out}");
    assert!(told["machine"]["cores"].as_u64().unwrap() > 0, "{out}");
    let (code, out, err) =
        run("render phantom:pot:16 --size 24 --profile p.toml -o p.npy --explain --json");
    assert_eq!(code, 0, "{err}");
    let drawn: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(drawn["step_voxels"], told["step_voxels"]);
    assert_eq!(drawn["ert"], told["ert"]);
    assert!(
        drawn["explained"]["step_estimate"]["max_abs"].is_f64(),
        "{out}"
    );
    let (_, out, _) =
        run("render phantom:pot:16 --size 24 --profile p.toml --ert 0.5 --step 1 -o p.npy --json");
    let drawn: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(
        (&drawn["ert"], &drawn["step_voxels"]),
        (&0.5.into(), &1.0.into())
    );
    let (code, out, err) =
        run("render phantom:pot:16 --size 24 --method hull --backend cpu -o p.npy --explain");
    assert_eq!(code, 0, "{err}");
    for words in [
        "method: hull",
        "no channel is off by more than 0.0200 (proven",
        "step of 0.5 voxels: off by about",
    ] {
        assert!(out.contains(words), "{words:?} is not in {out}");
    }

    for (args, named) in [
        (
            format!("{tune} --max-error 1e-9"),
            "max-error: nothing stays inside",
        ),
        (
            format!("{tune} --max-error 0.01 --psnr 40"),
            "cannot be used with",
        ),
        (
            format!("{tune} --budget-ms -3"),
            "budget-ms: must be a positive number",
        ),
        ("truth phantom:pot:16".to_owned(), "output: name a file"),
        (
            "truth phantom:pot:16 -o t.jpg".to_owned(),
            "no picture format of that name",
        ),
    ] {
        let (code, _, err) = run(&args);
        assert!(
            code == 2 && err.contains(named) && err.lines().count() == 1,
            "{args}: {err}"
        );
    }
}
