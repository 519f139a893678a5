//! Suites and their reports, as a user meets them.

mod command_line;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use command_line::{command, json, refused, succeeds};
use serde_json::Value;

/// A scene with a thin wall, so that lossy methods lose something; its title wants to be escaped.
const SUITE: &str = r#"
name = "small"
repeat = 1

[[scene]]
name = "thin"
title = "Thin <script>alert('x')</script> & \"co\""
volume = "phantom:thin:20"
tf = "ramp:40:255:0.3"
camera = "az=30,el=20,dist=2"

[[sweep]]
scenes = ["thin"]
backends = ["cpu", "reference"]
methods = ["box", "hull", "half-split", "k-cuts", "beam-masks", "distance-map", "grid-dda", "segment-list", "beam-cells", "octree-encoded", "two-step", "adaptive"]
blocks = [4]
steps = ["0.5", "1"]
sizes = ["16"]
ert = ["off"]
truth = 12

[[sweep]]
scenes = ["thin"]
backends = ["cpu"]
methods = ["hull"]
blocks = [2, 4, 8]
steps = ["1"]
sizes = ["16", "24x16"]

[[picture]]
scene = "thin"
backend = "reference"
methods = ["box", "two-step"]
block = 4
step = "1"
size = 12
"#;

const BENCH: [&str; 4] = ["bench", "s.toml", "-o", "r.jsonl"];

/// A folder with the suite and its results.
fn measured() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.toml"), SUITE).unwrap();
    succeeds(folder.path(), &BENCH);
    folder
}

fn records(folder: &Path, kind: &str) -> Vec<Value> {
    let text = fs::read_to_string(folder.join("r.jsonl")).unwrap();
    let all = text
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap());
    all.filter(|r| r["kind"] == kind).collect()
}

#[test]
fn lossless_methods_lie_on_one_line_and_a_stopped_run_goes_on() {
    let folder = measured();
    let folder = folder.path();
    errors_are_equal_bit_for_bit(&records(folder, "case"));
    commands_measure_the_same(folder, &records(folder, "case"));
    stopped_runs_go_on(folder);
    killed_runs_go_on(folder, &records(folder, "case"));
    others_are_refused(folder);
    the_page_holds_all_and_is_escaped(folder);
}

/// By backend and step; that lossy ones differ shows that the measure tells.
fn errors_are_equal_bit_for_bit(cases: &[Value]) {
    let mut lines: BTreeMap<String, Vec<u64>> = BTreeMap::new();
    let mut lossy = 0;
    let measured = || cases.iter().filter(|c| !c["error"].is_null());
    let key = |c: &Value| format!("{} {}", c["backend"], c["step"]);
    let rms = |c: &Value| c["error"]["rms"].as_f64().unwrap().to_bits();
    for case in measured().filter(|c| c["lossless"] == true) {
        assert_eq!(case["differing_pixels_vs_box"], 0, "{case}");
        lines.entry(key(case)).or_default().push(rms(case));
    }
    assert_eq!(lines.len(), 4);
    for (key, errors) in &lines {
        assert!(errors.len() >= 5, "{key}");
        assert!(errors.iter().all(|e| *e == errors[0]), "{key}: {errors:?}");
        assert!(f64::from_bits(errors[0]) > 0.0, "{key}");
    }
    for case in measured().filter(|c| c["lossless"] == false) {
        lossy += usize::from(rms(case) != lines[&key(case)][0]);
    }
    assert!(lossy >= 2, "lossy methods that differ: {lossy}");
}

/// What a case's command counts and how far off it is are what the case says.
fn commands_measure_the_same(folder: &Path, cases: &[Value]) {
    let with_error = |method| {
        let is_it = move |c: &&Value| c["method"] == method && !c["error"].is_null();
        cases.iter().find(is_it).unwrap()
    };
    let without = cases.iter().find(|c| c["error"].is_null()).unwrap();
    for case in [without, with_error("hull"), with_error("two-step")] {
        let command = case["command"].as_str().unwrap();
        let words: Vec<&str> = command.split(' ').skip(1).chain(["--json"]).collect();
        let json = json(folder, &words);
        let rows = json["rows"].as_array().unwrap();
        let row = rows.iter().find(|r| r["method"] == case["method"]).unwrap();
        for (of_row, of_case) in [
            ("samples_per_pixel", &case["samples"]),
            ("structure_bytes", &case["structure_bytes"]),
            ("max_abs_diff_vs_reference", &case["error"]["max_abs"]),
            ("mean_abs_diff_vs_reference", &case["error"]["mean_abs"]),
            ("off_share_vs_reference", &case["error"]["off_share"]),
            ("ssim_vs_reference", &case["error"]["ssim"]),
            ("flip_vs_reference", &case["error"]["flip"]),
        ] {
            assert_eq!(&row[of_row], of_case, "{command}");
        }
        if let Some(rms) = case["error"]["rms"].as_f64() {
            let psnr = row["psnr_vs_reference_db"].as_f64().unwrap();
            assert!((psnr + 20.0 * rms.log10()).abs() < 1e-9, "{command}");
        }
    }
}

