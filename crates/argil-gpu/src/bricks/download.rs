//! Downloads sparse bricks.

use super::tables::{BrickTables, PLACES};
use crate::resources::{STAGING_BYTES, read_table, read_texels};
use crate::{Gpu, GpuError};
use argil_abi as abi;
use argil_volume::{Bricks, SampleFormat, Texels, empty_word, is_brick};
use std::collections::BTreeSet;

fn unpacked(word: u32, [x, y, _]: [u32; 3]) -> u32 {
    if is_brick(word) {
        (word & 1023) + x * (((word >> 10) & 1023) + y * (word >> 20))
    } else {
        word
    }
}

/// Downloads bricks.
pub(super) async fn read(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    tables: &BrickTables,
) -> Result<Bricks, GpuError> {
    let measures = tables.layout;
    let side = (measures.brick_size_voxels() + 1) as usize;
    let bytes = measures.encoding().format.bytes();
    let [nx, ny, nz] = tables.pool;
    let (width, height) = (nx as usize * side, ny as usize * side);
    let layer_bytes = (width * height * side * bytes) as u64;
    let layers = (STAGING_BYTES / layer_bytes).clamp(1, u64::from(nz)) as u32;
    let counted = tables.accounting.read(gpu).await?;
    let mut words = tables.cells.read(gpu).await?;
    // The contents of a free slot are arbitrary.
    let mut is_there = vec![false; tables.cells.table.slots()];
    for (slot, _) in tables.cells.table.blocks() {
        is_there[slot] = true;
    }
    for (words, is_there) in words.chunks_exact_mut(64).zip(is_there) {
        for word in words {
            *word = if is_there || !is_brick(*word) {
                unpacked(*word, tables.pool)
            } else {
                empty_word(0.0)
            };
        }
    }
    // Edits leave gaps.
    let used: BTreeSet<u32> = words.iter().copied().filter(|&w| is_brick(w)).collect();
    let used: Vec<u32> = used.into_iter().collect();
    for word in words.iter_mut().filter(|word| is_brick(**word)) {
        let place = used.binary_search(word);
        *word = place.expect("the list was made of these words") as u32;
    }
    let mut samples = Vec::new();
    let top = counted.get(abi::COUNTER_HIGH_WATER);
    let wanted = top.max(1) as usize * side.pow(3) * bytes;
    for first in (0..nz).step_by(layers as usize) {
        if samples.len() >= wanted {
            break;
        }
        let count = layers.min(nz - first);
        let texels = read_texels(
            gpu,
            texture,
            0,
            gpu.texels(measures.encoding().format),
            [width as u32, height as u32],
            first * side as u32..(first + count) * side as u32,
        )
        .await?;
        for at in 0..(count * ny * nx) as usize {
            let (bx, by, bz) = (
                at % nx as usize,
                at / nx as usize % ny as usize,
                at / (nx * ny) as usize,
            );
            for row in 0..side * side {
                let (y, k) = (row % side, row / side);
                let from = (((bz * side + k) * height + by * side + y) * width + bx * side) * bytes;
                samples.extend_from_slice(&texels[from..from + side * bytes]);
            }
        }
    }
    let each = side.pow(3) * bytes;
    for (to, &from) in used.iter().enumerate() {
        let from = from as usize * each;
        samples.copy_within(from..from + each, to * each);
    }
    samples.truncate(used.len().max(1) * each);
    if used.is_empty() {
        samples.fill(0);
    }
    let bits: SampleFormat = measures.encoding().format;
    let pool = Texels::from_bytes(bits, samples).ok_or_else(|| odd("half a sample"))?;
    let materials = read_looks(gpu, tables, &used).await?;
    let cells = (tables.cells.table.clone(), words);
    Bricks::from_parts(measures, tables.lipschitz, cells, materials, pool).map_err(odd)
}

fn odd(reason: &str) -> GpuError {
    GpuError::Lost(format!("bricks came back wrong: {reason}"))
}

/// Downloads the materials of used bricks: each brick's, and those of mixed ones.
async fn read_looks(
    gpu: &Gpu,
    tables: &BrickTables,
    used: &[u32],
) -> Result<(Vec<u32>, Vec<[u32; 2]>), GpuError> {
    let capacity: u64 = tables.pool.map(u64::from).iter().product();
    let looks = read_table(
        gpu,
        &tables.materials,
        4 * capacity + 8 * PLACES * tables.mixed,
    )
    .await?;
    let mut looks: Vec<u32> = looks
        .chunks_exact(4)
        .map(bytemuck::pod_read_unaligned)
        .collect();
    let all_mixed = looks.split_off(capacity as usize);
    let all_mixed = all_mixed.as_chunks::<2>().0;
    let mut looks: Vec<u32> = used.iter().map(|&brick| looks[brick as usize]).collect();
    let block_of = |look: u32| (look & abi::BRICK_MIXED != 0).then_some(look & !abi::BRICK_MIXED);
    let blocks: BTreeSet<u32> = looks.iter().filter_map(|&look| block_of(look)).collect();
    let blocks: Vec<u32> = blocks.into_iter().collect();
    let mut mixed = Vec::new();
    for &block in &blocks {
        let from = block as usize * PLACES as usize;
        let materials = all_mixed.get(from..from + PLACES as usize);
        mixed.extend_from_slice(
            materials.ok_or_else(|| odd("a mixed brick's materials are not there"))?,
        );
    }
    for look in &mut looks {
        if let Some(block) = block_of(*look) {
            let place = blocks.binary_search(&block);
            *look = abi::BRICK_MIXED | place.expect("the list was made of these looks") as u32;
        }
    }
    Ok((looks, mixed))
}
