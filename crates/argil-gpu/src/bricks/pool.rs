//! The pool on the device: its texture and its free slots.
//!
//! *Practice.* The device takes bricks and returns them. A stack of free slots is behind its counters. The CPU
//! knows an upper bound on the number of bricks: the last counters that it read, plus one brick per cell that edits
//! can have sampled since. So it makes room before an edit is submitted, and nobody waits. After each edit, the
//! counters are copied to a staging buffer, which is read when its mapping completes.

use super::build_tables::BrickTargets;
use super::passes::BrickPasses;
use super::tables::{BrickTables, PLACES, bytes_of, pool_for, pool_texture};
use crate::pass_recorder::PassRecorder;
use crate::storage_buffer::StorageBuffer;
use crate::{GpuError, GpuProgram};
use argil_abi as abi;

/// Returns an eighth more than needed, so that not every edit moves the pool.
fn with_headroom(needed: u64) -> u64 {
    needed + needed / 8 + 64
}

impl BrickTables {
    /// Encodes how room is made for more bricks, and mixed ones. Returns the pool's texture if it was moved.
    ///
    /// # Errors
    /// If they would exceed `budget` bytes, or the texture's limits. Nothing changes then.
    pub(super) fn make_room(
        &mut self,
        field: &GpuProgram,
        (texture, recorder): (&wgpu::Texture, &mut PassRecorder<'_>),
        more: [u64; 2],
        mixes: bool,
        budget: u64,
    ) -> Result<Option<wgpu::Texture>, GpuError> {
        let gpu = field.gpu();
        let most = self.accounting.upper_bound();
        let [bricks, mixed] = [0, 1].map(|i| most[i] + more[i]);
        let mixed = if mixes { mixed } else { 0 };
        let capacity: u64 = self.pool.map(u64::from).iter().product();
        if bricks <= capacity && mixed <= self.mixed && self.has_stack() {
            return Ok(None);
        }
        let fit = |bricks: u64, mixed: u64| {
            let pool = pool_for(gpu, &self.layout, bricks.max(capacity))?;
            let mixed = mixed.max(self.mixed);
            let needed = bytes_of(gpu, &self.layout, &self.cells, pool, mixed);
            Ok::<_, GpuError>((pool, mixed, needed))
        };
        let (air, mixed_air) = (
            with_headroom(bricks),
            if mixes { with_headroom(mixed) } else { 0 },
        );
        let (mut pool, mut mixed_room, mut needed) = fit(air, mixed_air)?;
        if needed > budget {
            (pool, mixed_room, needed) = fit(bricks, mixed)?;
        }
        if needed > budget {
            return Err(GpuError::Budget {
                bricks,
                needed,
                budget,
            });
        }
        self.resize(field, (texture, recorder), pool, mixed_room)
            .map(Some)
    }

    /// Whether there is room for a stack of free slots.
    fn has_stack(&self) -> bool {
        let capacity: u64 = self.pool.map(u64::from).iter().product();
        let with_stack = 4 * (u64::from(abi::COUNTERS) + capacity + self.mixed);
        self.accounting.counters.size() >= with_stack
    }

    /// Returns a pool with room for exactly these numbers of bricks and mixed ones: its texture.
    pub(super) fn fit(
        &mut self,
        field: &GpuProgram,
        texture: &wgpu::Texture,
        bricks: u64,
        mixed: u64,
    ) -> Result<wgpu::Texture, GpuError> {
        let pool = pool_for(field.gpu(), &self.layout, bricks)?;
        if (pool, mixed) == (self.pool, self.mixed) && self.has_stack() {
            return Ok(texture.clone());
        }
        let mut recorder = PassRecorder::untimed(field.gpu(), None);
        let moved = self.resize(field, (texture, &mut recorder), pool, mixed)?;
        recorder.submit()?;
        Ok(moved)
    }

    /// Fits the pool only if it has much unused room. Otherwise it shrinks the materials of mixed bricks alone.
    pub(super) fn fit_closely(
        &mut self,
        field: &GpuProgram,
        texture: &wgpu::Texture,
        bricks: u64,
        mixed: u64,
    ) -> Result<wgpu::Texture, GpuError> {
        let capacity: u64 = self.pool.map(u64::from).iter().product();
        if capacity > with_headroom(bricks) {
            return self.fit(field, texture, bricks, mixed);
        }
        let gpu = field.gpu();
        let mut materials = StorageBuffer::new("bricks' materials");
        let bytes = 4 * capacity + 8 * PLACES * mixed;
        materials.reserve_exact(gpu, bytes)?;
        gpu.with_error_scope(|| {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            if let (Some(from), Some(to)) = (self.materials.buffer(), materials.buffer()) {
                encoder.copy_buffer_to_buffer(from, 0, to, 0, bytes);
            }
            gpu.submit(encoder);
        })?;
        (self.materials, self.mixed) = (materials, mixed);
        Ok(texture.clone())
    }

    /// Encodes how everything moves to another pool, without gaps.
    fn resize(
        &mut self,
        field: &GpuProgram,
        (texture, recorder): (&wgpu::Texture, &mut PassRecorder<'_>),
        pool: [u32; 3],
        mixed: u64,
    ) -> Result<wgpu::Texture, GpuError> {
        let gpu = field.gpu();
        let passes = BrickPasses::of(
            field,
            self.layout.encoding().format,
            self.layout.brick_size_voxels(),
        )?;
        let capacity: u64 = pool.map(u64::from).iter().product();
        let moved = pool_texture(gpu, &self.layout, pool)?;
        let mut materials = StorageBuffer::new("bricks' materials");
        materials.reserve_exact(gpu, 4 * capacity + 8 * PLACES * mixed)?;
        let mut counters = StorageBuffer::new("counters");
        let head = 4 * u64::from(abi::COUNTERS);
        counters.reserve_exact(gpu, head + 4 * (capacity + mixed))?;
        // The totals continue.
        if let (Some(from), Some(to)) = (self.accounting.counters.buffer(), counters.buffer()) {
            let first = 4 * u64::from(abi::COUNTER_FILLED);
            let encoder = recorder.encoder();
            encoder.copy_buffer_to_buffer(from, first, to, first, head - first);
        }
        let old = BrickTargets {
            texture,
            cells: &self.cells.buffer,
            materials: &self.materials,
            counters: &self.accounting.counters,
        };
        let new = BrickTargets {
            texture: &moved,
            cells: &self.cells.buffer,
            materials: &materials,
            counters: &counters,
        };
        passes.repack.encode(
            gpu,
            recorder.encoder(),
            (&self.layout, &self.cells),
            [self.pool, pool],
            &old,
            &new,
        )?;
        (self.pool, self.mixed, self.materials) = (pool, mixed, materials);
        self.accounting.counters = counters;
        Ok(moved)
    }
}
