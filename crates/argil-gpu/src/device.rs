use crate::counters::Counters;
use crate::pipeline_cache::PipelineCache;
use crate::staging::KeptStaging;
use crate::{DeviceInfo, DeviceKind, GpuCounters, GpuError};
use std::path::Path;

/// After this time, a device that has not finished its work is lost. No single dispatch takes nearly as long, on software devices either.
const POLL_TIMEOUT: std::time::Duration = std::time::Duration::from_secs(600);

impl DeviceInfo {
    pub(crate) fn of(info: &wgpu::AdapterInfo) -> Self {
        let kind = match info.device_type {
            wgpu::DeviceType::DiscreteGpu => DeviceKind::Discrete,
            wgpu::DeviceType::IntegratedGpu => DeviceKind::Integrated,
            wgpu::DeviceType::VirtualGpu => DeviceKind::Virtual,
            wgpu::DeviceType::Cpu => DeviceKind::Software,
            wgpu::DeviceType::Other => DeviceKind::Other,
        };
        let driver = format!("{} {}", info.driver, info.driver_info)
            .trim()
            .to_owned();
        // Browsers may hide it.
        let name = if info.name.is_empty() {
            "unnamed device".into()
        } else {
            info.name.clone()
        };
        Self {
            name,
            kind,
            backend: info.backend.to_string(),
            driver,
        }
    }
}

/// Returns all adapters, best first. In a browser, the one that it offers.
async fn adapters() -> Vec<(DeviceInfo, wgpu::Adapter)> {
    let instance =
        wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    #[cfg(not(target_arch = "wasm32"))]
    let found = instance.enumerate_adapters(wgpu::Backends::PRIMARY).await;
    #[cfg(target_arch = "wasm32")]
    let found = {
        let wanted = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..wgpu::RequestAdapterOptions::default()
        };
        instance.request_adapter(&wanted).await.ok()
    };
    let mut all: Vec<_> = found
        .into_iter()
        .map(|a| (DeviceInfo::of(&a.get_info()), a))
        .collect();
    let rank = |kind| match kind {
        DeviceKind::Discrete => 0,
        DeviceKind::Integrated => 1,
        DeviceKind::Virtual => 2,
        DeviceKind::Other => 3,
        DeviceKind::Software => 4,
    };
    all.sort_by_key(|(info, _)| rank(info.kind));
    all
}

/// Lists the graphics devices of this machine, best first.
pub async fn devices() -> Vec<DeviceInfo> {
    let all = adapters().await;
    all.into_iter().map(|(info, _)| info).collect()
}

/// A graphics device.
///
/// [`Gpu::open`] opens one. [`Gpu::from_wgpu`] uses the device of a program that has its own renderer.
#[derive(Debug)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) info: DeviceInfo,
    pub(crate) adapter_info: wgpu::AdapterInfo,
    /// Whether the device can time passes; otherwise each is timed by the clock, with a wait.
    pub(crate) has_timestamps: bool,
    /// Whether shaders can write signed normalized textures of 8 and of 16 bits.
    pub(crate) writes_snorm: [bool; 2],
    pub(crate) counters: Counters,
    /// Whether a software device gets what hardware gets.
    pub(crate) as_hardware: bool,
    /// What the CPU reads through.
    pub(crate) staging: KeptStaging,
    /// Pipelines of earlier processes.
    pub(crate) pipeline_cache: Option<PipelineCache>,
    /// Errors that nothing has waited for: of writes, and in a browser, which does not wait, of all commands.
    pub(crate) faults: std::sync::Arc<std::sync::Mutex<Option<GpuError>>>,
}

impl Gpu {
    /// Opens the best device, a software one if there is no other. In a browser, it uses only the limits and
    /// features that every WebGPU device has.
    ///
    /// # Errors
    /// If no adapter is found, or it refuses the device.
    pub async fn open() -> Result<Self, GpuError> {
        if cfg!(target_arch = "wasm32") {
            return Self::open_portable().await;
        }
        Self::open_with(wgpu::Adapter::limits, Self::wished_features()).await
    }

    /// Opens the best device with only the limits and formats that every WebGPU device has, to test what runs in a
    /// browser.
    ///
    /// # Errors
    /// If no adapter is found, or it refuses the device.
    pub async fn open_portable() -> Result<Self, GpuError> {
        Self::open_with(|_| wgpu::Limits::default(), wgpu::Features::TIMESTAMP_QUERY).await
    }

