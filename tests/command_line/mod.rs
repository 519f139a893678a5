//! The command as a user meets it, run in a folder of the test's own that is also its cache.

// Each test binary takes what it needs.
#![allow(dead_code)]

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

/// The command, not yet started.
pub(crate) fn command(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hollowcast"));
    command
        .args(args)
        .current_dir(folder)
        .env("XDG_CACHE_HOME", folder.join("cache"))
        .env_remove("RUST_LOG")
        .env_remove("HOLLOWCAST_DATA");
    command
}

/// What a run says and how it ends.
pub(crate) fn output(folder: &Path, args: &[&str]) -> Output {
    let output = command(folder, args).output();
    output.expect("the command can be started")
}

/// What a run that succeeds prints.
pub(crate) fn succeeds(folder: &Path, args: &[&str]) -> String {
    let output = output(folder, args);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{args:?}: {errors}");
    String::from_utf8(output.stdout).expect("reports are UTF-8")
}

/// The same as JSON.
pub(crate) fn json(folder: &Path, args: &[&str]) -> Value {
    serde_json::from_str(&succeeds(folder, args)).expect("a JSON document")
}

/// The one line on stderr of a run that blames its input.
pub(crate) fn refused(folder: &Path, args: &[&str]) -> String {
    let output = output(folder, args);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{args:?}: {errors}");
    assert_eq!(errors.lines().count(), 1, "{args:?}: {errors}");
    errors
}
