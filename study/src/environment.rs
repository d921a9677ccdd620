//! The machine of a measurement.

use crate::plan::Preset;
use crate::record::Machine;
use argil::Engine;

/// Describes the machine and an engine's device.
pub(crate) fn machine(engine: &Engine, preset: Preset) -> Machine {
    let mut system = sysinfo::System::new();
    system.refresh_cpu_all();
    let cpu = system.cpus().first();
    let name = engine.device();
    let gpu = engine.gpu_kind().and_then(|_| {
        let devices = Engine::devices().into_iter();
        let is_named = |d: &argil::gpu::DeviceInfo| name.ends_with(&d.name);
        devices.into_iter().find(is_named)
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
        preset: preset.word().into(),
    }
}
