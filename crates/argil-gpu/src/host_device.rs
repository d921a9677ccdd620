//! A device that a host has opened for its own renderer.

use crate::counters::Counters;
use crate::staging::KeptStaging;
use crate::{DeviceInfo, DeviceKind, Gpu, GpuError};
use wgpu::{Features, Limits, TextureFormat, TextureUsages};

impl Gpu {
    /// Uses a device that the host has opened. wgpu's handles are references, so that the host keeps its own.
    ///
    /// The device needs [`Gpu::required_features`] and [`Gpu::required_limits`]. What it has of [`Gpu::wished_features`] is used.
    /// Errors of commands from here are found in scopes of their own, and do not reach the host's handler. A device
    /// that is lost makes every later call fail: build the scene again with another one.
    ///
    /// ```
    /// use argil_gpu::{Gpu, wgpu};
    /// let instance = wgpu::Instance::default();
    /// let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    /// let descriptor = wgpu::DeviceDescriptor {
    ///     required_features: Gpu::required_features() | adapter.features() & Gpu::wished_features(),
    ///     required_limits: Gpu::required_limits(&adapter),
    ///     ..Default::default()
    /// };
    /// let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))?;
    /// let gpu = Gpu::from_wgpu(device.clone(), queue.clone())?;
    /// assert!(!gpu.info().name.is_empty());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the device lacks a feature or allows less than a limit.
    pub fn from_wgpu(device: wgpu::Device, queue: wgpu::Queue) -> Result<Self, GpuError> {
        let adapter_info = device.adapter_info();
        Self::of_device(device, queue, adapter_info)
    }

    /// Whether this is a given device.
    pub fn is_on(&self, device: &wgpu::Device) -> bool {
        self.device == *device
    }

    /// Uses a device of an adapter. Not every browser's device tells which that is.
    pub(crate) fn of_device(
        device: wgpu::Device,
        queue: wgpu::Queue,
        adapter_info: wgpu::AdapterInfo,
    ) -> Result<Self, GpuError> {
        let info = DeviceInfo::of(&adapter_info);
        check(&info, &device)?;
        // Lavapipe's timestamps are useless once something was rasterized: both stamps of a pass are then taken
        // when it is flushed.
        let has_timestamps = device.features().contains(Features::TIMESTAMP_QUERY)
            && info.kind != DeviceKind::Software;
        let mut gpu = Self {
            device,
            queue,
            info,
            adapter_info,
            has_timestamps,
            writes_snorm: [false; 2],
            counters: Counters::default(),
            as_hardware: false,
            staging: KeptStaging::default(),
            pipeline_cache: None,
            faults: Default::default(),
        };
        gpu.writes_snorm = [TextureFormat::R8Snorm, TextureFormat::R16Snorm]
            .map(|format| gpu.can_write_and_filter(format));
        Ok(gpu)
    }

    /// Returns the features without which [`Gpu::from_wgpu`] refuses a device: none.
    pub fn required_features() -> Features {
        Features::empty()
    }

    /// Returns the features that are used where a device has them: signed samples of 8 and 16 bits, subgroups, pipelines that
    /// are kept on disk, and timestamps.
    pub fn wished_features() -> Features {
        Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES
            | Features::TEXTURE_FORMAT_16BIT_NORM
            | Features::PIPELINE_CACHE
            | Features::SUBGROUP
            | Features::TIMESTAMP_QUERY
    }

    /// Returns the limits that a host should ask of an adapter: those of every WebGPU device, and for buffers and volumes as
    /// much as the adapter allows. [`Gpu::from_wgpu`] needs no more than WebGPU's defaults.
    pub fn required_limits(adapter: &wgpu::Adapter) -> Limits {
        let most = adapter.limits();
        Limits {
            max_buffer_size: most.max_buffer_size,
            max_storage_buffer_binding_size: most.max_storage_buffer_binding_size,
            max_texture_dimension_2d: most.max_texture_dimension_2d,
            max_texture_dimension_3d: most.max_texture_dimension_3d,
            ..Limits::default()
        }
    }

    /// Whether a shader can write a volume of a format, and another one filter it. WebGPU allows that for no signed format, and
    /// devices tell only when they are asked for it.
    fn can_write_and_filter(&self, format: TextureFormat) -> bool {
        let specific = Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES;
        if cfg!(target_arch = "wasm32") || !self.device.features().contains(specific) {
            return false;
        }
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty,
            count: None,
        };
        let sampled = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D3,
            multisampled: false,
        };
        let written = wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format,
            view_dimension: wgpu::TextureViewDimension::D3,
        };
        let tried = self.with_error_scope(|| {
            let texture = self.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("format to try"),
                size: wgpu::Extent3d {
                    depth_or_array_layers: 1,
                    ..wgpu::Extent3d::default()
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D3,
                format,
                usage: TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            for ty in [sampled, written] {
                let layout =
                    self.device
                        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                            label: Some("format to try"),
                            entries: &[entry(0, ty)],
                        });
                let _group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("format to try"),
                    layout: &layout,
                    entries: &[wgpu::BindGroupEntry {
                        binding: 0,
                        resource: wgpu::BindingResource::TextureView(&view),
                    }],
                });
            }
        });
        tried.is_ok()
    }
}

/// Refuses a device that lacks something.
fn check(info: &DeviceInfo, device: &wgpu::Device) -> Result<(), GpuError> {
    let lacking = Gpu::required_features() - device.features();
    if !lacking.is_empty() {
        return Err(GpuError::Lacks {
            name: info.name.clone(),
            lack: format!("the feature {lacking}"),
        });
    }
    let mut lack = None;
    needed_limits().check_limits_with_fail_fn(&device.limits(), true, |limit, needed, allowed| {
        lack = Some(format!("{limit} of {needed}, and allows {allowed}"));
    });
    match lack {
        Some(lack) => Err(GpuError::Lacks {
            name: info.name.clone(),
            lack,
        }),
        None => Ok(()),
    }
}

/// Returns the limits that passes need: of WebGPU's defaults, what compute shaders use.
fn needed_limits() -> Limits {
    let portable = Limits::default();
    Limits {
        max_texture_dimension_2d: portable.max_texture_dimension_2d,
        max_texture_dimension_3d: portable.max_texture_dimension_3d,
        max_buffer_size: portable.max_buffer_size,
        max_storage_buffer_binding_size: portable.max_storage_buffer_binding_size,
        max_storage_buffers_per_shader_stage: portable.max_storage_buffers_per_shader_stage,
        max_storage_textures_per_shader_stage: portable.max_storage_textures_per_shader_stage,
        max_compute_workgroup_storage_size: portable.max_compute_workgroup_storage_size,
        max_compute_invocations_per_workgroup: portable.max_compute_invocations_per_workgroup,
        max_compute_workgroup_size_x: portable.max_compute_workgroup_size_x,
        max_compute_workgroup_size_y: portable.max_compute_workgroup_size_y,
        max_compute_workgroup_size_z: portable.max_compute_workgroup_size_z,
        max_compute_workgroups_per_dimension: portable.max_compute_workgroups_per_dimension,
        ..Limits::downlevel_webgl2_defaults()
    }
}
