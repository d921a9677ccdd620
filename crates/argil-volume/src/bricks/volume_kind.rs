//! Sparse bricks as a kind of volume, and in files.

use super::cell::{center_of, is_block_empty};
use crate::{
    BLOCK_SIDE, BlockTable, BrickInfo, BrickLayout, BrickPendingEdits, BrickSettings, Bricks,
    BricksError, EditStats, Encoding, FAR_SLOTS, FilePart, FileReader, MAX_VOXEL_INDEX,
    PendingEdits, RESOLUTION_RANGE, Section, VolumeError, VolumeInfo, VolumeKind, VoxelGrid,
};
use argil_abi::GpuMaterial;
use argil_field::IncrementalProgram;
use glam::{IVec3, UVec3, Vec3};
use rustc_hash::FxHashSet;
use std::cmp::Reverse;
use web_time::Instant;

/// Blocks along the side of the largest empty cube that a file can have.
const MAX_CUBE: i32 = 1 << 21;

impl VolumeKind for Bricks {
    const KIND: u32 = 3;

    fn voxel_grid(&self) -> &VoxelGrid {
        &self.layout().voxel_grid
    }

    fn encoding(&self) -> &Encoding {
        &self.layout().encoding
    }

    fn memory_bytes(&self) -> u64 {
        Bricks::memory_bytes(self)
    }

    fn info(&self) -> VolumeInfo {
        VolumeInfo {
            bricks: Some(BrickInfo {
                layout: *self.layout(),
                bricks: self.len() as u64,
            }),
            ..VolumeInfo::new(*self.voxel_grid(), *self.encoding(), self.memory_bytes())
        }
    }

    fn distance_in(&self, point: Vec3) -> Option<(f32, bool)> {
        Some((self.distance(point), self.has_brick(point)))
    }

    fn material_at(
        &self,
        point: Vec3,
        outward: Vec3,
        palette: &[GpuMaterial],
    ) -> Option<GpuMaterial> {
        self.material(point, outward, palette)
    }

    fn set_clipped(&mut self, is_cut: bool) {
        Bricks::set_cut(self, is_cut);
    }

    fn edits(&self) -> Option<Box<dyn PendingEdits>> {
        Some(Box::new(BrickPendingEdits::of(*self.layout())))
    }

    fn grow(&mut self, edits: &dyn PendingEdits) {
        if let Some(edits) = BrickPendingEdits::downcast_ref(edits) {
            Bricks::grow(self, edits.layout);
        }
    }

    fn edit(
        &mut self,
        live: &IncrementalProgram,
        edits: &mut dyn PendingEdits,
        budget: Option<u64>,
        until: Option<Instant>,
    ) -> Result<EditStats, BricksError> {
        match BrickPendingEdits::downcast_mut(edits) {
            Some(edits) => Bricks::edit(self, live, &mut edits.queue, budget, until),
            None => Ok(EditStats::default()),
        }
    }

    fn file_parts(&self) -> FilePart<'_> {
        // Without the far slots.
        let (mut blocks, mut inside) = (Vec::new(), Vec::new());
        let mut cells: Vec<u8> = Vec::new();
        for (slot, block) in self.table().blocks() {
            blocks.extend(block.to_array());
            cells.extend_from_slice(bytemuck::cast_slice(
                &self.words()[64 * slot..64 * (slot + 1)],
            ));
        }
        self.table().for_each_far_inside(|low, high| {
            inside.extend(low.to_array());
            inside.push(high.x - low.x);
        });
        let signed = |words: &[i32]| bytemuck::cast_slice(words).to_vec().into();
        FilePart {
            kind_parameters: [
                1,
                self.layout().brick_size_voxels,
                self.lipschitz().to_bits(),
            ],
            sections: vec![
                (Section::Blocks, signed(&blocks)),
                (Section::FarInside, signed(&inside)),
                (Section::Cells, cells.into()),
                (
                    Section::Materials,
                    bytemuck::cast_slice(self.materials()).into(),
                ),
                (
                    Section::MixedMaterials,
                    bytemuck::cast_slice(self.mixed()).into(),
                ),
                (Section::Texels(0), self.pool().bytes().into()),
            ],
        }
    }

    fn fits_file(voxel_grid: &VoxelGrid, version: u32) -> bool {
        if version == 1 {
            return RESOLUTION_RANGE.contains(&voxel_grid.size.max_element())
                && voxel_grid.begin == IVec3::ZERO;
        }
        let begin = voxel_grid.begin.to_array().map(i64::from);
        begin
            .iter()
            .zip(voxel_grid.size.to_array())
            .all(|(first, size)| {
                let farthest = i64::from(MAX_VOXEL_INDEX);
                *first >= -farthest && first + i64::from(size) <= farthest
            })
    }

    fn from_file(
        file: &FileReader<'_>,
        voxel_grid: VoxelGrid,
        encoding: Encoding,
        [_, brick, lipschitz]: [u32; 3],
    ) -> Result<Self, VolumeError> {
        let layout = BrickLayout::new(
            voxel_grid,
            &BrickSettings {
                encoding,
                brick_size_voxels: brick,
            },
        )
        .map_err(|e| file.fault(Section::Description, &e.to_string()))?;
        let pool = file.samples(encoding.format, layout.brick_bytes())?;
        let mixed = file.words(Section::MixedMaterials)?;
        if !mixed.len().is_multiple_of(2) {
            return Err(file.fault(
                Section::MixedMaterials,
                "its length is not a multiple of a material",
            ));
        }
        let mixed = mixed.as_chunks::<2>().0.to_vec();
        let cells = file.words(Section::Cells)?;
        let blocks = if file.version() == 1 {
            all_blocks(&layout, &cells).ok_or_else(|| {
                file.fault(Section::Cells, "there are not as many as the volume has")
            })?
        } else {
            blocks_of(file, &layout, &cells)?
        };
        Bricks::from_parts(
            layout,
            f32::from_bits(lipschitz),
            blocks,
            (file.words(Section::Materials)?, mixed),
            pool,
        )
        .map_err(|reason| file.fault(Section::Cells, reason))
    }
}

