//! Facts that several subcommands report: as JSON objects and as lines.

use hollowcast::render::{BackendChoice, BackendInfo};
use hollowcast::volume::Volume;
use serde_json::{Value, json};

/// What the pictures were made on.
pub(super) fn adapter_json(info: &BackendInfo) -> Value {
    json!({
        "backend": info.backend,
        "name": info.adapter,
        "driver": info.driver,
        "is_software": info.is_software,
    })
}

/// The same in words: `gpu (llvmpipe, Mesa 22.3.6)`.
pub(super) fn adapter_words(info: &BackendInfo) -> String {
    let named: Vec<&str> = [info.adapter.as_str(), info.driver.as_str()]
        .into_iter()
        .filter(|s| !s.is_empty())
        .collect();
    format!("{} ({})", info.backend, named.join(", "))
}

/// Tells on stderr where nobody asked for the slow way and it was taken.
pub(super) fn notice_fallback(choice: BackendChoice, info: &BackendInfo) {
    if choice == BackendChoice::Auto && info.backend == "cpu" {
        eprintln!("notice: no hardware graphics adapter found; drawing on the CPU");
    }
}

/// A setting as it was written: 0.98, not the f64 nearest to the f32 nearest to it.
pub(super) fn decimal(setting: f32) -> f64 {
    setting
        .to_string()
        .parse()
        .expect("a number prints as a number")
}

/// What was drawn.
pub(super) fn volume_json(volume: &Volume) -> Value {
    json!({
        "name": volume.name,
        "dims": volume.dims,
        "type": volume.voxels.voxel_type().name(),
        "spacing": volume.spacing.to_array(),
        "bytes": volume.bytes(),
    })
}

/// The same in words: `pot (256 x 256 x 178, uint8)`.
pub(super) fn volume_words(volume: &Volume) -> String {
    let [x, y, z] = volume.dims;
    format!(
        "{} ({x} x {y} x {z}, {})",
        volume.name,
        volume.voxels.voxel_type().name()
    )
}
