//! Another renderer, measured in the same sitting: fidget's for the GPU, as a program of its own.

use crate::outcome::Outcome;
use anyhow::Context;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The environment variable that names the program or its folder.
pub const PEER_VARIABLE: &str = "ARGIL_FIDGET_WGPU";

/// Where the program's folder is looked for if nothing names it.
const DEFAULT_FOLDER: &str = "../shared/peers/fidget-wgpu";

/// The program, below its folder.
const PROGRAM: &str = "target/release/bench-fidget-wgpu";

/// The frames and edits of the first run, which is not counted.
const FIRST_REPETITIONS: u32 = 3;

/// How long the frames and edits of other runs take, about.
const FRAMES_MS: f64 = 1000.0;

/// The fewest and the most frames and edits of other runs.
const REPETITIONS: [f64; 2] = [5.0, 200.0];

/// How long one run may take.
const TIME_LIMIT: Duration = Duration::from_secs(20);

/// A built program that renders models with fidget-wgpu.
///
/// Its arguments are a model, the pixels along a side, and a number of repetitions. It prints the median times of a
/// frame with its read-back, and of a moved brush and a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Peer {
    program: PathBuf,
    models: PathBuf,
}

impl Peer {
    /// Finds the program: at a path, at [`PEER_VARIABLE`], or in a default folder. Returns `None` if nothing names it
    /// and the default folder does not exist.
    ///
    /// # Errors
    /// If a path was given, or the default folder exists, and the program or its models are missing.
    pub fn find(path: Option<&Path>) -> anyhow::Result<Option<Self>> {
        let named = path.map(PathBuf::from);
        let named = named.or_else(|| std::env::var_os(PEER_VARIABLE).map(PathBuf::from));
        match named {
            Some(path) => Self::at(&path).map(Some),
            None if Path::new(DEFAULT_FOLDER).is_dir() => {
                Self::at(Path::new(DEFAULT_FOLDER)).map(Some)
            }
            None => Ok(None),
        }
    }

    fn at(path: &Path) -> anyhow::Result<Self> {
        let program = if path.is_dir() {
            path.join(format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX))
        } else {
            path.to_owned()
        };
        let program = program.canonicalize().with_context(|| {
            format!(
                "{}: there is no such program; build it with `cargo build --release` in its folder",
                program.display()
            )
        })?;
        let places = program.ancestors().skip(1);
        let mut places = places.flat_map(|folder| [folder.join("scenes"), folder.to_owned()]);
        let models = places
            .find(|folder| folder.join("csg20.txt").is_file())
            .with_context(|| {
                format!(
                    "cannot find the model csg20.txt: expected it in a folder `scenes` above {}",
                    program.display()
                )
            })?;
        Ok(Self { program, models })
    }

    /// Runs the program for a scene and a number of pixels along a side, without counting its times. Returns the number
    /// of frames and edits for later runs.
    ///
    /// # Errors
    /// If the program fails, takes too long, or prints something else.
    pub(crate) fn try_out(&self, scene: &str, side: u32) -> anyhow::Result<u32> {
        let times = self.times(scene, side, FIRST_REPETITIONS)?;
        let [least, most] = REPETITIONS;
        let count = FRAMES_MS / (times.frame_ms + times.edit_ms).max(1e-3);
        Ok(count.clamp(least, most) as u32)
    }

    /// Runs the program once, for a scene, a number of pixels along a side, and a number of frames and edits. Returns
    /// how long these took, at the end of the run.
    ///
    /// # Errors
    /// If the program fails, takes too long, or prints something else.
    pub(crate) fn sample(
        &self,
        scene: &str,
        (side, repetitions): (u32, u32),
        out: &mut Outcome,
    ) -> anyhow::Result<Duration> {
        let times = self.times(scene, side, repetitions)?;
        out.add("frame_wall_ms", times.frame_ms);
        out.add("edit_and_frame_ms", times.edit_ms);
        out.set("hit_pixels", times.hit_pixels);
        let duration_ms = f64::from(repetitions) * (times.frame_ms + times.edit_ms);
        Ok(Duration::from_secs_f64(duration_ms.clamp(0.0, 1e6) / 1e3))
    }

    fn times(&self, scene: &str, side: u32, repetitions: u32) -> anyhow::Result<PeerTimes> {
        let text = self.run(scene, side, repetitions)?;
        parse(&text).with_context(|| format!("cannot read the peer's line: {text}"))
    }

    fn run(&self, scene: &str, side: u32, repetitions: u32) -> anyhow::Result<String> {
        let mut child = Command::new(&self.program)
            .arg(self.models.join(format!("{scene}.txt")))
            .args([side.to_string(), repetitions.to_string()])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .with_context(|| self.program.display().to_string())?;
        let start = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait()? {
                break status;
            }
            if start.elapsed() > TIME_LIMIT {
                child.kill()?;
                child.wait()?;
                anyhow::bail!("the peer took longer than {} s", TIME_LIMIT.as_secs());
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        anyhow::ensure!(status.success(), "the peer failed: {status}");
        let mut text = String::new();
        // The program prints a line, which the pipe holds.
        if let Some(mut output) = child.stdout.take() {
            output.read_to_string(&mut text)?;
        }
        Ok(text)
    }
}

