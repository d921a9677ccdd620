//! Creates buffers and textures, and transfers their contents.

use crate::storage_buffer::StorageBuffer;
use crate::texel_format::TexelFormat;
use crate::{Gpu, GpuError};
use argil_volume::{SampleFormat, Texels, VoxelGrid};

/// A row of texels in a buffer takes a multiple of this many bytes.
const ROW_ALIGNMENT: u32 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;

/// Maximum bytes of texels in transfer at once.
pub(crate) const STAGING_BYTES: u64 = 64 << 20;

pub(crate) fn uniform_of<T>(gpu: &Gpu, label: &str) -> wgpu::Buffer {
    uniform_for(gpu, label, size_of::<T>() as u64)
}

/// Creates a uniform buffer of a size.
pub(crate) fn uniform_for(gpu: &Gpu, label: &str, size: u64) -> wgpu::Buffer {
    gpu.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Creates an empty texture for a voxel grid that shaders can write and filter.
pub(crate) fn texture(
    gpu: &Gpu,
    voxel_grid: &VoxelGrid,
    bits: SampleFormat,
    levels: u32,
) -> Result<wgpu::Texture, GpuError> {
    let size = extent(voxel_grid.size.x, voxel_grid.size.y, voxel_grid.size.z);
    texture_of(gpu, size, bits, levels)
}

/// Creates an empty texture that shaders can write and filter.
pub(crate) fn texture_of(
    gpu: &Gpu,
    size: wgpu::Extent3d,
    bits: SampleFormat,
    levels: u32,
) -> Result<wgpu::Texture, GpuError> {
    let format = gpu.texels(bits).format();
    let voxels = size.width.max(size.height).max(size.depth_or_array_layers);
    let limit = gpu.device.limits().max_texture_dimension_3d;
    if voxels > limit {
        return Err(GpuError::TooFine {
            name: gpu.info.name.clone(),
            voxels,
            limit,
        });
    }
    gpu.with_error_scope(|| {
        gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("volume"),
            size,
            mip_level_count: levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::COPY_SRC
                | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        })
    })
}

pub(crate) fn extent(width: u32, height: u32, depth_or_array_layers: u32) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers,
    }
}

/// Uploads the samples of a level.
pub(crate) async fn upload(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    voxel_grid: &VoxelGrid,
    level: u32,
    texels: &Texels,
) -> Result<(), GpuError> {
    let size = voxel_grid.level_size(level);
    let row = size.x as usize * texels.bits().bytes();
    let layer_bytes = row * size.y as usize;
    let layers = (STAGING_BYTES as usize / layer_bytes).clamp(1, size.z as usize);
    let format = gpu.texels(texels.bits());
    let texel_row = size.x as usize * format.bytes();
    for (i, part) in texels.bytes().chunks(layers * layer_bytes).enumerate() {
        gpu.with_error_scope(|| {
            gpu.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture,
                    mip_level: level,
                    origin: wgpu::Origin3d {
                        x: 0,
                        y: 0,
                        z: (i * layers) as u32,
                    },
                    aspect: wgpu::TextureAspect::All,
                },
                &format.texels_of(part),
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(texel_row as u32),
                    rows_per_image: Some(size.y),
                },
                extent(size.x, size.y, (part.len() / layer_bytes) as u32),
            );
        })?;
        // The staging memory is freed once it has arrived.
        gpu.flush()?;
        gpu.wait().await?;
    }
    Ok(())
}

/// Downloads the samples of some layers of a texture, without gaps.
pub(crate) async fn read_texels(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    mip_level: u32,
    texels: TexelFormat,
    [width, height]: [u32; 2],
    layers: std::ops::Range<u32>,
) -> Result<Vec<u8>, GpuError> {
    let row = width as usize * texels.bytes();
    let padded = (row as u32).next_multiple_of(ROW_ALIGNMENT);
    let staged = gpu.with_error_scope(|| {
        let buffer = gpu.create_buffer(&wgpu::BufferDescriptor {
            label: Some("texels"),
            size: u64::from(padded) * u64::from(height) * layers.len() as u64,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level,
                origin: wgpu::Origin3d {
                    x: 0,
                    y: 0,
                    z: layers.start,
                },
                aspect: wgpu::TextureAspect::All,
            },
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded),
                    rows_per_image: Some(height),
                },
            },
            extent(width, height, layers.len() as u32),
        );
        gpu.submit(encoder);
        buffer
    })?;
    let read = gpu.read_back(&staged, staged.size()).await?;
    let samples = width as usize * height as usize * layers.len();
    let mut bytes = Vec::with_capacity(samples * texels.bits().bytes());
    for line in read.chunks_exact(padded as usize) {
        texels.samples_into(&line[..row], &mut bytes);
    }
    Ok(bytes)
}

/// Downloads the samples of a level of a texture with a voxel grid's size.
pub(crate) async fn read_level(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    (voxel_grid, bits): (&VoxelGrid, SampleFormat),
    level: u32,
) -> Result<Texels, GpuError> {
    let size = voxel_grid.level_size(level);
    let layer_bytes = (size.x * size.y) as u64 * bits.bytes() as u64;
    let mut bytes = Vec::with_capacity((layer_bytes * u64::from(size.z)) as usize);
    // Some layers at a time, because a buffer has limits.
    let layers = (STAGING_BYTES / layer_bytes).clamp(1, u64::from(size.z)) as u32;
    for first in (0..size.z).step_by(layers as usize) {
        let range = first..(first + layers).min(size.z);
        let texels = gpu.texels(bits);
        let part = read_texels(gpu, texture, level, texels, [size.x, size.y], range).await?;
        bytes.extend_from_slice(&part);
    }
    Texels::from_bytes(bits, bytes).ok_or_else(|| GpuError::Lost("half a texel".into()))
}

pub(crate) async fn read_table(
    gpu: &Gpu,
    table: &StorageBuffer,
    bytes: u64,
) -> Result<Vec<u8>, GpuError> {
    let lost = || GpuError::Lost("a table is not there".into());
    if bytes == 0 {
        return Ok(Vec::new());
    }
    gpu.read_back(table.buffer().ok_or_else(lost)?, bytes).await
}
