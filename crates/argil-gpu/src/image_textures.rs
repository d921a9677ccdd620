//! Images that stay on the device.

use crate::bindings::{Bind, FRAME, FRAME_WGSL, HITS, KEPT_COLORS, KEPT_DISTANCES, PIXELS, entry};
use crate::pass_module::{PassModule, Passes};
use crate::{Gpu, GpuError};
use argil_abi::FrameUniform;
use argil_render::wgsl;

const BINDINGS_WGSL: &str = "
@group(0) @binding(BIND_HITS) var<storage, read> hits: array<vec4<u32>>;
@group(0) @binding(BIND_PIXELS) var<storage, read> pixels: array<u32>;
@group(0) @binding(BIND_KEPT_COLORS) var kept_colors: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(BIND_KEPT_DISTANCES) var kept_distances: texture_storage_2d<r32float, write>;
";
const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
const DISTANCE: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// Where a rendered image goes.
#[derive(Clone, Copy, Debug)]
pub enum ImageOutput<'a> {
    /// To the CPU.
    Cpu,
    /// To the CPU, with what the rays of the first sample hit.
    CpuWithHits,
    /// Into textures, with the lengths of the rays of the first sample. The image on the CPU has no pixels.
    Textures(&'a ImageTextures),
}

/// An image that stays on the device: the color of each pixel, and how far away it is.
///
/// ```no_run
/// use argil_gpu::{GpuError, ImageTextures, wgpu};
/// # fn make(device: &wgpu::Device) -> Result<(), GpuError> {
/// let image = ImageTextures::new(device, [1280, 720])?;
/// let view = image.color().create_view(&Default::default());
/// # let _ = view;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct ImageTextures {
    size: [u32; 2],
    color: wgpu::Texture,
    distance: wgpu::Texture,
}

impl ImageTextures {
    /// Creates textures of a size in pixels, which are black until something is drawn.
    ///
    /// # Errors
    /// If a side is zero, or exceeds the largest texture of the device.
    pub fn new(device: &wgpu::Device, size: [u32; 2]) -> Result<Self, GpuError> {
        let limit = device.limits().max_texture_dimension_2d;
        if !size.iter().all(|side| (1..=limit).contains(side)) {
            return Err(GpuError::ImageSize { size, limit });
        }
        let texture = |label, format| {
            use wgpu::TextureUsages as Usage;
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d {
                    width: size[0],
                    height: size[1],
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: Usage::STORAGE_BINDING
                    | Usage::TEXTURE_BINDING
                    | Usage::COPY_SRC
                    | Usage::COPY_DST,
                view_formats: &[],
            })
        };
        Ok(Self {
            size,
            color: texture("colors of an image", COLOR),
            distance: texture("distances of an image", DISTANCE),
        })
    }

    /// Returns the width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the colors, in sRGB, as `Rgba8Unorm`: a shader reads the numbers that an image file has.
    pub fn color(&self) -> &wgpu::Texture {
        &self.color
    }

    /// Returns the lengths of rays from the eye to a solid, in the scene's units, as `R32Float`. The greatest number stands for
    /// rays that hit nothing.
    pub fn distance(&self) -> &wgpu::Texture {
        &self.distance
    }

    /// Binds what a frame has, and where it goes.
    pub(crate) fn bind(
        &self,
        gpu: &Gpu,
        passes: &Passes,
        [frames, hits, pixels]: [&wgpu::Buffer; 3],
    ) -> wgpu::BindGroup {
        let [color, distance] =
            [&self.color, &self.distance].map(|texture| texture.create_view(&Default::default()));
        let frame = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: frames,
            offset: 0,
            size: std::num::NonZeroU64::new(size_of::<FrameUniform>() as u64),
        });
        let other = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("ImageTextures"),
            layout: &passes.layout,
            entries: &[
                other(FRAME, frame),
                entry(HITS, hits),
                entry(PIXELS, pixels),
                other(KEPT_COLORS, wgpu::BindingResource::TextureView(&color)),
                other(
                    KEPT_DISTANCES,
                    wgpu::BindingResource::TextureView(&distance),
                ),
            ],
        })
    }
}

/// Describes the passes that copy a frame into textures, for any representation.
pub(crate) fn textures_module() -> PassModule {
    let source = [
        &argil_abi::wgsl(),
        FRAME_WGSL,
        BINDINGS_WGSL,
        wgsl::HIT_RECORDS,
        include_str!("image_textures.wgsl"),
    ];
    let binds = vec![
        Bind::Uniforms(FRAME),
        Bind::Read(HITS),
        Bind::Read(PIXELS),
        Bind::Image(KEPT_COLORS, COLOR),
        Bind::Image(KEPT_DISTANCES, DISTANCE),
    ];
    let entry_points = ["keep_distances", "keep_colors"];
    PassModule::new("ImageTextures", &source, binds, &[], &entry_points)
}
