//! `DenseFill`: sampling a field into a texture.

use crate::bake::{Bake, Groups};
use crate::pass::{
    Bind, FIELD_BINDS, FILL, TABLES_WGSL, TEXELS, VOLUME_WGSL, entry, layout, pipelines,
};
use crate::resources::{read_level, texture, uniform_of, upload};
use crate::texels::TexelFormat;
use crate::volume::{Body, Cut, Kind, Upload};
use crate::way::{VOLUME_BINDS, Way};
use crate::work::Work;
use crate::{DenseFill, Gpu, GpuError, GpuField, GpuVolume, StagesMs};
use argil_abi::{DenseVolume, Fill};
use argil_field::Program;
use argil_march::wgsl;
use argil_volume::{Dense, Encoding, Lattice, Volume};
use glam::UVec3;

/// Instructions times texels that one dispatch may take on.
pub(crate) const WORK_A_DISPATCH: u64 = 4_000_000_000;
/// Texels along the side of a dense tile.
const TILE: u32 = 32;

/// A dense volume is its texture.
struct OneTexture {
    words: DenseVolume,
}

const DENSE_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: DenseVolume;
";

static DENSE: Way = Way {
    name: "dense",
    march: wgsl::DENSE,
    tables: || [DENSE_WGSL, VOLUME_WGSL].concat(),
    binds: &VOLUME_BINDS,
    constants: &[],
    draws: false,
    is_exact: false,
    has_cones: false,
};

impl Kind for OneTexture {
    fn way(&self) -> &'static Way {
        &DENSE
    }

    fn memory_bytes(&self, body: &Body) -> u64 {
        body.texture_bytes()
    }

    fn read<'a>(&'a self, body: &'a Body, gpu: &'a Gpu) -> Work<'a, Volume> {
        Box::pin(async move {
            let (lattice, encoding) = (body.lattice, body.encoding);
            let mut levels = Vec::new();
            for level in 0..body.texture.mip_level_count() {
                let measures = (&lattice, encoding.bits);
                levels.push(read_level(gpu, &body.texture, measures, level).await?);
            }
            let dense = Dense::from_levels(lattice, encoding, levels);
            Ok(Volume::Dense(dense.ok_or_else(GpuError::odd_volume)?))
        })
    }

    fn uniform(&self) -> &[u8] {
        bytemuck::bytes_of(&self.words)
    }

    fn cut(&self) -> Option<Cut<'_>> {
        Some(Cut::Dense(&self.words))
    }
}

impl Upload for Dense {
    fn upload<'a>(&'a self, field: &'a GpuField) -> Work<'a, GpuVolume> {
        Box::pin(async move {
            let gpu = field.gpu();
            let (lattice, encoding) = (*self.lattice(), *self.encoding());
            let levels = self.levels().len() as u32;
            let texture = texture(gpu, &lattice, encoding.bits, levels)?;
            for (level, texels) in (0..).zip(self.levels()) {
                upload(gpu, &texture, &lattice, level, texels).await?;
            }
            let words = dense_words(&lattice, &encoding, levels);
            GpuVolume::new(field, (lattice, encoding), texture, OneTexture { words })
        })
    }
}

/// The uniform of a dense volume.
pub(super) fn dense_words(lattice: &Lattice, encoding: &Encoding, levels: u32) -> DenseVolume {
    DenseVolume {
        corner: lattice.corner.to_array(),
        range: encoding.range_length(lattice, 0),
        extent: lattice.extent().to_array(),
        voxel: lattice.voxel,
        size_x: lattice.size.x,
        size_y: lattice.size.y,
        size_z: lattice.size.z,
        levels,
        quanta: encoding.bits.quanta(),
        ..DenseVolume::default()
    }
}

