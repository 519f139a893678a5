#![no_main]
libfuzzer_sys::fuzz_target!(|content: &[u8]| hollowcast_fuzz::volume("in.nii", content));
