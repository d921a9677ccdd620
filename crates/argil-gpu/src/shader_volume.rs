//! Volumes in the shaders of a host.

use crate::bindings::{
    BRICK_MATERIALS, Bind, CELLS, CELLS_WGSL, FRAME, FRAME_WGSL, LINEAR, MATERIALS, STORED, VOLUME,
    VOLUME_WGSL, layout_for,
};
use crate::bricks::BRICKS_WGSL;
use crate::resources::uniform_for;
use crate::trace_mode::BoundResource;
use crate::{Gpu, GpuError, GpuProgram, GpuVolume};
use argil_abi::FrameUniform;
use argil_render::wgsl;
use std::collections::HashSet;

/// What the shaders read.
const BINDS: [Bind; 7] = [
    Bind::Uniform(FRAME),
    Bind::Read(MATERIALS),
    Bind::Uniform(VOLUME),
    Bind::Texture(STORED),
    Bind::Filter(LINEAR),
    Bind::Read(CELLS),
    Bind::Read(BRICK_MATERIALS),
];
const MATERIALS_WGSL: &str = "
@group(0) @binding(BIND_MATERIALS) var<storage, read> materials: array<GpuMaterial>;
";
/// The prefix of all names.
const PREFIX: &str = "argil_";

/// Sparse bricks in the shaders of a host: WGSL, and the bind group that it reads.
#[derive(Debug)]
pub struct ShaderVolume {
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    bound: Vec<BoundResource>,
    frame: wgpu::Buffer,
    volume: wgpu::Buffer,
}

impl ShaderVolume {
    /// Binds a volume. The rays of shaders have the steps and the accuracy of a frame.
    ///
    /// # Errors
    /// If the volume is not of sparse bricks, or the device fails.
    pub fn new(
        field: &GpuProgram,
        volume: &GpuVolume,
        frame: &FrameUniform,
    ) -> Result<Self, GpuError> {
        if volume.brick_layout().is_none() {
            return Err(GpuError::NotBricks);
        }
        let gpu = field.gpu();
        let stages = wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE;
        gpu.with_error_scope(|| {
            let layout = layout_for(gpu, "ShaderVolume", stages, &BINDS);
            let own = uniform_for(gpu, "rays of a host", size_of::<FrameUniform>() as u64);
            let uniform = uniform_for(gpu, "volume of a host", volume.uniform().size());
            let bound = resources(field, volume, frame, &own, &uniform);
            let group = group_of(gpu, &layout, &bound);
            gpu.write_buffer(&own, 0, bytemuck::bytes_of(frame));
            Self {
                layout,
                group,
                bound,
                frame: own,
                volume: uniform,
            }
        })
    }

    /// Follows edits of the volume. Returns whether there is another bind group, because memory grew.
    ///
    /// # Errors
    /// If the volume is not of sparse bricks, or the device fails.
    pub fn follow(
        &mut self,
        field: &GpuProgram,
        volume: &GpuVolume,
        frame: &FrameUniform,
    ) -> Result<bool, GpuError> {
        if volume.brick_layout().is_none() {
            return Err(GpuError::NotBricks);
        }
        let gpu = field.gpu();
        gpu.write_buffer(&self.frame, 0, bytemuck::bytes_of(frame));
        let bound = resources(field, volume, frame, &self.frame, &self.volume);
        let is_other = bound != self.bound;
        if is_other {
            self.group = gpu.with_error_scope(|| group_of(gpu, &self.layout, &bound))?;
            self.bound = bound;
        }
        gpu.fault().map_or(Ok(is_other), Err)
    }

    /// Returns WGSL to put before that of the host, which binds the volume as `group`. All of its names begin with `argil_` or
    /// `Argil`:
    ///
    /// * `argil_distance(p: vec3<f32>) -> f32`: the signed distance, negative inside. More than a band from the surface, it is a
    ///   lower bound.
    /// * `argil_gradient(p: vec3<f32>) -> vec3<f32>`: the change of the distance along each axis.
    /// * `argil_material(p: vec3<f32>) -> ArgilMaterial`: the `base_color`, `roughness`, `emission` and `metallic` at a point of the
    ///   surface, in linear colors.
    /// * `argil_cast_ray(origin: vec3<f32>, direction: vec3<f32>, max_length: f32) -> ArgilHit`: `is_hit`, the length `t` along a
    ///   unit direction, and the `normal` toward the ray.
    ///
    /// Points, lengths and distances are in the scene's unit.
    pub fn wgsl(&self, group: u32) -> String {
        let source = [
            &argil_abi::wgsl(),
            MATERIALS_WGSL,
            FRAME_WGSL,
            BRICKS_WGSL,
            VOLUME_WGSL,
            CELLS_WGSL,
            argil_volume::wgsl::BRICK_CELLS,
            argil_volume::wgsl::BRICK_MATERIALS,
            wgsl::BRICK_HOST,
        ]
        .concat();
        prefixed(&source).replace("@group(0)", &format!("@group({group})"))
    }

    /// Returns the layout of the bind group. Fragment and compute shaders see it.
    pub fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// Returns the bind group.
    pub fn bind_group(&self) -> &wgpu::BindGroup {
        &self.group
    }
}

/// Writes the volume's uniform, and returns what shaders are bound to.
fn resources(
    field: &GpuProgram,
    volume: &GpuVolume,
    frame: &FrameUniform,
    own: &wgpu::Buffer,
    uniform: &wgpu::Buffer,
) -> Vec<BoundResource> {
    let mut all = vec![BoundResource::buffer(FRAME, own)];
    all.extend(field.bound());
    all.extend(volume.bound(field.gpu(), frame, uniform));
    all.retain(|resource| BINDS.iter().any(|bind| bind.place() == resource.place()));
    all
}

fn group_of(gpu: &Gpu, layout: &wgpu::BindGroupLayout, bound: &[BoundResource]) -> wgpu::BindGroup {
    let entries: Vec<_> = bound.iter().map(BoundResource::entry).collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("ShaderVolume"),
        layout,
        entries: &entries,
    })
}

/// Puts a prefix before the names that WGSL declares outside of functions, so that those of a host stay free. Leaves out
/// lines of comments.
fn prefixed(source: &str) -> String {
    let lines = source
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    let names: HashSet<&str> = lines.clone().filter_map(declared).collect();
    let mut out = String::with_capacity(2 * source.len());
    for line in lines {
        let mut rest = line;
        while let Some(begin) = rest.find(|c: char| c.is_ascii_alphabetic() || c == '_') {
            let (before, from) = rest.split_at(begin);
            let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
            let (name, after) =
                from.split_at(from.find(|c: char| !is_part(c)).unwrap_or(from.len()));
            out.push_str(before);
            // A member, or the letters of a number.
            let is_name = !before.ends_with(|c: char| c == '.' || c.is_ascii_digit());
            if is_name && names.contains(name) && !name.to_lowercase().starts_with("argil") {
                out.push_str(PREFIX);
            }
            out.push_str(name);
            rest = after;
        }
        out.push_str(rest);
        out.push('\n');
    }
    out
}

/// Returns the name that a line declares outside of functions.
fn declared(line: &str) -> Option<&str> {
    // Bindings begin with their attributes.
    let from = match line.strip_prefix('@') {
        Some(_) => &line[line.find(" var")? + 1..],
        None => line,
    };
    let (keyword, rest) = from.split_once([' ', '<'])?;
    let rest = match keyword {
        "fn" | "struct" | "const" | "override" => rest,
        "var" => &rest[rest.find("> ")? + 2..],
        _ => return None,
    };
    rest.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
        .next()
}