impl GpuVolume {
    /// Sample a field into a dense volume; what the stages took.
    pub async fn dense(
        field: &GpuField,
        program: &Program,
        lattice: Lattice,
        encoding: Encoding,
        mips: bool,
        way: DenseFill,
    ) -> Result<(Self, StagesMs), GpuError> {
        let gpu = field.gpu();
        let levels = Dense::level_count(program, &lattice, &encoding, mips);
        let texture = texture(gpu, &lattice, encoding.bits, levels)?;
        let side = tile_side(gpu, TILE);
        let source = [
            &argil_abi::wgsl(),
            TABLES_WGSL,
            &target_wgsl(gpu.texels(encoding.bits)),
            field.field_wgsl(),
            argil_volume::wgsl::FILL,
        ]
        .concat();
        let mut binds = FIELD_BINDS.to_vec();
        binds.extend([
            Bind::Uniform(FILL),
            Bind::Target(TEXELS, gpu.texels(encoding.bits).format()),
        ]);
        let layout = gpu.checked(|| layout(gpu, "DenseFill", &binds))?;
        let constants = [("TILE_SIDE", f64::from(side))];
        let [tiled, naive] = pipelines(
            gpu,
            source,
            &layout,
            &constants,
            ["fill_tiled", "fill_naive"],
        )?;
        let uniform = gpu.checked(|| uniform_of::<Fill>(gpu, "fill"))?;

        // Each level, in as many dispatches as its work takes.
        let mut bake = Bake::new(gpu)?;
        let filling = Filling {
            field,
            layout: &layout,
            uniform: &uniform,
            texture: &texture,
            pipeline: match way {
                DenseFill::Tiled => &tiled,
                DenseFill::Naive => &naive,
            },
            way,
        };
        for level in 0..levels {
            let size = lattice.level_size(level);
            let fill = Fill {
                tile: TILE,
                ..encoding.fill(program, &lattice, level)
            };
            filling.level(&mut bake, level, size, fill).await?;
        }
        let stages = bake.finish().await?;
        let words = dense_words(&lattice, &encoding, levels);
        let volume = Self::new(field, (lattice, encoding), texture, OneTexture { words })?;
        Ok((volume, stages))
    }
}

/// What the levels of a dense volume are filled with.
struct Filling<'a> {
    field: &'a GpuField,
    layout: &'a wgpu::BindGroupLayout,
    uniform: &'a wgpu::Buffer,
    texture: &'a wgpu::Texture,
    pipeline: &'a wgpu::ComputePipeline,
    way: DenseFill,
}

impl Filling<'_> {
    async fn level(
        &self,
        bake: &mut Bake<'_>,
        level: u32,
        size: UVec3,
        fill: Fill,
    ) -> Result<(), GpuError> {
        let (field, gpu) = (self.field, self.field.gpu());
        let stage = if level == 0 { "fill" } else { "mips" };
        let view = self.texture.create_view(&wgpu::TextureViewDescriptor {
            base_mip_level: level,
            mip_level_count: Some(1),
            ..wgpu::TextureViewDescriptor::default()
        });
        let bind_group = gpu.checked(|| {
            let mut entries: Vec<_> = field.table_bindings().collect();
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
                let own = layers(field, work, TILE, tile_side(gpu, TILE));
                own.map(|(first, count)| (first, count, tiles)).collect()
            }
            DenseFill::Naive => {
                let count = (WORK_A_DISPATCH / layer.max(1)).clamp(1, u64::from(size.z)) as u32;
                let own = (0..size.z).step_by(count as usize).map(|first| {
                    let groups = [size.x, size.y, count.min(size.z - first)];
                    (first, fill.layer_count, groups)
                });
                own.collect()
            }
        };
        for (first_layer, layer_count, groups) in dispatches {
            let fill = Fill {
                first_layer,
                layer_count,
                ..fill
            };
            gpu.queue
                .write_buffer(self.uniform, 0, bytemuck::bytes_of(&fill));
            let groups = Groups::Direct(groups);
            bake.pass(stage, self.pipeline, &bind_group, groups).await?;
        }
        Ok(())
    }
}

/// The texture that a build writes.
pub(crate) fn target_wgsl(texels: TexelFormat) -> String {
    let format = texels.wgsl();
    format!(
        "@group(0) @binding(BIND_FILL) var<uniform> fill: Fill;\n\
         @group(0) @binding(BIND_TEXELS) var texels: texture_storage_3d<{format}, write>;\n"
    )
}

/// Threads along the side of the group that fills a tile.
pub(crate) fn tile_side(gpu: &Gpu, tile: u32) -> u32 {
    let limits = gpu.device.limits();
    let most = limits
        .max_compute_invocations_per_workgroup
        .isqrt()
        .min(limits.max_compute_workgroup_size_x)
        .min(limits.max_compute_workgroup_size_y);
    let fitting = [32, 16, 8].into_iter().find(|&s| s <= most && s <= tile);
    fitting.unwrap_or(1)
}

/// The layers of a tile that each dispatch fills: as many as its work and the rounds of a thread's loops allow. `layer_work`
/// is that of one layer of all tiles.
pub(crate) fn layers(
    field: &GpuField,
    layer_work: u64,
    tile: u32,
    side: u32,
) -> impl Iterator<Item = (u32, u32)> {
    let columns = (tile / side) * (tile / side);
    let by_work = (WORK_A_DISPATCH / layer_work.max(1)).min(u64::from(tile)) as u32;
    // The loops over the columns themselves have rounds too.
    let by_budget = field.budget / (columns + 1);
    let count = by_work.min(by_budget).max(1);
    (0..tile)
        .step_by(count as usize)
        .map(move |first| (first, count.min(tile - first)))
}
