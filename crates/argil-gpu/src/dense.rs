//! `DenseFill`: samples a field into a texture.

use crate::bindings::{Bind, FILL, TEXELS, VOLUME_WGSL, entry};
use crate::pass_module::{PassModule, Passes};
use crate::pass_recorder::{DispatchSize, PassRecorder};
use crate::resources::{read_level, texture, uniform_of, upload};
use crate::texel_format::TexelFormat;
use crate::tile_source::TileSource;
use crate::trace_mode::{BoundResource, PathMode, TraceMode, VOLUME_BINDS};
use crate::volume::{ClipUpdate, Upload, VolumeStorage, VolumeTables};
use crate::work::Work;
use crate::{Gpu, GpuError, GpuProgram, GpuVolume, StageTimings};
use argil_abi::{DenseUniform, FillUniform, FrameUniform};
use argil_field::Program;
use argil_render::wgsl;
use argil_volume::{Dense, DenseFill, Encoding, Volume, VoxelGrid};
use glam::UVec3;
use std::borrow::Cow;

/// Maximum instructions times samples per dispatch.
pub(crate) const WORK_PER_DISPATCH: u64 = 4_000_000_000;
/// Samples along the side of a tile.
pub(crate) const TILE: u32 = 32;

/// A dense volume has only its texture.
#[derive(Debug)]
struct DenseTables {
    words: DenseUniform,
}

const DENSE_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: DenseUniform;
";

pub(crate) static DENSE: TraceMode = TraceMode {
    name: "dense",
    more_name: "dense with more light",
    march: wgsl::DENSE,
    tables: || [DENSE_WGSL, VOLUME_WGSL].concat(),
    binds: &VOLUME_BINDS,
    constants: &[],
    draws: false,
    is_exact: false,
    paths: Some(PathMode {
        name: "paths through dense",
        wgsl: wgsl::DENSE_PATHS,
        binds: &VOLUME_BINDS,
    }),
    host: None,
    has_cones: false,
    by_lists: false,
};

impl VolumeTables for DenseTables {
    fn way(&self) -> &'static TraceMode {
        &DENSE
    }

    fn memory_bytes(&self, body: &VolumeStorage) -> u64 {
        body.texture_bytes()
    }

    fn read<'a>(&'a self, body: &'a VolumeStorage, gpu: &'a Gpu) -> Work<'a, Volume> {
        Box::pin(async move {
            let (voxel_grid, encoding) = (body.voxel_grid, body.encoding);
            let mut levels = Vec::new();
            for level in 0..body.texture.mip_level_count() {
                let measures = (&voxel_grid, encoding.format);
                levels.push(read_level(gpu, &body.texture, measures, level).await?);
            }
            let dense = Dense::from_levels(voxel_grid, encoding, levels);
            Ok(Volume::Dense(dense.ok_or_else(GpuError::odd_volume)?))
        })
    }

    fn uniform(&self, _: &FrameUniform) -> Cow<'_, [u8]> {
        bytemuck::bytes_of(&self.words).into()
    }

    fn cut(&self) -> Option<ClipUpdate<'_>> {
        Some(ClipUpdate::Dense(&self.words))
    }
}

impl Upload for Dense {
    fn upload<'a>(&'a self, field: &'a GpuProgram) -> Work<'a, GpuVolume> {
        Box::pin(async move {
            let gpu = field.gpu();
            let (voxel_grid, encoding) = (*self.voxel_grid(), *self.encoding());
            let levels = self.levels().len() as u32;
            let texture = texture(gpu, &voxel_grid, encoding.format, levels)?;
            for (level, texels) in (0..).zip(self.levels()) {
                upload(gpu, &texture, &voxel_grid, level, texels).await?;
            }
            let words = dense_words(&voxel_grid, &encoding, levels);
            GpuVolume::new(
                field,
                (voxel_grid, encoding),
                texture,
                DenseTables { words },
            )
        })
    }
}

