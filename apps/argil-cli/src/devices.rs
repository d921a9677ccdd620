//! `argil devices`.

use crate::args::Devices;
use crate::output;
use argil::Engine;
use serde_json::json;

pub(crate) fn run(options: &Devices) -> anyhow::Result<()> {
    let devices = Engine::devices();
    let chosen = Engine::auto()?;
    if options.json {
        let list: Vec<_> = devices
            .iter()
            .map(|d| json!({ "name": d.name, "kind": d.kind.to_string(), "backend": d.backend, "driver": d.driver }))
            .collect();
        output::json(&json!({
            "devices": list,
            "cpu": Engine::cpu().device(),
            "auto": chosen.device(),
            "auto_reason": chosen.selection_reason(),
        }));
        return Ok(());
    }
    output::line(&Engine::cpu().device());
    for d in &devices {
        output::line(&format!(
            "gpu: {} ({}, {}, {})",
            d.name, d.kind, d.backend, d.driver
        ));
    }
    if devices.is_empty() {
        output::line(
            "gpu: none (for a software one on Debian or Ubuntu: apt-get install mesa-vulkan-drivers libvulkan1)",
        );
    }
    output::line(&format!(
        "--device auto selects {}, because {}",
        chosen.device(),
        chosen.selection_reason()
    ));
    Ok(())
}
