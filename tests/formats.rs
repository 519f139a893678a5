//! Every conformance sample decodes to what the formats' reference readers make of it.
//!
//! The samples lie in the folder that `HOLLOWCAST_FORMATS` names; without it these tests say that they were not run.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use hollowcast::volume::{Scalar, Volume, open, read_stored};
use hollowcast::with_voxels;
use serde_json::Value;
use sha2::{Digest, Sha256};

/// The samples' folder and what is expected of them.
fn samples() -> Option<(PathBuf, serde_json::Map<String, Value>)> {
    let Some(folder) = std::env::var_os("HOLLOWCAST_FORMATS") else {
        // Past the capture of passing tests' output: who reads it must know.
        let _ = writeln!(std::io::stderr(), "not run: HOLLOWCAST_FORMATS is unset");
        return None;
    };
    let folder = PathBuf::from(folder);
    let text = std::fs::read_to_string(folder.join("expected.json")).expect("expected.json");
    let expected = serde_json::from_str(&text.replace("NaN", "null")).expect("valid JSON");
    Some((folder, expected))
}

fn numbers(value: &Value) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(Value::as_f64).collect()
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-5 * b.abs().max(1.0)
}

/// Grid to world, one column per axis, then the first voxel's centre.
fn affine(volume: &Volume) -> [[f64; 3]; 4] {
    let column = |i: usize| (volume.direction.col(i) * volume.spacing[i]).to_array();
    [column(0), column(1), column(2), volume.origin.to_array()]
}

fn check_geometry(name: &str, volume: &Volume, expected: &Value) {
    let [.., origin] = affine(volume);
    if let Some(rows) = expected["affine"].as_array() {
        for (r, row) in rows.iter().take(3).enumerate() {
            for (c, &want) in numbers(row).unwrap().iter().enumerate() {
                assert!(near(affine(volume)[c][r], want), "{name}: affine {r} {c}");
            }
        }
    }
    if let Some(directions) = expected["directions"].as_array() {
        for (i, direction) in directions.iter().enumerate().take(3) {
            let want = numbers(direction).unwrap();
            assert_eq!(affine(volume)[i].to_vec(), want, "{name}: axis {i}");
        }
    }
    for field in ["spacings", "spacing", "zooms"] {
        for (i, want) in numbers(&expected[field])
            .into_iter()
            .flatten()
            .enumerate()
            .take(3)
        {
            assert!(near(volume.spacing[i], want), "{name}: {field} {i}");
        }
    }
    if let Some(want) = numbers(&expected["origin"]) {
        for (have, want) in origin.iter().zip(want) {
            assert!(near(*have, want), "{name}: origin");
        }
    }
    if let Some(want) = numbers(&expected["direction"]) {
        let n = if want.len() == 4 { 2 } else { 3 };
        for (i, want) in want.iter().enumerate() {
            let have = volume.direction.col(i % n)[i / n];
            assert!(near(have, *want), "{name}: direction");
        }
    }
    for (field, have) in [
        ("slope", volume.rescale.slope),
        ("inter", volume.rescale.intercept),
    ] {
        if let Some(want) = expected[field].as_f64() {
            assert_eq!(have, want, "{name}: {field}");
        }
    }
}

#[test]
fn stored_numbers_hash_to_what_the_reference_readers_return() {
    let Some((folder, expected)) = samples() else {
        return;
    };
    for (name, expected) in expected.iter().filter(|(_, e)| e["error"].is_null()) {
        let stored = read_stored(&folder.join(name), None).unwrap_or_else(|e| panic!("{e}"));
        let hash = Sha256::digest(&stored.bytes);
        let hash: Vec<String> = hash.iter().take(16).map(|b| format!("{b:02x}")).collect();
        assert_eq!(hash.concat(), expected["sha256_le"], "{name}");
        assert_eq!(stored.scalar.name(), expected["dtype"], "{name}");
        let shape: Vec<_> = stored
            .shape
            .iter()
            .rev()
            .copied()
            .map(Value::from)
            .collect();
        assert_eq!(
            Value::from(shape),
            expected["shape_slowest_first"],
            "{name}"
        );
    }
}