/// Returns the table of blocks, and the words of its slots.
fn blocks_of(
    file: &FileReader<'_>,
    layout: &BrickLayout,
    cells: &[u32],
) -> Result<(BlockTable, Vec<u32>), VolumeError> {
    let blocks = file.signed(Section::Blocks)?;
    let (blocks, rest) = blocks.as_chunks::<3>();
    if !rest.is_empty() || cells.len() != 64 * blocks.len() {
        return Err(file.fault(Section::Blocks, "there are not as many as cells"));
    }
    let farthest = MAX_VOXEL_INDEX / (layout.brick_size_voxels * BLOCK_SIDE) as i32 + 1;
    let is_near = |c: &i32| (-farthest..=farthest).contains(c);
    let [low, high] = layout.block_range();
    let (mut first, mut last) = (low, high);
    for block in blocks {
        if !block.iter().all(is_near) {
            return Err(file.fault(Section::Blocks, "a block that cannot be"));
        }
        let at = IVec3::from_array(*block);
        (first, last) = (first.min(at), last.max(at + 1));
    }
    let mut table = BlockTable::new(first, last);
    // What a file takes in memory is limited by its size.
    let check = |table: &BlockTable, section| match table.memory_bytes() <= file.max_memory_bytes()
    {
        true => Ok(()),
        false => Err(file.fault(section, "the table would be too large for the file")),
    };
    check(&table, Section::Blocks)?;
    for [x, y, z, side] in far_inside(file, &is_near)? {
        let first = IVec3::new(x, y, z);
        table.set_far(first, first + side, true);
        check(&table, Section::FarInside)?;
    }
    let mut words = vec![0; FAR_SLOTS as usize * 64];
    for (block, own) in blocks.iter().zip(cells.as_chunks::<64>().0) {
        let at = IVec3::from_array(*block);
        if table.find(at).is_some() {
            return Err(file.fault(Section::Blocks, "a duplicate block"));
        }
        table.insert(at);
        check(&table, Section::Blocks)?;
        words.extend(own);
    }
    Ok((table, words))
}

/// Returns the empty cubes inside the solid: their first blocks and their sides.
fn far_inside(
    file: &FileReader<'_>,
    is_near: &impl Fn(&i32) -> bool,
) -> Result<Vec<[i32; 4]>, VolumeError> {
    let fault = |reason| file.fault(Section::FarInside, reason);
    let cubes = file.signed(Section::FarInside)?;
    let (cubes, rest) = cubes.as_chunks::<4>();
    let mut cubes = cubes.to_vec();
    // Those that could contain others come first.
    cubes.sort_unstable_by_key(|&[x, y, z, side]| (Reverse(side), x, y, z));
    let mut known = FxHashSet::default();
    for &[x, y, z, side] in &cubes {
        let first = IVec3::new(x, y, z);
        let is_cube = |side: i32| {
            (1..=MAX_CUBE).contains(&side)
                && side.ilog2().is_multiple_of(3)
                && side.count_ones() == 1
        };
        if !rest.is_empty()
            || !is_cube(side)
            || ![x, y, z].iter().all(is_near)
            || first.rem_euclid(IVec3::splat(side)) != IVec3::ZERO
        {
            return Err(fault("a cube that cannot be"));
        }
        let mut around = side;
        while around <= MAX_CUBE {
            let corner = first.div_euclid(IVec3::splat(around)) * around;
            if known.contains(&(corner, around)) {
                return Err(fault("two cubes overlap"));
            }
            around *= 8;
        }
        known.insert((first, side));
    }
    Ok(cubes)
}

/// Returns the table of blocks for files of version 1, which store the words of all blocks in the box. Far blocks
/// are omitted.
fn all_blocks(layout: &BrickLayout, cells: &[u32]) -> Option<(BlockTable, Vec<u32>)> {
    let [low, high] = layout.block_range();
    let size = (high - low).as_uvec3();
    let count = size
        .to_array()
        .map(|n| n as usize)
        .iter()
        .product::<usize>();
    if cells.len() != 64 * count {
        return None;
    }
    let mut table = BlockTable::new(low, high);
    let mut words = vec![0; FAR_SLOTS as usize * 64];
    let far = 0.999 * layout.far_length();
    for (at, own) in (0u32..).zip(cells.as_chunks::<64>().0) {
        let place = UVec3::new(at % size.x, at / size.x % size.y, at / size.x / size.y);
        let block = low + place.as_ivec3();
        let center = center_of(own[0]);
        let is_far = |&w: &u32| is_block_empty(w) && w >> 31 != 0 && center_of(w).abs() >= far;
        if own.iter().all(is_far) {
            table.set_far(block, block + 1, center < 0.0);
        } else {
            table.insert(block);
            words.extend(own);
        }
    }
    Some((table, words))
}
