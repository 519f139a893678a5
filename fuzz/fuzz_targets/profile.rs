#![no_main]
use hollowcast::measure::profile::Profile;

libfuzzer_sys::fuzz_target!(|text: &str| {
    if let Some(profile) = hollowcast_fuzz::answers(text.len(), || Profile::from_toml(text)) {
        let again = Profile::from_toml(&profile.to_toml("written again"));
        assert_eq!(again.expect("what was written is read"), profile);
    }
});