/// Returns the uniform of a dense volume.
pub(super) fn dense_words(
    voxel_grid: &VoxelGrid,
    encoding: &Encoding,
    levels: u32,
) -> DenseUniform {
    DenseUniform {
        corner: voxel_grid.corner.to_array(),
        band_width: encoding.band_width(voxel_grid, 0),
        extent: voxel_grid.extent().to_array(),
        voxel_size: voxel_grid.voxel_size,
        size_x: voxel_grid.size.x,
        size_y: voxel_grid.size.y,
        size_z: voxel_grid.size.z,
        levels,
        max_code: encoding.format.max_code(),
        ..DenseUniform::default()
    }
}

impl GpuVolume {
    /// Samples a field into a dense volume. Returns the volume and the timings.
    ///
    /// # Errors
    /// If the texture exceeds the device's limits or memory, or the device fails.
    pub async fn dense(
        field: &GpuProgram,
        program: &Program,
        voxel_grid: VoxelGrid,
        encoding: Encoding,
        mips: bool,
        way: DenseFill,
    ) -> Result<(Self, StageTimings), GpuError> {
        let gpu = field.gpu();
        let levels = Dense::level_count(program, &voxel_grid, &encoding, mips);
        let texture = texture(gpu, &voxel_grid, encoding.format, levels)?;
        let side = tile_side(gpu, TILE);
        let texels = gpu.texels(encoding.format);
        let samples = voxel_grid.size.to_array().map(u64::from);
        let tiles = field.tile_field(way == DenseFill::Tiled, samples.iter().product())?;
        let key =
            tiles
                .source
                .name_of(["dense fill", "dense fill by columns", "dense fill by lists"]);
        let passes = field.passes((key, texels.bits().bytes() as u32), || {
            Passes::new(gpu, fill_module(&tiles.source, texels, side))
        })?;
        let uniform = gpu.with_error_scope(|| uniform_of::<FillUniform>(gpu, "fill"))?;

        // Each level, in as many dispatches as its work takes.
        let mut recorder = PassRecorder::new(gpu)?;
        let filling = DenseFillPass {
            field,
            tables: &tiles.bound,
            layout: &passes.layout,
            uniform: &uniform,
            texture: &texture,
            pipeline: match way {
                DenseFill::Tiled => passes.get(gpu, "fill_tiled")?,
                DenseFill::Naive => passes.get(gpu, "fill_naive")?,
            },
            way,
        };
        for level in 0..levels {
            let size = voxel_grid.level_size(level);
            let fill = FillUniform {
                tile: TILE,
                ..encoding.fill_uniform(program, &voxel_grid, level)
            };
            filling.level(&mut recorder, level, size, fill).await?;
        }
        let stages = recorder.finish().await?;
        let words = dense_words(&voxel_grid, &encoding, levels);
        let volume = Self::new(
            field,
            (voxel_grid, encoding),
            texture,
            DenseTables { words },
        )?;
        Ok((volume, stages))
    }
}

/// What fills the levels of a dense volume.
struct DenseFillPass<'a> {
    field: &'a GpuProgram,
    /// The tables of the program.
    tables: &'a [BoundResource],
    layout: &'a wgpu::BindGroupLayout,
    uniform: &'a wgpu::Buffer,
    texture: &'a wgpu::Texture,
    pipeline: &'a wgpu::ComputePipeline,
    way: DenseFill,
}

