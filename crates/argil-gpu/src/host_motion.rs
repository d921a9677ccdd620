//! Where the points of a host's frame were before brushes moved.

use crate::bindings::{Bind, FRAME, FRAME_WGSL, HITS, INSTRS, MOTIONS, MOVED, PARAMS};
use crate::pass_module::{PassModule, Passes};
use crate::recording::GROUP;
use crate::storage_buffer::StorageBuffer;
use crate::trace_mode::BoundResource;
use crate::{GpuError, GpuProgram};
use argil_field::BrushMotion;
use argil_render::wgsl;
use std::sync::Arc;

const TABLES_WGSL: &str = "
@group(0) @binding(BIND_INSTRS) var<storage, read> instructions: array<Instruction>;
@group(0) @binding(BIND_PARAMS) var<storage, read> params: array<f32>;
@group(0) @binding(BIND_MOVED) var<storage, read> moved: array<vec4<u32>>;
@group(0) @binding(BIND_HITS) var<storage, read> hits: array<vec4<u32>>;
@group(0) @binding(BIND_MOTIONS) var<storage, read_write> motions: array<vec4<f32>>;
";

/// Describes the pass that finds the way of each pixel's point.
pub(crate) fn motion_module(field_wgsl: &str) -> PassModule {
    let source = [
        &argil_abi::wgsl(),
        TABLES_WGSL,
        FRAME_WGSL,
        wgsl::HIT_RECORDS,
        wgsl::CAMERA,
        field_wgsl,
        wgsl::MOTION,
    ];
    let binds = vec![
        Bind::Uniform(FRAME),
        Bind::Read(INSTRS),
        Bind::Read(PARAMS),
        Bind::Read(MOVED),
        Bind::Read(HITS),
        Bind::Write(MOTIONS),
    ];
    let constants = [("HOST_RAYS", 1.0)];
    PassModule::new(
        "Motion of brushes",
        &source,
        binds,
        &constants,
        &["move_hits"],
    )
}

/// The ways of a frame's points, and what finds them.
#[derive(Debug)]
pub(crate) struct HostMotion {
    instructions: StorageBuffer,
    moved: StorageBuffer,
    ways: StorageBuffer,
    /// What is bound, and for which passes.
    bound: Option<(Vec<BoundResource>, Arc<Passes>, wgpu::BindGroup)>,
}

impl HostMotion {
    pub(crate) fn new() -> Self {
        Self {
            instructions: StorageBuffer::new("instructions near what moved"),
            moved: StorageBuffer::new("brushes that moved"),
            ways: StorageBuffer::new("ways of points"),
            bound: None,
        }
    }

    /// Makes room for a frame, and returns the buffer of ways.
    pub(crate) fn reserve(
        &mut self,
        field: &GpuProgram,
        size: [u32; 2],
    ) -> Result<Option<&wgpu::Buffer>, GpuError> {
        let pixels: u64 = size.map(u64::from).iter().product();
        self.ways.reserve_exact(field.gpu(), 16 * pixels)?;
        Ok(self.ways.buffer())
    }

    /// Encodes the pass, for the hits of a frame.
    pub(crate) fn encode(
        &mut self,
        field: &GpuProgram,
        motion: &BrushMotion,
        (frames, hits, size): (BoundResource, BoundResource, [u32; 2]),
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), GpuError> {
        let gpu = field.gpu();
        let passes = field.plain_passes("motion of brushes", || {
            Passes::new(gpu, motion_module(&field.motion_wgsl()))
        })?;
        let pipeline = passes.get(gpu, "move_hits")?;
        self.instructions.write(gpu, &motion.instructions)?;
        self.moved.write(gpu, &motion.words())?;
        let tables = [
            (&self.instructions, INSTRS),
            (&self.moved, MOVED),
            (&self.ways, MOTIONS),
        ];
        let mut all = vec![frames, hits];
        all.extend(tables.iter().filter_map(|(table, at)| table.bound(*at)));
        all.extend(field.bound().filter(|resource| resource.place() == PARAMS));
        let is_same = |(bound, of, _): &(Vec<BoundResource>, Arc<Passes>, wgpu::BindGroup)| {
            *bound == all && Arc::ptr_eq(of, &passes)
        };
        let bound = match self.bound.take().filter(is_same) {
            Some(bound) => bound,
            None => {
                let entries: Vec<_> = all.iter().map(BoundResource::entry).collect();
                let group = gpu.with_error_scope(|| {
                    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                        label: Some("Motion of brushes"),
                        layout: &passes.layout,
                        entries: &entries,
                    })
                })?;
                (all, passes.clone(), group)
            }
        };
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("Motion of brushes"),
            timestamp_writes: None,
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &bound.2, &[]);
        let [columns, rows] = size.map(|side| side.div_ceil(GROUP));
        pass.dispatch_workgroups(columns, rows, 1);
        drop(pass);
        self.bound = Some(bound);
        Ok(())
    }
}
