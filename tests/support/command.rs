//! The command as tests run it, and what it leaves.

// Each test binary takes what it needs.
#![allow(dead_code)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

/// Runs the command.
pub(crate) fn hollowcast(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hollowcast"))
        .args(args)
        .env_remove("RUST_LOG")
        .output()
        .expect("the command can be started")
}

pub(crate) fn succeeds(args: &[&str]) -> String {
    let output = hollowcast(args);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{args:?}: {errors}");
    String::from_utf8(output.stdout).expect("reports are UTF-8")
}

pub(crate) fn json(args: &[&str]) -> Value {
    serde_json::from_str(&succeeds(args)).expect("a JSON document")
}

/// The exit code and the one line that a failing run leaves on stderr.
pub(crate) fn fails(args: &[&str]) -> (i32, String) {
    let output = hollowcast(args);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(errors.lines().count(), 1, "{args:?}: {errors}");
    assert!(output.stdout.is_empty(), "{args:?}");
    (output.status.code().expect("it was not killed"), errors)
}

pub(crate) fn path(folder: &Path, name: &str) -> String {
    folder.join(name).to_str().expect("UTF-8").to_owned()
}

/// Shape and numbers of an array file of f32.
pub(crate) fn read_npy(path: &str) -> (String, Vec<f32>) {
    let bytes = fs::read(path).unwrap();
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = String::from_utf8(bytes[10..start].to_vec()).unwrap();
    let numbers = bytes[start..]
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    (header, numbers)
}
