//! What the CPU knows about the pool on the device, without waiting.

use crate::pass_recorder::PassRecorder;
use crate::resources::read_table;
use crate::storage_buffer::StorageBuffer;
use crate::{Gpu, GpuError};
use argil_abi as abi;
use argil_volume::EditStats;
use std::sync::{Arc, OnceLock};

/// The device's counters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct BrickCounts([u32; abi::COUNTERS as usize]);

impl BrickCounts {
    fn of(bytes: &[u8]) -> Self {
        let mut counted = Self::default();
        for (to, from) in counted.0.iter_mut().zip(bytes.chunks_exact(4)) {
            *to = bytemuck::pod_read_unaligned(from);
        }
        counted
    }

    pub(super) fn get(&self, counter: u32) -> u64 {
        u64::from(self.0[counter as usize])
    }

    /// Returns the number of bricks.
    pub(super) fn bricks(&self) -> u64 {
        self.get(abi::COUNTER_HIGH_WATER)
            .saturating_sub(self.get(abi::COUNTER_FREE))
    }

    /// Returns the number of mixed bricks.
    pub(super) fn mixed(&self) -> u64 {
        self.get(abi::COUNTER_HIGH_WATER_MIXED)
            .saturating_sub(self.get(abi::COUNTER_FREE_MIXED))
    }

    /// Returns what edits did since an earlier state.
    pub(super) fn since(&self, before: &Self) -> EditStats {
        let count = |counter: u32| {
            let now = self.0[counter as usize];
            u64::from(now.wrapping_sub(before.0[counter as usize]))
        };
        EditStats {
            filled: count(abi::COUNTER_FILLED),
            added: count(abi::COUNTER_ADDED),
            removed: count(abi::COUNTER_REMOVED),
            cells: 0,
        }
    }
}

/// Counters on their way to the CPU.
#[derive(Debug)]
struct PendingReadback {
    buffer: wgpu::Buffer,
    arrived: Arc<OnceLock<Result<(), wgpu::BufferAsyncError>>>,
    /// Bricks, and mixed ones, that later edits can have taken.
    since: [u64; 2],
}

/// What the CPU knows about the counters.
#[derive(Debug)]
pub(super) struct PoolAccounting {
    pub counters: StorageBuffer,
    /// The counters when they were last read.
    pub known: BrickCounts,
    /// The counters when edits were last reported.
    told: BrickCounts,
    /// Bricks, and mixed ones, that edits can have taken since.
    since: [u64; 2],
    letter: Option<PendingReadback>,
    /// The buffer of the last one that arrived.
    spare: Option<wgpu::Buffer>,
}

impl PoolAccounting {
    /// Creates the counters of a pool with these numbers of bricks and mixed bricks, all in use.
    pub(super) fn new(gpu: &Gpu, bricks: u64, mixed: u64) -> Result<Self, GpuError> {
        let mut known = BrickCounts::default();
        known.0[abi::COUNTER_HIGH_WATER as usize] = bricks as u32;
        known.0[abi::COUNTER_HIGH_WATER_MIXED as usize] = mixed as u32;
        let mut counters = StorageBuffer::new("counters");
        // No larger: a buffer with a stack is longer.
        counters.reserve_exact(gpu, size_of_val(&known.0) as u64)?;
        counters.rewrite(gpu, &known.0);
        Ok(Self {
            counters,
            known,
            told: known,
            since: [0; 2],
            letter: None,
            spare: None,
        })
    }

    /// Makes room for a stack of free slots. The counters continue.
    pub(super) fn reserve_stack(&mut self, gpu: &Gpu, slots: u64) -> Result<(), GpuError> {
        let mut counters = StorageBuffer::new("counters");
        let head = 4 * u64::from(abi::COUNTERS);
        counters.reserve_exact(gpu, head + 4 * slots)?;
        gpu.with_error_scope(|| {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            if let (Some(from), Some(to)) = (self.counters.buffer(), counters.buffer()) {
                encoder.copy_buffer_to_buffer(from, 0, to, 0, head);
            }
            gpu.submit(encoder);
        })?;
        self.counters = counters;
        Ok(())
    }

