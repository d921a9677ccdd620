use crate::bindings::{ANSWERS, Bind, QUERIES, QUERY_WGSL};
use crate::near_lists::field_tables;
use crate::pass_module::{PassModule, Passes};
use crate::storage_buffer::StorageBuffer;
use crate::trace_mode::BoundResource;
use crate::{GpuError, GpuProgram};
use argil_abi::{QueryPoint, QueryResult};

/// Points per workgroup, and workgroups in a row of a dispatch.
pub(super) const GROUP: u32 = 64;
const ROW: u32 = 32_768;

impl GpuProgram {
    /// Evaluates the field at points: distances and materials. The pass is compiled when first used. Each of many
    /// points runs only the instructions that can matter near it, and gets the same distance, to the bit on a software device.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn evaluate(&self, points: &[[f32; 3]]) -> Result<Vec<QueryResult>, GpuError> {
        if points.is_empty() {
            return Ok(Vec::new());
        }
        let gpu = self.gpu();
        let near = self.near_for(points.len() as u64, None)?;
        let by_lists = near.is_some();
        let passes = self.passes(("query", u32::from(by_lists)), || {
            Passes::new(gpu, query_module(&self.wgsl_by(by_lists), by_lists))
        })?;
        let pipeline = passes.get(gpu, "query")?;
        let queries: Vec<QueryPoint> = points
            .iter()
            .map(|&[x, y, z]| QueryPoint {
                point: [x, y, z, 0.0],
            })
            .collect();
        let mut query_table = StorageBuffer::new("queries");
        query_table.write(gpu, &queries)?;
        let mut answers = StorageBuffer::new("answers");
        let bytes = (points.len() * size_of::<QueryResult>()) as u64;
        answers.reserve(gpu, bytes)?;
        let groups = (points.len() as u32).div_ceil(GROUP);
        gpu.with_error_scope(|| {
            let mut entries: Vec<_> = self.table_bindings().collect();
            entries.extend(near.iter().flatten().map(BoundResource::entry));
            entries.extend(query_table.binding(QUERIES));
            entries.extend(answers.binding(ANSWERS));
            let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("QueryPoint"),
                layout: &passes.layout,
                entries: &entries,
            });
            let mut encoder = gpu
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("QueryPoint::points"),
                timestamp_writes: None,
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &bind_group, &[]);
            pass.dispatch_workgroups(groups.min(ROW), groups.div_ceil(ROW), 1);
            drop(pass);
            gpu.submit(encoder);
        })?;
        let buffer = answers
            .buffer()
            .ok_or_else(|| GpuError::Lost("no answers".into()))?;
        Ok(gpu
            .read_back(buffer, bytes)
            .await?
            .chunks_exact(size_of::<QueryResult>())
            .map(bytemuck::pod_read_unaligned)
            .collect())
    }
}

/// Describes the pass that evaluates the field at points, by lists or not.
pub(crate) fn query_module(field_wgsl: &str, by_lists: bool) -> PassModule {
    let (mut binds, tables) = field_tables(by_lists);
    let source = [
        &argil_abi::wgsl(),
        &tables,
        QUERY_WGSL,
        field_wgsl,
        include_str!("query.wgsl"),
    ];
    binds.extend([Bind::Read(QUERIES), Bind::Write(ANSWERS)]);
    let label = if by_lists { "Query by lists" } else { "Query" };
    PassModule::new(label, &source, binds, &[], &["query"])
}
