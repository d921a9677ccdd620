//! The device of the window, which is the engine's too where that is a GPU.

use argil::gpu::{Gpu, GpuError};
use argil::{Backend, Engine, EngineError};
use eframe::egui_wgpu::{RenderState, WgpuSetup};
use std::sync::Arc;

/// Has a window open a device that can be the engine's too, where the adapter allows that.
pub fn share_device(setup: &mut WgpuSetup) {
    use argil::gpu::wgpu;
    if let WgpuSetup::CreateNew(options) = setup {
        options.power_preference = wgpu::PowerPreference::HighPerformance;
        let plain = options.device_descriptor.clone();
        options.device_descriptor = Arc::new(move |adapter| {
            let mut descriptor = plain(adapter);
            if adapter.get_info().backend != wgpu::Backend::Gl {
                descriptor.required_features |= adapter.features() & Gpu::wished_features();
                descriptor.required_limits = Gpu::required_limits(adapter);
            }
            descriptor
        });
    }
}

/// Returns an engine on a back end. A GPU is that of the window, so that images stay on it.
///
/// # Errors
/// If a GPU is required, and the window's cannot be used.
pub fn engine_of_window(
    window: Option<&RenderState>,
    backend: Backend,
) -> Result<Engine, EngineError> {
    let Some(window) = window else {
        return match backend {
            Backend::Gpu => Err(GpuError::None.into()),
            _ => Ok(Engine::cpu()),
        };
    };
    let shared = || {
        let gpu = Gpu::from_wgpu(window.device.clone(), window.queue.clone())?;
        let gpu = match argil::cache_folder() {
            Some(folder) => gpu.with_pipeline_cache(&folder.join("pipelines")),
            None => gpu,
        };
        Ok::<_, GpuError>(Engine::on_gpu(gpu))
    };
    match backend {
        Backend::Gpu => Ok(shared()?),
        Backend::Auto => {
            let of_window = shared().ok();
            let is_real = |engine: &Engine| engine.gpu_kind().is_some_and(|k| k.is_real_gpu());
            Ok(of_window.filter(is_real).unwrap_or_else(Engine::cpu))
        }
        _ => Ok(Engine::cpu()),
    }
}
