//! The pool of levels' bricks on the device: a texture that grows by layers, up to the budget.

use crate::resources::{STAGING_BYTES, extent, read_texels};
use crate::texel_format::TexelFormat;
use crate::{Gpu, GpuError};
use argil_volume::{BrickChanges, Levels, MISSING_BRICK, SampleFormat, Texels, is_brick};

/// Bricks along a layer's sides, unless the budget needs more.
const LAYER_SIDE: u32 = 32;
/// Samples along a brick's side.
const SIDE: u32 = 9;

/// The size of the pool.
#[derive(Debug)]
pub(crate) struct LevelPool {
    /// Bricks along each axis.
    size: [u32; 3],
    /// Layers of bricks that the budget allows.
    usual_depth: u32,
    /// Layers that the device allows.
    max_depth: u32,
}

impl LevelPool {
    /// Creates a pool for levels, and its texture.
    pub(crate) fn new(gpu: &Gpu, levels: &Levels) -> Result<(Self, wgpu::Texture), GpuError> {
        let brick = levels.layout().level(0).brick_bytes();
        let bricks = (levels.budget() / brick).max(levels.brick_count()).max(1);
        let most = (gpu.device.limits().max_texture_dimension_3d / SIDE).max(1);
        // Layers are as small as the number of bricks allows.
        let side = (bricks as f64 / f64::from(most)).sqrt().ceil() as u32;
        let usual = ((bricks as f64).cbrt().ceil() as u32).min(LAYER_SIDE);
        let side = side.max(usual).clamp(1, most);
        let layer = u64::from(side) * u64::from(side);
        let mut pool = Self {
            size: [side, side, 0],
            usual_depth: bricks.div_ceil(layer).min(u64::from(most)) as u32,
            max_depth: most,
        };
        pool.size[2] = pool.depth_for(gpu, levels)?;
        let texture = pool.texture(gpu, levels)?;
        Ok((pool, texture))
    }

    /// Returns the bricks along each axis.
    pub(crate) fn size(&self) -> [u32; 3] {
        self.size
    }

    fn depth_for(&self, gpu: &Gpu, levels: &Levels) -> Result<u32, GpuError> {
        let layer = u64::from(self.size[0]) * u64::from(self.size[1]);
        let depth = levels.brick_count().max(1).div_ceil(layer);
        if depth > u64::from(self.max_depth) {
            return Err(GpuError::TooManyBricks {
                name: gpu.info.name.clone(),
                bricks: levels.brick_count(),
                limit: layer * u64::from(self.max_depth),
            });
        }
        Ok(depth as u32)
    }

