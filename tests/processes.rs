//! Two processes at once on one cache folder: both succeed, draw the same, and leave files that the next one reads.

use std::path::Path;
use std::process::{Child, Command};

fn start(folder: &Path, words: &str, output: &str) -> Child {
    Command::new(env!("CARGO_BIN_EXE_hollowcast"))
        .args(words.split(' '))
        .args(["-o", output])
        .current_dir(folder)
        .env("XDG_CACHE_HOME", folder.join("cache"))
        .env_remove("RUST_LOG")
        .spawn()
        .unwrap()
}

/// Names of the files in the cache.
fn kept(folder: &Path) -> Vec<String> {
    fn visit(folder: &Path, names: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
            if entry.path().is_dir() {
                visit(&entry.path(), names);
            } else {
                names.push(entry.file_name().into_string().unwrap());
            }
        }
    }
    let mut names = Vec::new();
    visit(&folder.join("cache"), &mut names);
    names.sort();
    names
}

/// Runs a command four times at once and once more, with outputs of this extension; what is then in the cache.
fn share(words: &str, extension: &str) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let output = |i: usize| format!("{i}.{extension}");
    let mut running: Vec<Child> = (0..4)
        .map(|i| start(folder.path(), words, &output(i)))
        .collect();
    for child in &mut running {
        assert!(child.wait().unwrap().success());
    }
    let names = kept(folder.path());
    let files = |names: &[String]| {
        names
            .iter()
            .filter(|n| n.contains("part") || n.contains("unfinished"))
            .count()
    };
    assert_eq!(files(&names), 0, "{names:?}");
    assert!(
        start(folder.path(), words, &output(4))
            .wait()
            .unwrap()
            .success()
    );
    assert_eq!(kept(folder.path()), names);
    let read = |i: usize| std::fs::read(folder.path().join(output(i))).unwrap();
    for i in 1..5 {
        assert!(read(i) == read(0), "output {i}");
    }
    names
}

#[test]
fn processes_that_calibrate_at_once_draw_the_same_and_keep_one_calibration() {
    let words = "render phantom:shells:24 --backend cpu --size 24";
    assert_eq!(share(words, "png"), ["calibration.json"]);
}

#[test]
fn processes_that_make_one_truth_at_once_keep_one_file_of_it() {
    let names = share("truth phantom:shells:12 --size 8", "npy");
    assert_eq!(names.len(), 1, "{names:?}");
}
