//! Marching cubes on the device: units of cells are counted, the counts are added up, and then vertices and
//! triangles are written. The CPU waits for the totals, because they determine the sizes of the buffers.

use crate::bindings::{
    CASES, CELLS, EDGE_ROWS, MARCHING, OWNERS, SPANS, STORED, TRIANGLES, UNINDEXED, UNIT_GROUPS,
    UNITS, VERTICES, VOLUME, entry,
};
use crate::march_passes::{MarchPasses, project_module};
use crate::pass_module::Passes;
use crate::pass_recorder::{DispatchSize, PassRecorder};
use crate::resources::{read_table, uniform_for, uniform_of};
use crate::storage_buffer::StorageBuffer;
use crate::trace_mode::BoundResource;
use crate::volume::ClipUpdate;
use crate::{Gpu, GpuError, GpuMesh, GpuProgram, GpuVolume, StageTimings, SurfaceOptions};
use argil_abi::{self as abi, DenseUniform, MarchingUniform};
use argil_mesh::MeshNormals;
use glam::UVec3;

/// Cells along the side of a dense volume's units.
const DENSE_SIDE: u32 = 8;
/// Units whose counts one workgroup adds up.
use argil_abi::UNITS_PER_GROUP;
/// Maximum instructions times evaluations per dispatch.
const WORK_PER_DISPATCH: u64 = 4_000_000_000;
/// Evaluations per vertex: its distance, and six for its normal.
const EVALUATIONS: u64 = 7;

/// Returns workgroups for a number of items.
fn groups(count: u32, each: u32) -> DispatchSize<'static> {
    let count = count.div_ceil(each).max(1);
    let rows = count.div_ceil(abi::DISPATCH_ROW);
    DispatchSize::Direct([count.min(abi::DISPATCH_ROW), rows, 1])
}

/// What the passes write.
struct MarchTables {
    owners: StorageBuffer,
    units: StorageBuffer,
    groups: StorageBuffer,
    rows: StorageBuffer,
    vertices: StorageBuffer,
    triangles: StorageBuffer,
    spans: StorageBuffer,
}

impl MarchTables {
    fn new(gpu: &Gpu, units: u32) -> Result<Self, GpuError> {
        let mut tables = Self {
            owners: StorageBuffer::new("bricks' cells"),
            units: StorageBuffer::new("units"),
            groups: StorageBuffer::new("groups of units"),
            rows: StorageBuffer::new("rows of edges"),
            vertices: StorageBuffer::drawn("corners"),
            triangles: StorageBuffer::drawn("triangles"),
            spans: StorageBuffer::new("distances at edges' ends"),
        };
        let units = u64::from(units);
        tables.owners.reserve_exact(gpu, 4 * units)?;
        tables.units.reserve_exact(gpu, 16 * units)?;
        let groups = units.div_ceil(u64::from(UNITS_PER_GROUP)) + 1;
        tables.groups.reserve_exact(gpu, 16 * groups)?;
        // Bound, but not used until their sizes are known.
        for table in [
            &mut tables.rows,
            &mut tables.vertices,
            &mut tables.triangles,
            &mut tables.spans,
        ] {
            table.reserve_exact(gpu, 16)?;
        }
        Ok(tables)
    }

    /// Makes room for what was counted. `places` are those of rows that emit something.
    fn reserve(
        &mut self,
        gpu: &Gpu,
        marching: &MarchingUniform,
        places: u32,
        is_moved: bool,
    ) -> Result<(), GpuError> {
        let rows = u64::from((marching.side + 1).pow(2)) * u64::from(places);
        let corners = u64::from(marching.vertices);
        self.rows.reserve_exact(gpu, 16 * rows)?;
        self.vertices.reserve_exact(gpu, 24 * corners)?;
        let triangles = u64::from(marching.triangles);
        self.triangles.reserve_exact(gpu, 12 * triangles)?;
        if is_moved {
            self.spans.reserve_exact(gpu, 16 * corners)?;
        }
        Ok(())
    }