impl DenseFillPass<'_> {
    async fn level(
        &self,
        recorder: &mut PassRecorder<'_>,
        level: u32,
        size: UVec3,
        fill: FillUniform,
    ) -> Result<(), GpuError> {
        let (field, gpu) = (self.field, self.field.gpu());
        let stage = if level == 0 { "fill" } else { "mips" };
        let view = self.texture.create_view(&wgpu::TextureViewDescriptor {
            base_mip_level: level,
            mip_level_count: Some(1),
            ..wgpu::TextureViewDescriptor::default()
        });
        let bind_group = gpu.with_error_scope(|| {
            let mut entries: Vec<_> = self.tables.iter().map(BoundResource::entry).collect();
            entries.push(entry(FILL, self.uniform));
            entries.push(wgpu::BindGroupEntry {
                binding: TEXELS,
                resource: wgpu::BindingResource::TextureView(&view),
            });
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("DenseFill"),
                layout: self.layout,
                entries: &entries,
            })
        })?;
        let layer = u64::from(size.x) * u64::from(size.y) * field.length() as u64;
        let dispatches: Vec<(u32, u32, [u32; 3])> = match self.way {
            DenseFill::Tiled => {
                let tiles = size.to_array().map(|n| n.div_ceil(TILE));
                let work = layer * u64::from(tiles[2]);
                let slabs = layers(field, work, TILE, tile_side(gpu, TILE));
                slabs.map(|(first, count)| (first, count, tiles)).collect()
            }
            DenseFill::Naive => {
                let count = (WORK_PER_DISPATCH / layer.max(1)).clamp(1, u64::from(size.z)) as u32;
                let slabs = (0..size.z).step_by(count as usize).map(|first| {
                    let groups = [size.x, size.y, count.min(size.z - first)];
                    (first, fill.layer_count, groups)
                });
                slabs.collect()
            }
        };
        for (first_layer, layer_count, groups) in dispatches {
            let fill = FillUniform {
                first_layer,
                layer_count,
                ..fill
            };
            gpu.write_buffer(self.uniform, 0, bytemuck::bytes_of(&fill));
            let groups = DispatchSize::Direct(groups);
            recorder
                .pass(stage, self.pipeline, &bind_group, groups)
                .await?;
        }
        Ok(())
    }
}

/// Describes the passes that fill a texture, with `side`² threads in a group.
pub(crate) fn fill_module(source: &TileSource, texels: TexelFormat, side: u32) -> PassModule {
    let [field, fill] = source.wgsl();
    let text = [
        &argil_abi::wgsl(),
        &source.tables(),
        &target_wgsl(texels),
        field,
        fill,
    ];
    let mut binds = source.binds();
    binds.extend([Bind::Uniform(FILL), Bind::Target(TEXELS, texels.format())]);
    let constants = [("TILE_SIDE", f64::from(side))];
    let label = source.name_of(["DenseFill", "DenseFill::columns", "DenseFill::lists"]);
    let entry_points: &[_] = match source.is_whole() {
        // The study's first version samples one texel at a time.
        true => &["fill_tiled", "fill_naive"],
        false => &["fill_tiled"],
    };
    PassModule::new(label, &text, binds, &constants, entry_points)
}

/// Returns WGSL of the texture that a build writes.
pub(crate) fn target_wgsl(texels: TexelFormat) -> String {
    let format = texels.wgsl();
    format!(
        "@group(0) @binding(BIND_FILL) var<uniform> fill: FillUniform;\n\
         @group(0) @binding(BIND_TEXELS) var texels: texture_storage_3d<{format}, write>;\n"
    )
}

/// Returns the threads along the side of the workgroup that fills a tile.
pub(crate) fn tile_side(gpu: &Gpu, tile: u32) -> u32 {
    let limits = gpu.device.limits();
    let sides = limits
        .max_compute_workgroup_size_x
        .min(limits.max_compute_workgroup_size_y);
    let threads = limits.max_compute_invocations_per_workgroup;
    tile_side_within(threads.min(sides * sides), tile)
}

/// Returns the threads along the side of the workgroup that fills a tile, with at most `threads` in all. 256 are the most: a
/// hardware device gives each thread of a larger group fewer registers, and fewer groups run at once.
pub(crate) fn tile_side_within(threads: u32, tile: u32) -> u32 {
    let fits = |side: &u32| side * side <= threads && *side <= tile;
    [16, 8].into_iter().find(fits).unwrap_or(1)
}

/// Returns the layers of a tile that each dispatch fills, limited by its work and by the rounds of a thread's
/// loops. `layer_work` is the work of one layer of all tiles.
pub(crate) fn layers(
    field: &GpuProgram,
    layer_work: u64,
    tile: u32,
    side: u32,
) -> impl Iterator<Item = (u32, u32)> {
    let columns = (tile / side) * (tile / side);
    let by_work = (WORK_PER_DISPATCH / layer_work.max(1)).min(u64::from(tile)) as u32;
    // The loops over columns also have rounds.
    let by_budget = field.budget / (columns + 1);
    let count = by_work.min(by_budget).max(1);
    (0..tile)
        .step_by(count as usize)
        .map(move |first| (first, count.min(tile - first)))
}
