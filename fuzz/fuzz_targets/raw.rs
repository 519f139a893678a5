//! A raw file with its sidecar: what comes before the first zero byte is the sidecar.
#![no_main]

libfuzzer_sys::fuzz_target!(|content: &[u8]| {
    let end = content.iter().position(|&b| b == 0);
    let (sidecar, voxels) = content.split_at(end.unwrap_or(content.len()));
    let kind = if sidecar.first() == Some(&b'{') {
        "json"
    } else {
        "toml"
    };
    let sidecar = hollowcast_fuzz::file(&format!("in.raw.{kind}"), sidecar);
    hollowcast_fuzz::volume("in.raw", voxels.get(1..).unwrap_or_default());
    std::fs::remove_file(sidecar).expect("written just above");
    // And what says by itself what it is, or says nothing.
    hollowcast_fuzz::volume("in.den", content);
});