/// A run that is killed outright, whatever it was writing, goes on where it was.
fn killed_runs_go_on(folder: &Path, cases: &[Value]) {
    let bench = ["bench", "s.toml", "-o", "k.jsonl"];
    let mut run = command(folder, &bench)
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let lines = || fs::read_to_string(folder.join("k.jsonl")).map_or(0, |t| t.lines().count());
    let start = Instant::now();
    while lines() < 4 && start.elapsed() < Duration::from_mins(1) {
        std::thread::sleep(Duration::from_millis(1));
    }
    run.kill().unwrap();
    run.wait().unwrap();
    let before = lines();
    assert!(before >= 4);
    let told = succeeds(folder, &bench);
    let all = cases.len();
    assert!(told.contains(&format!("{all} cases")), "{told}");
    let text = fs::read_to_string(folder.join("k.jsonl")).unwrap();
    let whole = fs::read_to_string(folder.join("r.jsonl")).unwrap();
    assert_eq!(text.lines().count(), whole.lines().count());
    assert!(
        !told.contains(&format!(" {all} of them")) || before < 5,
        "{told}"
    );
}

fn stopped_runs_go_on(folder: &Path) {
    let path = folder.join("r.jsonl");
    let whole = fs::read_to_string(&path).unwrap();
    assert!(succeeds(folder, &BENCH).contains(" 0 of them measured now"));
    assert_eq!(fs::read_to_string(&path).unwrap(), whole);

    let commands = |folder: &Path| -> Vec<String> {
        let cases = records(folder, "case");
        let mut all: Vec<String> = cases.iter().map(|c| c["command"].to_string()).collect();
        all.sort();
        all
    };
    let before = commands(folder);
    // Stopped in the middle of a line, a third of the way.
    let cut = whole.char_indices().nth(whole.len() / 3).unwrap().0;
    fs::write(&path, &whole[..cut]).unwrap();
    let told = succeeds(folder, &BENCH);
    assert!(
        !told.contains(" 0 of them") && !told.contains(&format!(" {} of them", before.len())),
        "{told}"
    );
    assert_eq!(commands(folder), before);
    assert_eq!(records(folder, "scene").len(), 1);
    assert_eq!(records(folder, "pictures").len(), 1);
}

fn others_are_refused(folder: &Path) {
    let before = fs::read_to_string(folder.join("r.jsonl")).unwrap();
    fs::write(
        folder.join("t.toml"),
        SUITE.replace("repeat = 1", "repeat = 2"),
    )
    .unwrap();
    let error = refused(folder, &["bench", "t.toml", "-o", "r.jsonl"]);
    assert!(error.contains("suite"), "{error}");
    fs::write(folder.join("notes.txt"), "mine").unwrap();
    let error = refused(folder, &["bench", "s.toml", "-o", "notes.txt"]);
    assert!(error.contains("notes.txt"), "{error}");
    assert_eq!(
        fs::read_to_string(folder.join("notes.txt")).unwrap(),
        "mine"
    );
    let error = refused(folder, &["report", "r.jsonl", "-o", "r.jsonl"]);
    assert!(error.contains("would be lost"), "{error}");
    let error = refused(folder, &["report", "r.jsonl", "--tables", "r.jsonl"]);
    assert!(error.contains("tables: is one of"), "{error}");
    let error = refused(folder, &["report", "notes.txt", "-o", "n.html"]);
    assert!(error.contains("notes.txt"), "{error}");
    assert_eq!(fs::read_to_string(folder.join("r.jsonl")).unwrap(), before);
    for (from, to, named) in [
        ("ramp:40:255:0.3", "ramp:40", "ramp"),
        ("\"0.5\"", "\"0\"", "step"),
        ("[2, 4, 8]", "[2, 5]", "32"),
        ("[\"16\"]", "[\"0\"]", "size"),
        ("phantom:thin:20", "none.nrrd", "none.nrrd"),
        ("phantom:thin:20", "phantom:cube:20", "menger"),
        ("az=30", "tilt=3", "tilt"),
        ("\"off\"", "\"2\"", "ert"),
    ] {
        fs::write(folder.join("bad.toml"), SUITE.replace(from, to)).unwrap();
        let error = refused(folder, &["bench", "bad.toml", "-o", "bad.jsonl"]);
        assert!(error.contains(named), "{named} is not in {error}");
    }
}