    /// Downloads the current counters.
    pub(super) async fn read(&self, gpu: &Gpu) -> Result<BrickCounts, GpuError> {
        let bytes = 4 * u64::from(abi::COUNTERS);
        Ok(BrickCounts::of(
            &read_table(gpu, &self.counters, bytes).await?,
        ))
    }

    /// Waits for the current counters. Returns what edits did since they were last reported.
    pub(super) async fn wait_for_counters(&mut self, gpu: &Gpu) -> Result<EditStats, GpuError> {
        self.take_known(gpu).await?;
        let edit = self.known.since(&self.told);
        self.told = self.known;
        Ok(edit)
    }

    /// Waits for the current counters, without reporting them.
    pub(super) async fn take_known(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        self.known = self.read(gpu).await?;
        self.since = [0; 2];
        self.close_letter(gpu)
    }

    /// Keeps the buffer of counters that are on their way, or have arrived.
    fn close_letter(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        // A host may still submit what maps a buffer that has not arrived.
        if let Some(letter) = self.letter.take()
            && letter.arrived.get().is_some()
        {
            gpu.with_error_scope(|| letter.buffer.unmap())?;
            self.spare = Some(letter.buffer);
        }
        Ok(())
    }

    /// Records that an edit can take these numbers of bricks and mixed ones, requests the counters, and submits the edit unless a
    /// host does.
    pub(super) fn record_upper_bound(
        &mut self,
        gpu: &Gpu,
        taken: [u64; 2],
        recorder: &mut PassRecorder<'_>,
    ) -> Result<(), GpuError> {
        let add = |to: &mut [u64; 2]| to.iter_mut().zip(taken).for_each(|(to, more)| *to += more);
        add(&mut self.since);
        if let Some(letter) = &mut self.letter {
            add(&mut letter.since);
            return recorder.submit();
        }
        let Some(counters) = self.counters.buffer() else {
            return recorder.submit();
        };
        let bytes = 4 * u64::from(abi::COUNTERS);
        let buffer = match self.spare.take() {
            Some(buffer) => buffer,
            None => gpu.with_error_scope(|| {
                gpu.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("counters"),
                    size: bytes,
                    usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                })
            })?,
        };
        let arrived = Arc::new(OnceLock::new());
        let note = arrived.clone();
        let arrive = move |result| {
            // It is called once.
            let _ = note.set(result);
        };
        let encoder = recorder.encoder();
        encoder.copy_buffer_to_buffer(counters, 0, &buffer, 0, bytes);
        encoder.map_buffer_on_submit(&buffer, wgpu::MapMode::Read, .., arrive);
        self.letter = Some(PendingReadback {
            buffer,
            arrived,
            since: [0; 2],
        });
        recorder.submit()
    }

    /// Reads the counters if they have arrived, without waiting.
    pub(super) fn poll_counters(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        let lost = |reason: String| GpuError::Lost(reason);
        let polled = gpu.device.poll(wgpu::PollType::Poll);
        polled.map_err(|e| lost(e.to_string()))?;
        let Some(letter) = &self.letter else {
            return Ok(());
        };
        let Some(result) = letter.arrived.get() else {
            return Ok(());
        };
        result.clone().map_err(|e| lost(e.to_string()))?;
        let view = letter.buffer.slice(..).get_mapped_range();
        self.known = BrickCounts::of(&view.map_err(|e| lost(e.to_string()))?);
        self.since = letter.since;
        self.close_letter(gpu)
    }

    /// Returns upper bounds on the numbers of bricks and mixed bricks.
    pub(super) fn upper_bound(&self) -> [u64; 2] {
        let known = [self.known.bricks(), self.known.mixed()];
        [0, 1].map(|i| known[i] + self.since[i])
    }
}