#[test]
fn volumes_have_the_shape_the_place_and_the_numbers_of_the_first_that_is_stored() {
    let Some((folder, expected)) = samples() else {
        return;
    };
    for (name, expected) in expected.iter().filter(|(_, e)| e["error"].is_null()) {
        let path = folder.join(name);
        let volume = open(&path, None).unwrap_or_else(|e| panic!("{e}"));
        let stored = read_stored(&path, None).unwrap();
        let mut dims = stored.shape.clone();
        dims.resize(dims.len().max(3), 1);
        assert_eq!(volume.dims, dims[..3], "{name}");
        let several = dims[3..].iter().product::<usize>() > 1;
        let converted = volume.voxels.voxel_type().name() != stored.scalar.name();
        // One sample ends in a newline after its voxels.
        let losses = volume
            .warnings
            .iter()
            .filter(|w| !w.contains("1 bytes follow"));
        assert_eq!(
            losses.count(),
            usize::from(several) + usize::from(converted),
            "{name}: {:?}",
            volume.warnings
        );
        if !converted && cfg!(target_endian = "little") {
            assert_eq!(
                volume.voxels.as_bytes(),
                &stored.bytes[..volume.bytes()],
                "{name}"
            );
        }
        if stored.scalar == Scalar::F64 {
            let exact = f64::from_le_bytes(stored.bytes[..8].try_into().unwrap());
            let kept = with_voxels!(&volume.voxels, v => f64::from(v[0]));
            assert_eq!(kept, f64::from(exact as f32), "{name}");
        }
        check_geometry(name, &volume, expected);
    }
}

#[test]
fn files_that_contradict_themselves_are_refused_in_one_line() {
    let Some((folder, expected)) = samples() else {
        return;
    };
    for (name, field) in [
        (
            "nrrd/pynrrd/BallBinary30x30x30_byteskip_minus_five.nhdr",
            "byte skip: ",
        ),
        ("nrrd/pynrrd/BallBinary30x30x30_nifti.nhdr", "data: "),
    ] {
        assert!(expected[name]["error"].is_string());
        for error in [
            open(&folder.join(name), None).unwrap_err(),
            read_stored(&folder.join(name), None).unwrap_err(),
        ] {
            let line = error.to_string();
            assert!(error.is_bad_input() && line.lines().count() == 1, "{line}");
            assert!(
                line.contains("BallBinary30x30x30") && line.contains(field),
                "{line}"
            );
        }
    }
    let refused = expected.values().filter(|e| e["error"].is_string()).count();
    assert_eq!(refused, 2);
}

#[test]
fn volpack_files_are_known_by_their_content() {
    let Some((folder, _)) = samples() else { return };
    let path = folder.join("raw/brainsmall.den");
    let volume = open(&path, None).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(volume.dims, [128, 128, 84]);
    assert_eq!(
        volume.voxels.as_bytes(),
        &std::fs::read(&path).unwrap()[62..]
    );
}

#[test]
fn a_pair_opens_by_either_file() {
    let Some((folder, _)) = samples() else { return };
    let open = |name: &str| open(&folder.join("nifti").join(name), None).unwrap();
    let whole = open("minimal.nii.gz");
    for name in ["minimal.hdr.gz", "minimal.img.gz"] {
        let pair = open(name);
        assert_eq!(pair.voxels.as_bytes(), whole.voxels.as_bytes());
        assert_eq!(affine(&pair), affine(&whole));
    }
}

#[test]
fn raw_data_in_this_machines_order_are_mapped() {
    let Some((folder, _)) = samples() else { return };
    for name in [
        "raw/HeadMRVolume_48x62x42_u8.raw",
        "nrrd/tooth_raw.nrrd",
        "nrrd/pynrrd/BallBinary30x30x30.nhdr",
    ] {
        let volume = open(Path::new(&folder).join(name).as_path(), None).unwrap();
        assert!(format!("{:?}", volume.voxels).contains("Mapped"), "{name}");
    }
}
