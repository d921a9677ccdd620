//! `argil render` of images without paths.

use crate::common::scene;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

/// Returns the first line on stderr that announces how long an image takes. It ends the command then.
fn announcement(flags: &[&str]) -> Option<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("x.png").display().to_string();
    let mut process = Command::new(env!("CARGO_BIN_EXE_argil"))
        .args(["render", &scene("temple"), "-o", &path])
        .args(flags)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command starts");
    let mut lines = BufReader::new(process.stderr.take().expect("stderr")).lines();
    let found = lines
        .by_ref()
        .map_while(Result::ok)
        .find(|line| line.contains("pixels takes about"));
    if found.is_some() {
        process.kill().expect("a process");
    }
    let ended = process.wait().expect("an end");
    assert!(found.is_some() || ended.success(), "{flags:?}");
    found
}

/// Nobody waits without knowing for how long, and for what would be sooner.
#[test]
fn long_images_are_announced() {
    assert_eq!(announcement(&["--size", "48x32"]), None);
    let long = ["--size", "640x480", "--samples", "64"];
    let said = announcement(&long).expect("an announcement");
    assert!(said.contains("640x480") && said.contains("--via"), "{said}");
}
