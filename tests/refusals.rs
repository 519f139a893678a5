//! Every bad input that was tried, as lists of commands with what they answer: `tests/cmd/*.trycmd`.
//!
//! `TRYCMD=overwrite cargo test --test refusals` writes the answers of today into the lists.

use std::path::{Path, PathBuf};

use trycmd::TestCases;

/// The lists, and the files that their commands find: of `x.trycmd` those in `x.in`.
const CASES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cmd");

/// All files in a folder and the folders in it.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut found: Vec<PathBuf> = entries
        .map(|entry| entry.unwrap().path())
        .flat_map(|path| {
            if path.is_dir() {
                files(&path)
            } else {
                vec![path]
            }
        })
        .collect();
    found.sort();
    found
}

#[test]
fn bad_input_is_refused_in_the_words_of_the_lists() {
    let before = files(Path::new(CASES));
    let cases = TestCases::new();
    cases
        .register_bin("hollowcast", Path::new(env!("CARGO_BIN_EXE_hollowcast")))
        .env("RUST_LOG", "")
        // Without one Mesa's driver, not this program, says so.
        .env("XDG_RUNTIME_DIR", std::env::temp_dir().to_string_lossy())
        .case("tests/cmd/*.trycmd");
    cases.run();
    // Nothing was written on the way to a refusal.
    assert_eq!(files(Path::new(CASES)), before);
}

#[test]
fn every_answer_of_the_lists_is_one_line_and_the_code_of_bad_input() {
    let mut tried = 0;
    for path in files(Path::new(CASES)) {
        if path.extension().is_none_or(|e| e != "trycmd") {
            continue;
        }
        let list = std::fs::read_to_string(&path).unwrap();
        for entry in list.split("\n$ ").skip(1) {
            let lines: Vec<&str> = entry.lines().take_while(|l| !l.is_empty()).collect();
            let [_, "? 2", message] = lines.as_slice() else {
                panic!("{}: {entry}", path.display())
            };
            assert!(message.starts_with("error: "), "{entry}");
            tried += 1;
        }
    }
    assert!(tried > 150, "{tried} commands were tried");
}
