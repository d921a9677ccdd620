//! The levels of light on the device, as two textures: their tables, as words, and their bricks.
//!
//! *Practice.* Textures, because the tables of bricks and of the field already use all buffers that a shader may have. The
//! CPU bakes the levels, and all of them are uploaded when they changed.

use crate::bindings::{LIGHT_STORED, LIGHT_WORDS};
use crate::levels::{LevelPool, packed};
use crate::resources::extent;
use crate::trace_mode::BoundResource;
use crate::{Gpu, GpuError};
use argil_abi::{LIGHT_HEAD, LIGHT_ROW, RECORD_WORDS};
use argil_volume::{BrickChanges, Levels, SampleFormat};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

/// The levels of light of sparse bricks.
#[derive(Debug)]
pub(crate) struct GpuLight {
    state: Mutex<LightTextures>,
}

#[derive(Debug)]
struct LightTextures {
    /// What was uploaded. It is not held, so that edits can change it in place.
    levels: Weak<Levels>,
    words: wgpu::TextureView,
    stored: wgpu::TextureView,
    bytes: u64,
}

impl GpuLight {
    /// Creates textures without levels.
    pub(super) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let state = Mutex::new(LightTextures::empty(gpu)?);
        Ok(Self { state })
    }

    fn lock(&self) -> MutexGuard<'_, LightTextures> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Uploads levels, unless they are those that the device has. Without levels, light reads what bricks store.
    pub(super) fn set(&self, gpu: &Gpu, levels: Option<&Arc<Levels>>) -> Result<(), GpuError> {
        let wanted = levels.map_or_else(Weak::new, Arc::downgrade);
        let mut state = self.lock();
        if !Weak::ptr_eq(&state.levels, &wanted) {
            // The old ones go first.
            *state = LightTextures::empty(gpu)?;
            if let Some(levels) = levels {
                *state = LightTextures::of(gpu, levels)?;
            }
        }
        Ok(())
    }

    /// Adds the bindings.
    pub(super) fn bind(&self, bound: &mut Vec<BoundResource>) {
        let state = self.lock();
        bound.push(BoundResource::View(LIGHT_WORDS, state.words.clone()));
        bound.push(BoundResource::View(LIGHT_STORED, state.stored.clone()));
    }

    /// Returns the bytes on the device.
    pub(super) fn memory_bytes(&self) -> u64 {
        self.lock().bytes
    }
}

impl LightTextures {
    /// Creates textures without levels.
    fn empty(gpu: &Gpu) -> Result<Self, GpuError> {
        let words = words_texture(gpu, &[0])?;
        let format = gpu.texels(SampleFormat::Snorm16).format();
        let stored = gpu.with_error_scope(|| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("no light"),
                size: extent(1, 1, 1),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D3,
                format,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        })?;
        Ok(Self {
            levels: Weak::new(),
            words: view(&words),
            stored: view(&stored),
            bytes: 0,
        })
    }

    /// Uploads levels.
    fn of(gpu: &Gpu, levels: &Arc<Levels>) -> Result<Self, GpuError> {
        let (pool, stored) = LevelPool::new(gpu, levels)?;
        let all = BrickChanges {
            bricks: (0..levels.brick_count() as u32).collect(),
            ..BrickChanges::default()
        };
        pool.upload(gpu, levels, &all, &stored)?;
        let tables = tables_of(levels, pool.size());
        let words = words_texture(gpu, &tables)?;
        let bricks: u64 = pool.size().map(u64::from).iter().product();
        Ok(Self {
            bytes: 4 * tables.len() as u64 + bricks * levels.layout().level(0).brick_bytes(),
            levels: Arc::downgrade(levels),
            words: view(&words),
            stored: view(&stored),
        })
    }
}

fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Returns the tables of levels: the head, the slots of the coarsest pages, and a record for each page.
fn tables_of(levels: &Levels, pool: [u32; 3]) -> Vec<u32> {
    let layout = levels.layout();
    let finest = layout.level(0);
    let grid = &finest.voxel_grid();
    let (low, size, roots) = levels.roots();
    let (first, last) = levels.voxel_range();
    let band = finest.encoding().band_width(grid, 0) / grid.voxel_size;
    let mut all = vec![1, layout.root(), grid.voxel_size.to_bits(), band.to_bits()];
    for corner in [low, size, first, last] {
        all.extend(corner.to_array().map(|c| c as u32));
    }
    all.push(LIGHT_HEAD + roots.len() as u32);
    all.resize(LIGHT_HEAD as usize, 0);
    all.extend_from_slice(roots);
    let mut record = [0; RECORD_WORDS as usize];
    for (slot, page) in levels.pages().iter().enumerate() {
        let cells = 8 * slot..8 * slot + 8;
        record[..3].copy_from_slice(&page.origin.map(|c| c as u32));
        (record[3], record[4]) = (page.level, page.parent);
        let words = &levels.words()[cells.clone()];
        for (to, &word) in record[8..16].iter_mut().zip(words) {
            *to = packed(word, pool);
        }
        record[16..].copy_from_slice(&levels.children()[cells]);
        all.extend_from_slice(&record);
    }
    all
}

/// Creates a texture of words.
fn words_texture(gpu: &Gpu, words: &[u32]) -> Result<wgpu::Texture, GpuError> {
    let rows = (words.len() as u32).div_ceil(LIGHT_ROW).max(1);
    let limit = gpu.device.limits().max_texture_dimension_2d;
    if rows > limit {
        return Err(GpuError::Lost(format!(
            "light has {rows} rows of tables, and this device allows {limit}"
        )));
    }
    let mut padded = words.to_vec();
    padded.resize((rows * LIGHT_ROW) as usize, 0);
    gpu.with_error_scope(|| {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("tables of light"),
            size: extent(LIGHT_ROW, rows, 1),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R32Uint,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        gpu.queue.write_texture(
            texture.as_image_copy(),
            bytemuck::cast_slice(&padded),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * LIGHT_ROW),
                rows_per_image: Some(rows),
            },
            extent(LIGHT_ROW, rows, 1),
        );
        texture
    })
}