    fn all(&self) -> [(&StorageBuffer, u32); 6] {
        [
            (&self.units, UNITS),
            (&self.groups, UNIT_GROUPS),
            (&self.rows, EDGE_ROWS),
            (&self.vertices, VERTICES),
            (&self.triangles, TRIANGLES),
            (&self.spans, SPANS),
        ]
    }
}

impl GpuVolume {
    /// Extracts the surface of a dense volume or of bricks. Returns the mesh and the timings. `field` is the
    /// program that the volume was made from.
    ///
    /// # Errors
    /// If the mesh exceeds the device's limits or memory, or the volume is an octree.
    pub async fn march(
        &self,
        field: &GpuProgram,
        options: &SurfaceOptions,
    ) -> Result<(GpuMesh, StageTimings), GpuError> {
        let Some(cut) = self.cut() else {
            return Err(GpuError::NotMeshable);
        };
        let cells = match cut {
            ClipUpdate::Dense(_) => None,
            ClipUpdate::Bricks(..) if options.iso != 0.0 => {
                return Err(GpuError::UnsupportedIsoLevel);
            }
            ClipUpdate::Bricks(cells, _) => Some(cells),
        };
        let gpu = field.gpu();
        let texture = &self.body().texture;
        let name = ["march dense", "march bricks"][usize::from(cells.is_some())];
        let passes = field.passes(name, || MarchPasses::new(field, cells.is_some()))?;
        let (words, codes, marching) = measures(self, &cut, options);
        let mut tables = MarchTables::new(gpu, marching.units)?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let [volume, uniform] = gpu.with_error_scope(|| {
            let uniforms = [
                uniform_for(gpu, "volume", words.len() as u64),
                uniform_of::<MarchingUniform>(gpu, "marching"),
            ];
            gpu.write_buffer(&uniforms[0], 0, &words);
            gpu.write_buffer(&uniforms[1], 0, bytemuck::bytes_of(&marching));
            uniforms
        })?;
        let inputs = MarchInputs {
            passes: &passes,
            view: &view,
            volume: &volume,
            uniform: &uniform,
            cells,
        };
        let bind = |tables: &MarchTables| inputs.bind(gpu, tables);

        let mut recorder = PassRecorder::new(gpu)?;
        let counting = bind(&tables)?;
        count(
            gpu,
            &passes,
            &tables,
            &counting,
            [codes, marching.units],
            &mut recorder,
        )
        .await?;
        let each = groups(marching.units, 1);
        let [vertices, triangles, places] = totals(gpu, &tables.groups).await?;

        let marching = MarchingUniform {
            vertices,
            triangles,
            ..marching
        };
        tables.reserve(gpu, &marching, places, options.project_to_field)?;
        if vertices > 0 {
            let emitting = bind(&tables)?;
            for name in ["assign_row_offsets", "emit"] {
                let pass = passes.march.get(gpu, name)?;
                recorder.pass("emit", pass, &emitting, each).await?;
            }
        }
        if vertices > 0 && (options.project_to_field || options.normals == MeshNormals::Field) {
            refine(field, &tables, &uniform, &marching, &mut recorder).await?;
        }
        let mut drawn = MarchResult {
            out: tables.vertices,
            indices: Some(tables.triangles),
            counts: [vertices, triangles],
        };
        if options.is_unindexed && triangles > 0 {
            drawn = unindex(gpu, &passes, &uniform, &marching, drawn, &mut recorder).await?;
        }
        let stages = recorder.finish().await?;
        Ok((
            GpuMesh::of_tables(drawn.out, drawn.indices, drawn.counts),
            stages,
        ))
    }
}

/// What marching cubes reads besides its own tables.
struct MarchInputs<'a> {
    passes: &'a MarchPasses,
    view: &'a wgpu::TextureView,
    volume: &'a wgpu::Buffer,
    uniform: &'a wgpu::Buffer,
    cells: Option<&'a StorageBuffer>,
}