    fn texture(&self, gpu: &Gpu, levels: &Levels) -> Result<wgpu::Texture, GpuError> {
        let [width, height, depth] = self.size.map(|n| n * SIDE);
        let format = format_for(gpu, levels).format();
        gpu.with_error_scope(|| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("levels"),
                size: extent(width, height, depth),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D3,
                format,
                usage: wgpu::TextureUsages::TEXTURE_BINDING
                    | wgpu::TextureUsages::COPY_SRC
                    | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            })
        })
    }

    /// Makes room for all bricks. Returns the texture if it is a new one, with the old one's contents.
    pub(super) fn reserve(
        &mut self,
        gpu: &Gpu,
        levels: &Levels,
        old: &wgpu::Texture,
    ) -> Result<Option<wgpu::Texture>, GpuError> {
        let needed = self.depth_for(gpu, levels)?;
        if needed <= self.size[2] {
            return Ok(None);
        }
        let with_room = (needed + needed / 4).min(self.usual_depth);
        self.size[2] = needed.max(with_room);
        let texture = self.texture(gpu, levels)?;
        gpu.with_error_scope(|| {
            let mut encoder = gpu
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let whole = old.size();
            encoder.copy_texture_to_texture(old.as_image_copy(), texture.as_image_copy(), whole);
            gpu.submit(encoder);
        })?;
        Ok(Some(texture))
    }

    /// Uploads bricks that changed.
    pub(crate) fn upload(
        &self,
        gpu: &Gpu,
        levels: &Levels,
        changed: &BrickChanges,
        texture: &wgpu::Texture,
    ) -> Result<(), GpuError> {
        let samples = levels.pool().bytes();
        let format = format_for(gpu, levels);
        let bytes = format.bits().bytes();
        let line = SIDE as usize * bytes;
        let brick_bytes = (SIDE as usize).pow(3) * bytes;
        let [width, height, _] = self.size;
        let (mut staged, mut sent) = (Vec::new(), 0);
        let mut rest = &changed.bricks[..];
        while let Some(&first) = rest.first() {
            // Neighbors in a row of the pool go together.
            let limit = (width - first % width) as usize;
            let follows = |(index, brick): &(usize, &u32)| **brick == first + *index as u32;
            let count = rest
                .iter()
                .enumerate()
                .take(limit)
                .take_while(follows)
                .count();
            rest = &rest[count..];
            staged.resize(count * brick_bytes, 0);
            for index in 0..count {
                let brick_samples =
                    &samples[(first as usize + index) * brick_bytes..][..brick_bytes];
                for (row, row_samples) in brick_samples.chunks_exact(line).enumerate() {
                    let to = (row * count + index) * line;
                    staged[to..to + line].copy_from_slice(row_samples);
                }
            }
            let columns = count as u32 * SIDE;
            gpu.with_error_scope(|| {
                gpu.queue.write_texture(
                    wgpu::TexelCopyTextureInfo {
                        texture,
                        mip_level: 0,
                        origin: wgpu::Origin3d {
                            x: first % width * SIDE,
                            y: first / width % height * SIDE,
                            z: first / width / height * SIDE,
                        },
                        aspect: wgpu::TextureAspect::All,
                    },
                    &format.texels_of(&staged),
                    wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(columns * format.bytes() as u32),
                        rows_per_image: Some(SIDE),
                    },
                    extent(columns, SIDE, SIDE),
                );
            })?;
            sent += staged.len() as u64;
            if sent > STAGING_BYTES {
                gpu.flush()?;
                sent = 0;
            }
        }
        Ok(())
    }

    /// Downloads all bricks.
    pub(super) async fn read(
        &self,
        gpu: &Gpu,
        levels: &Levels,
        texture: &wgpu::Texture,
    ) -> Result<Texels, GpuError> {
        let bits = format_for(gpu, levels).bits();
        let [width, height, depth] = self.size;
        let line = SIDE as usize * bits.bytes();
        let count = levels.pool().bytes().len() / ((SIDE as usize).pow(3) * bits.bytes());
        let mut bricks = Vec::with_capacity(levels.pool().bytes().len());
        let across = [width * SIDE, height * SIDE];
        for layer in 0..depth {
            let range = layer * SIDE..(layer + 1) * SIDE;
            let texels = TexelFormat::of(texture.format());
            let all = read_texels(gpu, texture, 0, texels, across, range).await?;
            let first = (layer * width * height) as usize;
            for brick in first..count.min(first + (width * height) as usize) {
                let index = brick - first;
                let (x, y) = (index % width as usize, index / width as usize);
                for row in 0..(SIDE * SIDE) as usize {
                    let (j, k) = (row % SIDE as usize, row / SIDE as usize);
                    let at = (k * height as usize * SIDE as usize + y * SIDE as usize + j)
                        * width as usize
                        + x;
                    bricks.extend_from_slice(&all[at * line..][..line]);
                }
            }
        }
        Texels::from_bytes(bits, bricks).ok_or_else(|| GpuError::Lost("half a texel".into()))
    }
}

/// Returns the format of the texture. Shaders never write it, so 8 bits need no wider format.
fn format_for(gpu: &Gpu, levels: &Levels) -> TexelFormat {
    match levels.layout().level(0).encoding().format {
        SampleFormat::Snorm8 => TexelFormat::Plain(SampleFormat::Snorm8),
        bits => gpu.texels(bits),
    }
}

/// Returns a brick's position in the pool, ten bits per axis, as the device's words hold it.
pub(crate) fn packed(word: u32, [x, y, _]: [u32; 3]) -> u32 {
    if is_brick(word) && word != MISSING_BRICK {
        (word % x) | ((word / x % y) << 10) | ((word / x / y) << 20)
    } else {
        word
    }
}

/// Returns a brick's index in the pool.
pub(super) fn unpacked(word: u32, [x, y, _]: [u32; 3]) -> u32 {
    if is_brick(word) && word != MISSING_BRICK {
        (word & 1023) + x * (((word >> 10) & 1023) + y * (word >> 20))
    } else {
        word
    }
}