fn the_page_holds_all_and_is_escaped(folder: &Path) {
    let hazards = "noise,eye-far,wall-of-a-voxel";
    let methods = "hull,f32-from-eye";
    let atlas = [
        "stability",
        "--backends",
        "cpu",
        "--hazard",
        hazards,
        "--method",
        methods,
    ];
    succeeds(folder, &[&atlas[..], &["-o", "hazards"]].concat());
    let report = ["report", "r.jsonl", "-o", "r.html", "--charts", "charts"];
    let told = succeeds(
        folder,
        &[
            &report[..],
            &["--tables", "t.md", "--stability", "hazards/rows.json"],
        ]
        .concat(),
    );
    let tables = fs::read_to_string(folder.join("t.md")).unwrap();
    assert!(
        tables.contains("| hull | ") && !tables.contains("<script"),
        "{tables}"
    );
    let page = fs::read_to_string(folder.join("r.html")).unwrap();
    assert!(!page.contains("<script>alert") && page.contains("Thin &lt;script&gt;alert"));
    for asks_a_network in ["http:", "https:", "//cdn", "@import", "url("] {
        assert!(!page.contains(asks_a_network), "{asks_a_network}");
    }
    for holds in [
        "Pareto front",
        "data:image/png;base64,",
        "id=\"pareto-thin\"",
        "id=\"by-block-blocks-thin",
        "id=\"by-block-edit-thin",
        "id=\"work-thin\"",
        "id=\"methods-speed-reference",
        "on each all are equal to the last digit",
        "hollowcast compare phantom:thin:20",
        "<td>eye-far</td><td class=\"ok\">ok</td>",
        "<td class=\"wrong\">wrong 0.0",
    ] {
        assert!(page.contains(holds), "{holds}");
    }
    for file in told.lines().skip(1) {
        assert!(
            fs::metadata(folder.join(file)).unwrap().len() > 100,
            "{file}"
        );
    }
    assert!(
        folder.join("charts/pareto-thin.svg").is_file()
            && folder.join("charts/pareto-thin.png").is_file()
    );
    browser::shows_in_silence(folder, "r.html");
}

/// The page in headless Chromium, where that is installed (scripts/test.sh installs it).
mod browser {
    use std::fs;
    use std::io::Read as _;
    use std::net::TcpListener;
    use std::path::Path;
    use std::process::Command;
    use std::sync::{Arc, Mutex};
    use std::time::Duration;

    /// A page that does what reports must not.
    const LOUD: &str = "<!doctype html><title>x</title><img src='http://example.invalid/a.png'>\
                        <script>console.error('loud')</script>";

    /// What Chromium said and asked for.
    struct Seen {
        console: Vec<String>,
        requests: Vec<String>,
        document: String,
    }

    pub(crate) fn shows_in_silence(folder: &Path, page: &str) {
        let Some(program) = ["chromium", "chromium-browser"]
            .into_iter()
            .find(|p| is_here(p))
        else {
            eprintln!("not run: the report in a browser, for no chromium is installed");
            return;
        };
        fs::write(folder.join("loud.html"), LOUD).unwrap();
        let loud = open(program, folder, "loud.html");
        assert_eq!(loud.console.len(), 1, "{:?}", loud.console);
        assert!(
            loud.requests.iter().any(|r| r.contains("example.invalid")),
            "{:?}",
            loud.requests
        );
        let seen = open(program, folder, page);
        assert_eq!(seen.console, Vec::<String>::new());
        assert_eq!(seen.requests, Vec::<String>::new());
        assert!(seen.document.contains("<h1>Speed against accuracy"));
    }

    fn is_here(program: &str) -> bool {
        let found = Command::new(program).arg("--version").output();
        found.is_ok_and(|output| output.status.success())
    }

    /// Opens a page with all requests going to a proxy that notes and answers none.
    fn open(program: &str, folder: &Path, page: &str) -> Seen {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let proxy = format!("--proxy-server=http://{}", listener.local_addr().unwrap());
        let requests = Arc::new(Mutex::new(Vec::new()));
        let noted = Arc::clone(&requests);
        // Ends with the process of the tests.
        std::thread::spawn(move || {
            for stream in listener.incoming() {
                let Ok(mut stream) = stream else { continue };
                let _ = stream.set_read_timeout(Some(Duration::from_secs(5)));
                let mut head = [0; 400];
                let length = stream.read(&mut head).unwrap_or(0);
                let head = String::from_utf8_lossy(&head[..length]).into_owned();
                noted
                    .lock()
                    .unwrap()
                    .push(head.lines().next().unwrap_or_default().to_owned());
            }
        });
        let output = Command::new(program)
            .args([
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--disable-dev-shm-usage",
                "--no-first-run",
            ])
            .args([
                "--disable-background-networking",
                "--disable-component-update",
                "--disable-sync",
            ])
            .args(["--enable-logging=stderr", "--dump-dom", &proxy])
            .arg(format!(
                "--user-data-dir={}",
                folder.join("profile").display()
            ))
            .arg(format!("file://{}", folder.join(page).display()))
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&output.stderr);
        let console = told.lines().filter(|line| line.contains(":CONSOLE"));
        // Of the browser itself, whatever it shows.
        let is_own =
            |request: &str| request.contains(".google.com") || request.contains(".googleapis.com");
        let requests = requests.lock().unwrap().clone();
        Seen {
            console: console.map(str::to_owned).collect(),
            requests: requests
                .into_iter()
                .filter(|r: &String| !is_own(r))
                .collect(),
            document: String::from_utf8_lossy(&output.stdout).into_owned(),
        }
    }
}