impl MarchInputs<'_> {
    fn bind(&self, gpu: &Gpu, tables: &MarchTables) -> Result<wgpu::BindGroup, GpuError> {
        gpu.with_error_scope(|| {
            let mut entries = vec![
                entry(VOLUME, self.volume),
                wgpu::BindGroupEntry {
                    binding: STORED,
                    resource: wgpu::BindingResource::TextureView(self.view),
                },
                entry(MARCHING, self.uniform),
                entry(CASES, &self.passes.cases),
            ];
            let buffers = tables.all();
            entries.extend(buffers.iter().filter_map(|(table, at)| table.binding(*at)));
            if let Some(cells) = self.cells {
                entries.extend(cells.binding(CELLS));
                entries.extend(tables.owners.binding(OWNERS));
            }
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("March"),
                layout: &self.passes.march.layout,
                entries: &entries,
            })
        })
    }
}

/// Counts what each unit emits, and where its share begins.
async fn count(
    gpu: &Gpu,
    passes: &MarchPasses,
    tables: &MarchTables,
    counting: &wgpu::BindGroup,
    [codes, units]: [u32; 2],
    recorder: &mut PassRecorder<'_>,
) -> Result<(), GpuError> {
    let march = |name| passes.march.get(gpu, name);
    if let (true, Some(owners)) = (passes.of_bricks, tables.owners.buffer()) {
        gpu.with_error_scope(|| {
            let mut encoder = gpu
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.clear_buffer(owners, 0, None);
            gpu.submit(encoder);
        })?;
        recorder
            .pass("count", march("find_owners")?, counting, groups(codes, 64))
            .await?;
    }
    let each = groups(units, 1);
    let count_units = march("count_units")?;
    recorder.pass("count", count_units, counting, each).await?;
    let sums = groups(units, UNITS_PER_GROUP);
    let add_units = march("add_units")?;
    recorder.pass("scan", add_units, counting, sums).await?;
    recorder
        .pass("scan", march("add_groups")?, counting, groups(1, 1))
        .await?;
    Ok(())
}

/// Triangles in the form that is drawn: vertices, indices, and the numbers of both.
struct MarchResult {
    out: StorageBuffer,
    indices: Option<StorageBuffer>,
    counts: [u32; 2],
}

/// Gives each triangle its own vertices.
async fn unindex(
    gpu: &Gpu,
    passes: &MarchPasses,
    uniform: &wgpu::Buffer,
    marching: &MarchingUniform,
    shared: MarchResult,
    recorder: &mut PassRecorder<'_>,
) -> Result<MarchResult, GpuError> {
    let [_, triangles] = shared.counts;
    let mut unindexed = StorageBuffer::drawn("corners");
    unindexed.reserve_exact(gpu, 72 * u64::from(triangles))?;
    let bind_group = gpu.with_error_scope(|| {
        gpu.write_buffer(uniform, 0, bytemuck::bytes_of(marching));
        let mut entries = vec![entry(MARCHING, uniform)];
        entries.extend(shared.out.binding(VERTICES));
        entries.extend(shared.indices.as_ref().and_then(|t| t.binding(TRIANGLES)));
        entries.extend(unindexed.binding(UNINDEXED));
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("March::unindex"),
            layout: &passes.unindex.layout,
            entries: &entries,
        })
    })?;
    let each = groups(triangles, 64);
    recorder
        .pass(
            "unindex",
            passes.unindex.get(gpu, "unindex")?,
            &bind_group,
            each,
        )
        .await?;
    Ok(MarchResult {
        out: unindexed,
        indices: None,
        counts: [3 * triangles, triangles],
    })
}

/// Voxels along a side for which rounding is accounted for.
const MAX_SIDE: f32 = 4096.0;

