//! Clocks of GPUs, read from the text of `nvidia-smi` and of Linux's files.

use std::path::{Path, PathBuf};

/// The query of `nvidia-smi` whose lines [`nvidia`] parses.
pub(crate) const NVIDIA_QUERY: [&str; 2] = [
    "--query-gpu=name,clocks.sm,clocks.max.sm",
    "--format=csv,noheader,nounits",
];

/// A clock at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClockReading {
    /// The clock in MHz.
    pub mhz: f64,
    /// The highest clock of the device in MHz, if it says so.
    pub limit_mhz: Option<f64>,
}

/// Where clocks of a device come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum ClockSource {
    /// `nvidia-smi`, for a device of this name.
    Nvidia(String),
    /// A file of Linux's driver for AMD with one level per line.
    AmdLevels(PathBuf),
    /// A file of Linux's driver for Intel with a number.
    IntelNumber(PathBuf),
}

/// Parses a line of `nvidia-smi`. Returns `None` for a line of another device, `[N/A]`, and other text.
pub(crate) fn nvidia(line: &str, device: &str) -> Option<ClockReading> {
    let mut fields = line.rsplitn(3, ',').map(str::trim);
    let (limit, clock, name) = (fields.next()?, fields.next()?, fields.next()?);
    (!name.is_empty() && device.ends_with(name)).then_some(())?;
    Some(ClockReading {
        mhz: positive(clock)?,
        limit_mhz: positive(limit),
    })
}

/// Parses the levels of an AMD device, such as `1: 800Mhz *`. The star marks the active one.
pub(crate) fn amd(levels: &str) -> Option<ClockReading> {
    let clock = |line: &str| {
        let (_, clock) = line.split_once(':')?;
        let clock = clock.trim().trim_end_matches('*').trim();
        positive(clock.strip_suffix("Mhz")?)
    };
    let active = levels
        .lines()
        .find(|line| line.trim_end().ends_with('*'))
        .and_then(clock)?;
    let highest = levels.lines().filter_map(clock).reduce(f64::max);
    Some(ClockReading {
        mhz: active,
        limit_mhz: highest,
    })
}

/// Parses the clock of an Intel device, which is a number.
pub(crate) fn intel(text: &str) -> Option<ClockReading> {
    Some(ClockReading {
        mhz: positive(text.trim())?,
        limit_mhz: None,
    })
}

/// Parses a number above zero.
fn positive(text: &str) -> Option<f64> {
    let number: f64 = text.parse().ok()?;
    (number.is_finite() && number > 0.0).then_some(number)
}

/// Finds the source of a device's clock.
///
/// # Errors
/// If there is none. The text says why.
pub(crate) fn source(device: &str) -> Result<ClockSource, String> {
    let lower = device.to_lowercase();
    if lower.contains("nvidia") {
        return Ok(ClockSource::Nvidia(device.into()));
    }
    let drm = Path::new("/sys/class/drm");
    let one = |vendor: &str, file: &str| -> Result<PathBuf, String> {
        let mut all = files(drm, vendor, file);
        match (all.pop(), all.len()) {
            (None, _) => Err(format!("no file {}/card*/{file}", drm.display())),
            (Some(path), 0) => Ok(path),
            // A file does not tell which device is measured.
            _ => Err("several GPUs of this vendor".into()),
        }
    };
    if lower.contains("amd") || lower.contains("radeon") {
        return one("0x1002", "device/pp_dpm_sclk").map(ClockSource::AmdLevels);
    }
    if lower.contains("intel") {
        return one("0x8086", "gt_act_freq_mhz").map(ClockSource::IntelNumber);
    }
    Err("no clock is known for this device".into())
}

/// Returns a file of each card of a vendor.
fn files(drm: &Path, vendor: &str, file: &str) -> Vec<PathBuf> {
    let cards = std::fs::read_dir(drm).into_iter().flatten().flatten();
    let is_own = |card: &PathBuf| {
        let vendor_of_card = std::fs::read_to_string(card.join("device/vendor"));
        vendor_of_card.is_ok_and(|vendor_of_card| vendor_of_card.trim() == vendor)
    };
    let cards = cards.map(|entry| entry.path()).filter(is_own);
    let paths = cards.map(|card| card.join(file));
    paths.filter(|path| path.is_file()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const H100: &str = "NVIDIA H100 80GB HBM3";

    #[test]
    fn nvidia_lines_are_parsed() {
        let found = nvidia("NVIDIA H100 80GB HBM3, 345, 1980", H100).expect("a clock");
        assert_eq!((found.mhz, found.limit_mhz), (345.0, Some(1980.0)));
        let found = nvidia("NVIDIA H100 80GB HBM3, 1755, [N/A]\r\n", H100).expect("a clock");
        assert_eq!((found.mhz, found.limit_mhz), (1755.0, None));
        for line in [
            "NVIDIA H100 80GB HBM3, [N/A], [N/A]",
            "NVIDIA H100 80GB HBM3, [Not Supported], 1980",
            "NVIDIA T4, 585, 1590",
            "NVIDIA H100 80GB HBM3, 0, 1980",
            ", 345, 1980",
            "345, 1980",
            "No devices were found",
            "",
        ] {
            assert_eq!(nvidia(line, H100), None, "{line}");
        }
    }

    #[test]
    fn amd_levels_are_parsed() {
        let found = amd("0: 500Mhz \n1: 800Mhz *\n2: 2575Mhz \n").expect("a clock");
        assert_eq!((found.mhz, found.limit_mhz), (800.0, Some(2575.0)));
        for text in [
            "0: 500Mhz\n1: 2575Mhz\n",
            "S: 19Mhz\n",
            "1: fast *\n",
            "*",
            "",
        ] {
            assert_eq!(amd(text), None, "{text}");
        }
    }

    #[test]
    fn intel_numbers_are_parsed() {
        assert_eq!(intel("1150\n").map(|found| found.mhz), Some(1150.0));
        assert_eq!(intel("0\n"), None);
        assert_eq!(intel("off\n"), None);
    }

    #[test]
    fn devices_without_a_clock_say_so() {
        for device in ["llvmpipe (LLVM 15.0.6, 256 bits)", "Apple M2"] {
            assert!(source(device).is_err(), "{device}");
        }
        assert_eq!(source(H100), Ok(ClockSource::Nvidia(H100.into())));
    }

    #[test]
    fn cards_of_a_vendor_are_found() {
        let folder = tempfile::tempdir().expect("a folder");
        for (card, vendor) in [
            ("card0", "0x1002"),
            ("card1", "0x8086"),
            ("card2", "0x1002"),
        ] {
            let device = folder.path().join(card).join("device");
            std::fs::create_dir_all(&device).expect("a folder");
            std::fs::write(device.join("vendor"), vendor).expect("a file");
            std::fs::write(device.join("pp_dpm_sclk"), "0: 500Mhz *").expect("a file");
        }
        let count = |vendor| files(folder.path(), vendor, "device/pp_dpm_sclk").len();
        assert_eq!(
            [count("0x1002"), count("0x8086"), count("0x10de")],
            [2, 1, 0]
        );
    }
}
