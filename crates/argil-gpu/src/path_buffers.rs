//! Paths of light that are to be traced, and their buffers.

use crate::bindings::{
    ENVIRONMENT, FRAME, MATERIALS, PATH_PIXELS, PATH_STATES, PATH_TABLES, PATHS,
};
use crate::pass_module::Passes;
use crate::resources::{extent, uniform_of};
use crate::storage_buffer::StorageBuffer;
use crate::trace_mode::BoundResource;
use crate::{Gpu, GpuError};
use argil_abi::{FrameUniform, GpuMaterial, PathPixel, PathState, PathUniform};
use argil_field::Program;
use argil_math::Control;
use argil_render::{PathTables, StillOptions};

/// The most pixels whose paths are on their way at once.
const BAND: u64 = 1 << 18;
/// Bytes before the pixels.
const HEADER: u64 = 16;

/// What paths are to be traced.
#[derive(Clone, Copy, Debug)]
pub struct PathWork<'a> {
    /// The camera, the size and the ground.
    pub frame: &'a FrameUniform,
    /// Lights, and the lengths that follow from surfaces: see [`PathUniform`].
    pub tables: &'a PathTables,
    /// The program on the device.
    pub program: &'a Program,
    /// How many paths.
    pub options: &'a StillOptions,
    /// Cancels the work, and learns of its progress.
    pub control: &'a Control,
}

/// Buffers for the paths of a band of pixels, and what they read.
pub(crate) struct PathBuffers {
    /// Pixels of a band.
    pub band: u32,
    frame: wgpu::Buffer,
    uniform: wgpu::Buffer,
    states: StorageBuffer,
    pixels: StorageBuffer,
    tables: StorageBuffer,
    /// Materials, and what they have besides, if anything.
    materials: Option<StorageBuffer>,
    environment: wgpu::TextureView,
}

impl PathBuffers {
    pub(crate) fn new(
        gpu: &Gpu,
        work: &PathWork<'_>,
        extras: &[GpuMaterial],
    ) -> Result<Self, GpuError> {
        let limits = gpu.device.limits();
        let bytes = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        let fit = (bytes / size_of::<PathState>() as u64).min(BAND);
        let band = u64::from(work.frame.width) * u64::from(work.frame.height);
        let band = band.min(fit).max(1);
        let mut states = StorageBuffer::new("paths");
        states.reserve_exact(gpu, band * size_of::<PathState>() as u64)?;
        let mut pixels = StorageBuffer::new("what paths found");
        pixels.reserve_exact(gpu, HEADER + band * size_of::<PathPixel>() as u64)?;
        let mut tables = StorageBuffer::new("lights");
        tables.write(gpu, &work.tables.rows)?;
        let materials = match extras {
            [] => None,
            extras => {
                let all = [work.program.material_table(), extras].concat();
                let mut table = StorageBuffer::new("materials of paths");
                table.write(gpu, &all)?;
                Some(table)
            }
        };
        let (frame, uniform) = gpu.with_error_scope(|| {
            (
                uniform_of::<FrameUniform>(gpu, "frame"),
                uniform_of::<PathUniform>(gpu, "paths"),
            )
        })?;
        gpu.write_buffer(&frame, 0, bytemuck::bytes_of(work.frame));
        Ok(Self {
            band: band as u32,
            frame,
            uniform,
            states,
            pixels,
            tables,
            materials,
            environment: environment(gpu, work)?,
        })
    }

    /// Binds them, and what passes read of the surfaces.
    pub(crate) fn bind(
        &self,
        gpu: &Gpu,
        passes: &Passes,
        mut bound: Vec<BoundResource>,
    ) -> Result<wgpu::BindGroup, GpuError> {
        if let Some(materials) = &self.materials {
            bound.retain(|resource| resource.place() != MATERIALS);
            bound.extend(materials.bound(MATERIALS));
        }
        bound.retain(|resource| passes.places().any(|place| place == resource.place()));
        bound.push(BoundResource::buffer(FRAME, &self.frame));
        bound.push(BoundResource::buffer(PATHS, &self.uniform));
        bound.push(BoundResource::View(ENVIRONMENT, self.environment.clone()));
        bound.extend(self.states.bound(PATH_STATES));
        bound.extend(self.pixels.bound(PATH_PIXELS));
        bound.extend(self.tables.bound(PATH_TABLES));
        let entries: Vec<_> = bound.iter().map(BoundResource::entry).collect();
        gpu.with_error_scope(|| {
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("Paths"),
                layout: &passes.layout,
                entries: &entries,
            })
        })
    }

    /// Forgets all paths.
    pub(crate) fn restart(&self, gpu: &Gpu, uniform: &PathUniform) {
        gpu.write_buffer(&self.uniform, 0, bytemuck::bytes_of(uniform));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for buffer in [&self.states, &self.pixels]
            .into_iter()
            .filter_map(StorageBuffer::buffer)
        {
            encoder.clear_buffer(buffer, 0, None);
        }
        gpu.submit(encoder);
    }

    /// Returns the number of pixels all of whose paths have ended.
    pub(crate) async fn finished(&self, gpu: &Gpu) -> Result<u32, GpuError> {
        let words = self.read(gpu, HEADER).await?;
        Ok(bytemuck::pod_read_unaligned(&words[..4]))
    }

    /// Returns what the paths of the first pixels found.
    pub(crate) async fn found(&self, gpu: &Gpu, count: u32) -> Result<Vec<PathPixel>, GpuError> {
        let size = size_of::<PathPixel>();
        let bytes = HEADER + u64::from(count) * size as u64;
        let all = self.read(gpu, bytes).await?;
        let rows = all[HEADER as usize..].chunks_exact(size);
        Ok(rows.map(bytemuck::pod_read_unaligned).collect())
    }

    async fn read(&self, gpu: &Gpu, bytes: u64) -> Result<Vec<u8>, GpuError> {
        let missing = || GpuError::Lost("no paths".into());
        let buffer = self.pixels.buffer().ok_or_else(missing)?;
        gpu.read_back(buffer, bytes).await
    }
}

/// Uploads the image behind everything.
fn environment(gpu: &Gpu, work: &PathWork<'_>) -> Result<wgpu::TextureView, GpuError> {
    let [width, height] = work.tables.environment_size();
    let limit = gpu.device.limits().max_texture_dimension_2d;
    if width.max(height) > limit {
        return Err(GpuError::WideImage {
            name: gpu.info.name.clone(),
            pixels: width.max(height),
            limit,
        });
    }
    gpu.with_error_scope(|| {
        let size = extent(width, height, 1);
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("environment"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        gpu.queue.write_texture(
            texture.as_image_copy(),
            bytemuck::cast_slice(&work.tables.environment),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(16 * width),
                rows_per_image: None,
            },
            size,
        );
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    })
}