    async fn open_with(
        limits: impl FnOnce(&wgpu::Adapter) -> wgpu::Limits,
        specific: wgpu::Features,
    ) -> Result<Self, GpuError> {
        let (info, adapter) = adapters().await.into_iter().next().ok_or(GpuError::None)?;
        let required_features = adapter.features() & specific;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("argil"),
            required_features,
            required_limits: limits(&adapter),
            ..wgpu::DeviceDescriptor::default()
        };
        let opened = adapter.request_device(&descriptor).await;
        let (device, queue) = opened.map_err(|e| GpuError::Device {
            name: info.name.clone(),
            reason: e.to_string(),
        })?;
        Self::of_device(device, queue, adapter.get_info())
    }

    /// Gives a software device the passes that hardware gets, slow as they are there, to test them. Only opcodes that no program
    /// uses are still left out.
    #[must_use]
    pub fn as_hardware(mut self) -> Self {
        self.as_hardware = true;
        self
    }

    /// Whether passes are those for hardware.
    pub(crate) fn is_hardware(&self) -> bool {
        self.as_hardware || self.info.kind != DeviceKind::Software
    }

    /// Returns wgpu's device, for a renderer of the program's own.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// Returns the queue of the device.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Describes the device.
    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// Returns the number of pixels of the largest image that is rendered at once.
    pub fn max_pixels(&self) -> u64 {
        let limits = self.device.limits();
        let bytes = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        bytes / (argil_abi::MAX_RECORDS * argil_abi::RECORD_BYTES)
    }

    /// Runs `work` and turns wgpu's errors into an error. In a browser, the next [`Gpu::wait`] reports them.
    pub(crate) fn with_error_scope<T>(&self, work: impl FnOnce() -> T) -> Result<T, GpuError> {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let result = work();
        let (refused, exhausted) = (validation.pop(), memory.pop());
        #[cfg(target_arch = "wasm32")]
        {
            let (faults, name) = (self.faults.clone(), self.info.name.clone());
            wasm_bindgen_futures::spawn_local(async move {
                if let Some(error) = refused.await.or(exhausted.await)
                    && let Ok(mut fault) = faults.lock()
                {
                    fault.get_or_insert(GpuError::Validation {
                        name,
                        reason: error.to_string(),
                    });
                }
            });
            Ok(result)
        }
        #[cfg(not(target_arch = "wasm32"))]
        match pollster::block_on(refused).or(pollster::block_on(exhausted)) {
            Some(error) => Err(GpuError::Validation {
                name: self.info.name.clone(),
                reason: error.to_string(),
            }),
            None => Ok(result),
        }
    }

    /// Waits until everything that was submitted is done.
    pub(crate) async fn wait(&self) -> Result<(), GpuError> {
        self.poll()?;
        #[cfg(target_arch = "wasm32")]
        {
            let (sender, receiver) = futures_channel::oneshot::channel();
            self.queue.on_submitted_work_done(move || {
                // The receiver waits below.
                let _ = sender.send(());
            });
            receiver.await.map_err(|e| GpuError::Lost(e.to_string()))?;
        }
        self.fault().map_or(Ok(()), Err)
    }

    /// Lets the device process what was submitted, and call back. A browser does so by itself when it gets time.
    pub(crate) fn poll(&self) -> Result<(), GpuError> {
        self.counters.waits.add(1);
        let poll = wgpu::PollType::Wait {
            submission_index: None,
            timeout: Some(POLL_TIMEOUT),
        };
        self.device
            .poll(poll)
            .map(|_| ())
            .map_err(|error| match error {
                wgpu::PollError::Timeout => GpuError::Lost(format!(
                    "it did not finish its work within {} minutes",
                    POLL_TIMEOUT.as_secs() / 60
                )),
                other => GpuError::Lost(other.to_string()),
            })
    }

    /// Writes to a buffer before what is submitted next. What goes wrong, on a lost device for example, is the error of what is
    /// waited for next.
    pub(crate) fn write_buffer(&self, buffer: &wgpu::Buffer, offset: u64, bytes: &[u8]) {
        let written = self.with_error_scope(|| self.queue.write_buffer(buffer, offset, bytes));
        if let (Err(error), Ok(mut fault)) = (written, self.faults.lock()) {
            fault.get_or_insert(error);
        }
    }

    /// Takes the errors since the last call.
    pub(crate) fn fault(&self) -> Option<GpuError> {
        self.faults.lock().ok()?.take()
    }

    /// Returns what the device has been asked to do since it was opened.
    pub fn counters(&self) -> GpuCounters {
        self.counters.read()
    }

    /// Submits an encoder's commands.
    pub(crate) fn submit(&self, encoder: wgpu::CommandEncoder) {
        self.counters.submissions.add(1);
        self.queue.submit([encoder.finish()]);
    }

    /// Submits what was written to buffers and textures.
    pub(crate) fn flush(&self) -> Result<(), GpuError> {
        self.counters.submissions.add(1);
        self.with_error_scope(|| {
            self.queue.submit([]);
        })
    }

    /// Creates a buffer.
    pub(crate) fn create_buffer(&self, descriptor: &wgpu::BufferDescriptor<'_>) -> wgpu::Buffer {
        self.counters.buffers.add(1);
        self.device.create_buffer(descriptor)
    }

    /// Keeps compiled pipelines in a folder, so that the next process does not compile them again. Where the device
    /// cannot return them, the driver may still have a cache of its own. A damaged file is replaced.
    #[must_use]
    pub fn with_pipeline_cache(mut self, folder: &Path) -> Self {
        self.pipeline_cache = PipelineCache::open(&self.device, &self.adapter_info, folder);
        self
    }

    /// Returns the cache for the descriptor of a pipeline.
    pub(crate) fn pipeline_cache(&self) -> Option<&wgpu::PipelineCache> {
        self.pipeline_cache.as_ref().map(PipelineCache::get)
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        if let Some(cache) = self
            .pipeline_cache
            .as_ref()
            .filter(|_| self.counters().pipelines > 0)
        {
            cache.save();
        }
    }
}