/// Returns the uniform of a volume as bytes, the number of its cells, and the uniform of marching cubes.
fn measures(
    volume: &GpuVolume,
    cut: &ClipUpdate<'_>,
    options: &SurfaceOptions,
) -> (Vec<u8>, u32, MarchingUniform) {
    let (voxel_grid, encoding) = (volume.voxel_grid(), volume.encoding());
    let quantum = encoding.band_width(voxel_grid, 0) / encoding.format.max_code() as f32;
    // Bricks have samples at the corners of voxels, and dense volumes at their centers.
    let mut first = voxel_grid.corner;
    let (words, units, side, codes) = match cut {
        ClipUpdate::Bricks(_, uniform) => {
            let words = bytemuck::bytes_of(*uniform).to_vec();
            (
                words,
                uniform.capacity,
                uniform.brick_size_voxels,
                uniform.table.cells,
            )
        }
        ClipUpdate::Dense(uniform) => {
            first += 0.5 * voxel_grid.voxel_size;
            let grid = (voxel_grid.size - 1).max(UVec3::ONE).to_array();
            let [grid_x, grid_y, grid_z] = grid.map(|n| n.div_ceil(DENSE_SIDE));
            let words = DenseUniform {
                grid_x,
                grid_y,
                grid_z,
                ..**uniform
            };
            let units = grid_x * grid_y * grid_z;
            (bytemuck::bytes_of(&words).to_vec(), units, DENSE_SIDE, 0)
        }
    };
    let marching = MarchingUniform {
        first_voxel: first.extend(voxel_grid.voxel_size).to_array(),
        iso: options.iso / quantum,
        quantum,
        // No more than rounding requires, because a world may be wide.
        bias: (0.05 * voxel_grid.voxel_size).max(
            1e-4 * voxel_grid
                .extent()
                .max_element()
                .min(MAX_SIDE * voxel_grid.voxel_size),
        ),
        units,
        side,
        normals: match options.normals {
            MeshNormals::None => abi::MARCH_NONE,
            MeshNormals::Gradient => abi::MARCH_GRADIENT,
            MeshNormals::Field => abi::MARCH_FIELD,
            MeshNormals::Face => abi::MARCH_FACE,
        },
        is_moved: u32::from(options.project_to_field),
        ..MarchingUniform::default()
    };
    (words, codes, marching)
}

/// Returns the numbers of vertices, triangles, and units with vertices.
async fn totals(gpu: &Gpu, groups: &StorageBuffer) -> Result<[u32; 3], GpuError> {
    let read = read_table(gpu, groups, groups.used()).await?;
    let words: Vec<u32> = read
        .chunks_exact(4)
        .map(bytemuck::pod_read_unaligned)
        .collect();
    match words[..] {
        [.., vertices, triangles, places, _] => Ok([vertices, triangles, places]),
        _ => Err(GpuError::Lost("the counts did not come back".into())),
    }
}

/// Moves vertices to the field's surface, or gives them its normals.
async fn refine(
    field: &GpuProgram,
    tables: &MarchTables,
    uniform: &wgpu::Buffer,
    marching: &MarchingUniform,
    recorder: &mut PassRecorder<'_>,
) -> Result<(), GpuError> {
    let gpu = field.gpu();
    let near = field.near_for(EVALUATIONS * u64::from(marching.vertices), None)?;
    let by_lists = near.is_some();
    let passes = field.passes(("project to field", u32::from(by_lists)), || {
        Passes::new(gpu, project_module(&field.wgsl_by(by_lists), by_lists))
    })?;
    let bind_group = gpu.with_error_scope(|| {
        let mut entries: Vec<_> = field.table_bindings().collect();
        entries.extend(near.iter().flatten().map(BoundResource::entry));
        entries.push(entry(MARCHING, uniform));
        entries.extend(tables.vertices.binding(VERTICES));
        entries.extend(tables.spans.binding(SPANS));
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("March::project_to_field"),
            layout: &passes.layout,
            entries: &entries,
        })
    })?;
    let work = EVALUATIONS * field.length() as u64;
    let chunk = (WORK_PER_DISPATCH / work).clamp(64, u64::from(u32::MAX)) as u32;
    let project = passes.get(gpu, "project_to_field")?;
    for first_vertex in (0..marching.vertices).step_by(chunk as usize) {
        let marching = MarchingUniform {
            first_vertex,
            vertices: marching.vertices.min(first_vertex.saturating_add(chunk)),
            ..*marching
        };
        gpu.write_buffer(uniform, 0, bytemuck::bytes_of(&marching));
        let count = marching.vertices - first_vertex;
        recorder
            .pass("refine", project, &bind_group, groups(count, 64))
            .await?;
    }
    Ok(())
}
