//! A suite and the cases that it comes to, with the command of each.
#![no_main]
use hollowcast::measure::suite::Suite;

libfuzzer_sys::fuzz_target!(|text: &str| {
    let cases = || Suite::from_toml(text).map(|suite| (suite.groups(), suite));
    if let Some((groups, suite)) = hollowcast_fuzz::answers(text.len(), cases) {
        for group in &groups {
            assert!(!group.weight(&suite).is_nan());
            for case in &group.cases {
                group.words(case, &suite, "volume");
            }
        }
    }
});
