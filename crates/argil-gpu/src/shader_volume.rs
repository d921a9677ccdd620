//! Volumes in the shaders of a host.

use crate::bindings::{Bind, FRAME, FRAME_WGSL, MATERIALS, layout_for};
use crate::resources::uniform_for;
use crate::trace_mode::{BoundResource, HostMode};
use crate::{Gpu, GpuError, GpuProgram, GpuVolume};
use argil_abi::FrameUniform;
use std::collections::HashSet;

/// What the shaders read of any volume.
const BINDS: [Bind; 2] = [Bind::Uniform(FRAME), Bind::Read(MATERIALS)];
const MATERIALS_WGSL: &str = "
@group(0) @binding(BIND_MATERIALS) var<storage, read> materials: array<GpuMaterial>;
";
/// The prefix of all names.
const PREFIX: &str = "argil_";

/// A volume in the shaders of a host: WGSL, and the bind group that it reads.
#[derive(Debug)]
pub struct ShaderVolume {
    mode: &'static HostMode,
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    bound: Vec<BoundResource>,
    uniforms: HostUniforms,
}

/// The uniforms of a frame and of a volume, besides those of images.
#[derive(Debug)]
struct HostUniforms {
    frame: wgpu::Buffer,
    volume: wgpu::Buffer,
}

impl ShaderVolume {
    /// Binds a volume of sparse bricks or of levels. The rays of shaders have the steps and the accuracy of a frame. Levels compute
    /// relative to the frame's eye, so distances are most precise there.
    ///
    /// # Errors
    /// If the volume is of another representation, or the device fails.
    pub fn new(
        field: &GpuProgram,
        volume: &GpuVolume,
        frame: &FrameUniform,
    ) -> Result<Self, GpuError> {
        let mode = mode_of(volume)?;
        let gpu = field.gpu();
        let stages = wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE;
        gpu.with_error_scope(|| {
            let binds: Vec<Bind> = BINDS.iter().chain(mode.binds).copied().collect();
            let layout = layout_for(gpu, "ShaderVolume", stages, &binds);
            let uniforms = HostUniforms {
                frame: uniform_for(gpu, "rays of a host", size_of::<FrameUniform>() as u64),
                volume: uniform_for(gpu, "volume of a host", volume.uniform().size()),
            };
            let bound = uniforms.write(field, volume, frame, mode);
            Self {
                mode,
                group: group_of(gpu, &layout, &bound),
                layout,
                bound,
                uniforms,
            }
        })
    }

    /// Follows edits of the volume, and pages of levels that came or went. Returns whether there is another bind group, because
    /// memory grew.
    ///
    /// # Errors
    /// If the volume is of another representation than the one that was bound, or the device fails.
    pub fn follow(
        &mut self,
        field: &GpuProgram,
        volume: &GpuVolume,
        frame: &FrameUniform,
    ) -> Result<bool, GpuError> {
        if !std::ptr::eq(mode_of(volume)?, self.mode) {
            return Err(GpuError::OtherShaderVolume);
        }
        let gpu = field.gpu();
        let bound = self.uniforms.write(field, volume, frame, self.mode);
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
    /// In levels, the finest page that is there answers. Pages that no image asked for are missing, and a coarser one answers there.
    /// A page's distances are off by at most half a diagonal of its voxels, times the Lipschitz constant. By default,
    /// its band is 4 of its voxels, or 16 if samples have 16 bits. Away from the surface, coarser pages answer, with voxels in
    /// proportion to the distance.
    ///
    /// Points, lengths and distances are in the scene's unit.
    pub fn wgsl(&self, group: u32) -> String {
        let source = [
            argil_abi::wgsl().as_str(),
            MATERIALS_WGSL,
            FRAME_WGSL,
            &(self.mode.tables)(),
            self.mode.wgsl,
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

impl HostUniforms {
    /// Writes them, and returns what shaders are bound to.
    fn write(
        &self,
        field: &GpuProgram,
        volume: &GpuVolume,
        frame: &FrameUniform,
        mode: &HostMode,
    ) -> Vec<BoundResource> {
        let gpu = field.gpu();
        gpu.write_buffer(&self.frame, 0, bytemuck::bytes_of(frame));
        let mut all = vec![BoundResource::buffer(FRAME, &self.frame)];
        all.extend(field.bound());
        all.extend(volume.bound(gpu, frame, &self.volume));
        let binds = BINDS.iter().chain(mode.binds);
        all.retain(|resource| binds.clone().any(|bind| bind.place() == resource.place()));
        all
    }
}

/// Returns how shaders of a host ask a volume.
fn mode_of(volume: &GpuVolume) -> Result<&'static HostMode, GpuError> {
    let way = volume.way();
    way.host.ok_or(GpuError::NoShaderVolume { name: way.name })
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
