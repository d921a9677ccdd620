//! The machine of a measurement.

use crate::record::Machine;
use argil::Engine;

/// Returns the clock of a GPU in MHz, from NVIDIA's `nvidia-smi` or Linux's files for AMD and Intel. `None` if
/// neither exists, as with software GPUs.
pub(crate) fn gpu_clock_mhz(device: &str) -> Option<f64> {
    nvidia_clock(device).or_else(|| linux_clock(device))
}

fn nvidia_clock(device: &str) -> Option<f64> {
    if !device.to_lowercase().contains("nvidia") {
        return None;
    }
    let out = std::process::Command::new("nvidia-smi")
        .args([
            "--query-gpu=name,clocks.sm",
            "--format=csv,noheader,nounits",
        ])
        .output()
        .ok()?;
    clock_of(&String::from_utf8(out.stdout).ok()?, device)
}

/// Finds a clock in lines of names and clocks.
fn clock_of(lines: &str, device: &str) -> Option<f64> {
    let mut all = lines.lines().filter_map(|line| line.rsplit_once(','));
    let (_, clock) = all.find(|(name, _)| device.contains(name.trim()))?;
    clock.trim().parse().ok()
}

fn linux_clock(device: &str) -> Option<f64> {
    let maker = ["AMD", "Radeon", "Intel"]
        .iter()
        .find(|maker| device.contains(*maker))?;
    for card in std::fs::read_dir("/sys/class/drm").ok()?.flatten() {
        let read = |name: &str| std::fs::read_to_string(card.path().join(name)).ok();
        let clock = if *maker == "Intel" {
            read("gt_act_freq_mhz")
        } else {
            read("device/pp_dpm_sclk").and_then(|levels| starred(&levels))
        };
        if let Some(clock) = clock.and_then(|text| text.trim().parse().ok()) {
            return Some(clock);
        }
    }
    None
}

/// Returns the active level of lines such as `1: 800Mhz *`.
fn starred(levels: &str) -> Option<String> {
    let line = levels.lines().find(|line| line.contains('*'))?;
    let clock = line.split(':').nth(1)?;
    Some(clock.chars().filter(|c| c.is_ascii_digit()).collect())
}

/// Describes the machine and an engine's device.
pub(crate) fn machine(engine: &Engine, full: bool) -> Machine {
    let mut system = sysinfo::System::new();
    system.refresh_cpu_all();
    let cpu = system.cpus().first();
    let name = engine.device();
    let gpu = engine.gpu_kind().and_then(|_| {
        let devices = Engine::devices().into_iter();
        let own = |d: &argil::gpu::DeviceInfo| name.ends_with(&d.name);
        devices.into_iter().find(own)
    });
    let release = sysinfo::System::long_os_version().unwrap_or_default();
    Machine {
        system: release,
        processor: cpu.map(|c| c.brand().trim().to_owned()).unwrap_or_default(),
        clock_mhz: cpu.map(|c| c.frequency()).unwrap_or_default(),
        threads: rayon::current_num_threads(),
        device: gpu.as_ref().map_or("cpu".into(), |d| d.name.clone()),
        driver: gpu.map_or(String::new(), |d| format!("{}, {}", d.driver, d.backend)),
        version: env!("CARGO_PKG_VERSION").into(),
        commit: env!("ARGIL_COMMIT").into(),
        preset: if full { "full" } else { "quick" }.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clocks_are_read() {
        let lines = "NVIDIA H100 80GB HBM3, 1980\nNVIDIA T4, 585\n";
        assert_eq!(clock_of(lines, "NVIDIA T4"), Some(585.0));
        assert_eq!(clock_of(lines, "NVIDIA L4"), None);
        assert_eq!(clock_of("no devices were found", "NVIDIA T4"), None);
        let levels = "0: 500Mhz\n1: 800Mhz *\n2: 2100Mhz\n";
        assert_eq!(starred(levels).as_deref(), Some("800"));
        assert_eq!(starred("0: 500Mhz"), None);
        assert_eq!(gpu_clock_mhz("llvmpipe"), None);
    }
}