/// What a run of the program printed.
#[derive(Debug, PartialEq)]
struct PeerTimes {
    frame_ms: f64,
    edit_ms: f64,
    hit_pixels: f64,
}

/// Parses the program's line.
fn parse(text: &str) -> Option<PeerTimes> {
    let line = text.lines().find(|line| line.contains("hit="))?;
    let number = |after: &str, until: &str| -> Option<f64> {
        let (_, rest) = line.split_once(after)?;
        rest.split(until).next()?.trim().parse().ok()
    };
    Some(PeerTimes {
        frame_ms: number("read back) median ", " ms")?,
        edit_ms: number("brush moved and frame median ", " ms")?,
        hit_pixels: number("hit=", ";")?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINE: &str = "csg20.txt 512: frame (submit, wait, read back) median 1.25 ms; brush moved and frame median 2.50 ms; hit=65041; n=10\n";

    #[test]
    fn lines_of_the_peer_are_parsed() {
        let expected = PeerTimes {
            frame_ms: 1.25,
            edit_ms: 2.5,
            hit_pixels: 65041.0,
        };
        assert_eq!(parse(LINE), Some(expected));
        for text in [
            "",
            "no adapter",
            &LINE.replace("1.25", "fast"),
            &LINE.replace("hit=", ""),
        ] {
            assert_eq!(parse(text), None, "{text}");
        }
    }

    #[test]
    #[cfg(unix)]
    fn a_peer_is_run() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("a folder");
        let checkout = folder.path().join("fidget-wgpu");
        let program = checkout.join(PROGRAM);
        std::fs::create_dir_all(program.parent().expect("a folder")).expect("a folder");
        let error = Peer::at(&checkout).expect_err("no program");
        assert!(format!("{error:#}").contains("cargo build"), "{error:#}");
        std::fs::write(
            &program,
            format!("#!/bin/sh\ntest -f $1 && echo '{}'", LINE.trim()),
        )
        .expect("a program");
        std::fs::set_permissions(&program, PermissionsExt::from_mode(0o755)).expect("a program");
        assert!(Peer::at(&checkout).is_err(), "it has no models");
        let models = folder.path().join("scenes");
        std::fs::create_dir(&models).expect("a folder");
        std::fs::write(models.join("csg20.txt"), "").expect("a model");
        let peer = Peer::at(&checkout).expect("a peer");
        let mut out = Outcome::default();
        assert_eq!(peer.try_out("csg20", 512).expect("a run"), 200);
        let taken = peer.sample("csg20", (512, 200), &mut out);
        assert_eq!(taken.expect("a sample"), Duration::from_millis(750));
        assert_eq!(out.samples["frame_wall_ms"], [1.25]);
        assert!(peer.try_out("teapot", 512).is_err(), "no such model");
    }
}
