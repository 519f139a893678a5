//! Damaged transfer functions, profiles, suites and results: one line that says what is wrong, or what can be used; never a
//! panic.

use hollowcast::Error;
use hollowcast::measure::profile::Profile;
use hollowcast::measure::suite::{Results, Suite};
use hollowcast::transfer::{Domain, TABLE_SIZES, TransferFunction};
use hollowcast::volume::phantom;
use proptest::prelude::*;

const TABLE: &str = "reference_length_voxels = 1.0\npoints = [\n    { value = 40.0, opacity = 0.0, color = [0.9, 0.6, 0.4] },\n    \
                     { value = 255.0, opacity = 0.3, color = [1.0, 0.9, 0.8] },\n]\n";
const PROFILE: &str =
    "backend = \"cpu\"\nmethod = \"half-split\"\nblock = 8\ncut = \"best\"\ncuts = \"auto\"\n";

const SUITE: &str = include_str!("../fuzz/seeds/suite/small.toml");
const RESULTS: &str = include_str!("../fuzz/seeds/results/small.jsonl");

/// What stands in files that nobody wrote by hand.
const ODD: &[&str] = &[
    "nan",
    "inf",
    "-inf",
    "1e400",
    "-1e308",
    "1e-320",
    "-0.0",
    "9223372036854775807",
    "[",
    "]",
    "{",
    "\"",
    "\n",
    "=",
    "\u{0}",
    "\u{202e}",
    "points",
    "true",
    "1979-05-27",
    "block = 64",
    "''' ",
    "#",
];

/// Replaces a range of the text by something odd.
fn damaged(text: &str, at: prop::sample::Index, len: usize, odd: &str) -> String {
    let from = at.index(text.len());
    let to = (from + len).min(text.len());
    format!("{}{odd}{}", &text[..from], &text[to..])
}

/// A refusal names the input's fault, in one line.
fn check_refusal(error: &Error) -> Result<(), TestCaseError> {
    prop_assert!(error.is_bad_input());
    prop_assert_eq!(error.to_string().lines().count(), 1);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_damaged_transfer_function_is_refused_in_one_line_or_bakes_to_numbers(
        at in any::<prop::sample::Index>(),
        len in 0_usize..12,
        odd in prop::sample::select(ODD),
        step in prop::sample::select(vec![1e-3, 0.5, 1000.0]),
    ) {
        match TransferFunction::from_toml(&damaged(TABLE, at, len, odd)) {
            Err(error) => check_refusal(&error)?,
            Ok(function) => {
                let volume = phantom::make("full", [1; 3]).unwrap();
                let domain = Domain::new(&volume, [0.0, 255.0], TABLE_SIZES[0]).unwrap();
                for entry in function.bake(&domain, step).rgba() {
                    prop_assert!(entry.iter().all(|c| (0.0..=1.0).contains(c)), "{:?}", entry);
                }
                // What is read can be written, and reads back the same.
                prop_assert_eq!(TransferFunction::from_toml(&function.to_toml()).unwrap(), function);
            }
        }
    }

    #[test]
    fn a_damaged_profile_is_refused_in_one_line_or_is_one(
        at in any::<prop::sample::Index>(),
        len in 0_usize..12,
        odd in prop::sample::select(ODD),
    ) {
        match Profile::from_toml(&damaged(PROFILE, at, len, odd)) {
            Err(error) => check_refusal(&error)?,
            Ok(profile) => prop_assert_eq!(Profile::from_toml(&profile.to_toml("")).unwrap(), profile),
        }
    }

    #[test]
    fn a_damaged_suite_is_refused_in_one_line_or_comes_to_cases(
        at in any::<prop::sample::Index>(),
        len in 0_usize..12,
        odd in prop::sample::select(ODD),
    ) {
        match Suite::from_toml(&damaged(SUITE, at, len, odd)) {
            Err(error) => check_refusal(&error)?,
            Ok(suite) => {
                for group in suite.groups() {
                    prop_assert!(!group.weight(&suite).is_nan());
                    for case in &group.cases {
                        prop_assert!(!group.words(case, &suite, "volume").is_empty());
                    }
                }
            }
        }
    }
}

proptest! {
    // Each writes a file.
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_results_are_refused_in_one_line_or_make_a_page(
        at in any::<prop::sample::Index>(),
        len in 0_usize..12,
        odd in prop::sample::select(ODD),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.jsonl");
        std::fs::write(&path, damaged(RESULTS, at, len, odd)).unwrap();
        match Results::read(&path) {
            Err(error) => check_refusal(&error)?,
            Ok(results) => {
                let page = folder.path().join("page.html");
                hollowcast::report::write(&[results], None, &page).unwrap();
            }
        }
    }
}
