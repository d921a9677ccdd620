//! Tests the editor without a screen.

use std::process::Command;

#[cfg(target_os = "linux")]
#[test]
fn without_a_screen_it_says_so() {
    let out = Command::new(env!("CARGO_BIN_EXE_argil-studio"))
        .args(["--device", "cpu"])
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .expect("the program");
    let told = String::from_utf8_lossy(&out.stderr);
    assert_eq!(out.status.code(), Some(3), "{told}");
    assert!(told.contains("cannot open a window"), "{told}");
}
