//! Installs packages of Debian and Ubuntu where no password is needed.

use std::process::{Command, Stdio};

/// Runs a program without output. Returns true if it succeeded.
pub fn quietly(program: &str, arguments: &[&str]) -> bool {
    quietly_with(&[], program, arguments)
}

/// Runs a program without output, with environment variables. Returns true if it succeeded.
pub fn quietly_with(environment: &[(&str, &str)], program: &str, arguments: &[&str]) -> bool {
    let command = Command::new(program)
        .args(arguments)
        .envs(environment.iter().copied())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    command.is_ok_and(|status| status.success())
}

/// Installs packages, as root or with passwordless sudo. Returns true if it succeeded.
pub fn install(packages: &[&str]) -> bool {
    let arguments = [&["install", "-y", "--no-install-recommends"], packages].concat();
    let is_root = quietly("sh", &["-c", "[ \"$(id -u)\" = 0 ]"]);
    if is_root {
        quietly("apt-get", &["update"]) && crate::run("apt-get", &arguments).is_ok()
    } else if quietly("sudo", &["-n", "true"]) {
        quietly("sudo", &["apt-get", "update"])
            && crate::run("sudo", &[&["apt-get"][..], &arguments].concat()).is_ok()
    } else {
        false
    }
}
