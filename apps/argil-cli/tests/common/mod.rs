//! Helpers that the tests of the command share.

use std::process::{Command, Output};

pub(crate) fn argil(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_argil"))
        .args(arguments)
        // What is kept for the next time is not the user's.
        .env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"))
        .output()
        .expect("the command starts")
}

pub(crate) fn scene(name: &str) -> String {
    format!("{}/../../scenes/{name}.json", env!("CARGO_MANIFEST_DIR"))
}

pub(crate) fn json(output: &Output) -> serde_json::Value {
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    serde_json::from_slice(&output.stdout).expect("one JSON object and nothing else")
}

#[track_caller]
pub(crate) fn fails(arguments: &[&str], code: i32, message: &str) {
    let output = argil(arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {errors}");
    assert!(errors.contains(message), "{arguments:?}: {errors}");
    assert!(output.stdout.is_empty());
}
