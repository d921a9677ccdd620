//! Tests `argil studio` and `argil study` without their programs.

use std::process::Command;

#[test]
fn a_program_that_is_not_there_says_how_it_is_built() {
    let folder = tempfile::tempdir().expect("a folder");
    let alone = folder
        .path()
        .join(format!("argil{}", std::env::consts::EXE_SUFFIX));
    std::fs::copy(env!("CARGO_BIN_EXE_argil"), &alone).expect("a copy");
    for (command, name) in [("studio", "argil-studio"), ("study", "argil-study")] {
        let out = Command::new(&alone)
            .args([command, "--device", "cpu"])
            .env("PATH", folder.path())
            .output()
            .expect("the command");
        let told = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(3), "{told}");
        let remedy = format!("cargo build --release -p {name}");
        assert!(told.contains(&remedy), "{told}");
    }
}

/// A program next to the command is started with the arguments, and its exit code is returned.
#[cfg(unix)]
#[test]
fn a_program_in_the_same_folder_is_started() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a folder");
    let alone = folder.path().join("argil");
    std::fs::copy(env!("CARGO_BIN_EXE_argil"), &alone).expect("a copy");
    let other = folder.path().join("argil-study");
    std::fs::write(&other, "#!/bin/sh\necho \"given: $*\"\nexit 7\n").expect("a script");
    let mode = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(&other, mode).expect("a program");
    let out = Command::new(&alone)
        .args(["study", "report", "--help", "x"])
        .output()
        .expect("the command");
    assert_eq!(out.status.code(), Some(7));
    let told = String::from_utf8_lossy(&out.stdout);
    assert_eq!(told.trim(), "given: report --help x");
}
