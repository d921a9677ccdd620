//! Installs packages of Debian and Ubuntu where no password is needed.

use std::process::{Command, Stdio};

/// Packages, and a command of the shell that succeeds where they, or what replaces them, are installed.
#[derive(Clone, Copy, Debug)]
pub struct Needed {
    /// The command.
    pub look: &'static str,
    /// The packages' names.
    pub packages: &'static [&'static str],
}

impl Needed {
    /// Returns true if nothing is to be installed.
    pub fn is_there(self) -> bool {
        quietly("sh", &["-c", self.look])
    }
}

/// Programs that read our volumes, with which tests compare.
pub const OPENVDB: Needed = Needed {
    look: "/usr/bin/python3 -c 'import pyopenvdb, numpy' && command -v vdb_print nanovdb_validate nanovdb_print",
    packages: &[
        "python3-openvdb",
        "python3-numpy",
        "libopenvdb-tools",
        "libnanovdb-tools",
    ],
};

/// Mesa's drivers: a software device for GPU tests, and on Linux a compiler for hardware, whose statistics are compared.
pub const MESA: Needed = Needed {
    look: "[ \"$(uname)\" != Linux ] || find /usr/share/vulkan /usr/local/share/vulkan /etc/vulkan -name 'radeon_icd*' 2>/dev/null | grep -q .",
    packages: &["mesa-vulkan-drivers", "libvulkan1"],
};

/// A browser for the page's tests.
pub const CHROMIUM: Needed = Needed {
    look: "chromium --version || chromium-browser --version || google-chrome --version || google-chrome-stable --version",
    packages: &["chromium"],
};

/// What runs the page's tests.
pub const NODE: Needed = Needed {
    look: "node --version && npm --version",
    packages: &["nodejs", "npm"],
};

/// A compiler for browsers, where rustup has none.
pub const WEB_RUST: Needed = Needed {
    look: "rustup target add wasm32-unknown-unknown || ls /usr/bin/wasm-ld-* /usr/lib/rustlib/src/rust/library/std/Cargo.toml",
    packages: &[
        "rustc-web",
        "cargo-web",
        "rust-web-src",
        "rust-web-llvm",
        "lld-22",
    ],
};

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
    install_by(packages, |program, arguments| {
        crate::run(program, arguments).is_ok()
    })
}

/// Installs packages as [`install`] does, without output.
pub fn install_quietly(packages: &[&str]) -> bool {
    install_by(packages, quietly)
}

fn install_by(packages: &[&str], run: impl Fn(&str, &[&str]) -> bool) -> bool {
    let arguments = [&["install", "-y", "--no-install-recommends"], packages].concat();
    let is_root = quietly("sh", &["-c", "[ \"$(id -u)\" = 0 ]"]);
    if is_root {
        quietly("apt-get", &["update"]) && run("apt-get", &arguments)
    } else if quietly("sudo", &["-n", "true"]) {
        quietly("sudo", &["apt-get", "update"])
            && run("sudo", &[&["apt-get"][..], &arguments].concat())
    } else {
        false
    }
}
