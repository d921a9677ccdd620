//! How rays are marched on the device, as each representation declares it.

use crate::bindings::Bind;
use argil_abi::{BIND_LINEAR, BIND_STORED, BIND_VOLUME};

/// What the pictures of a representation are made by.
#[derive(Debug)]
pub(crate) struct TraceMode {
    /// Told apart from others by it.
    pub name: &'static str,
    /// How rays are marched.
    pub march: &'static str,
    /// The bindings that reads, and what else it needs, in WGSL.
    pub tables: fn() -> String,
    /// The same bindings, with what is done with them.
    pub binds: &'static [Bind],
    /// Constants of the pipelines.
    pub constants: &'static [(&'static str, f64)],
    /// Whether each sample begins with triangles that are drawn.
    pub draws: bool,
    /// Whether the march evaluates the field, which makes it long.
    pub is_exact: bool,
    /// Whether cones go first, and leave a list of the blocks of pixels that are to be marched; then hits have normals, and light and
    /// materials are its own.
    pub has_cones: bool,
}

/// A volume's words, its texture and a filter.
pub(crate) const VOLUME_BINDS: [Bind; 3] = [
    Bind::Uniform(BIND_VOLUME),
    Bind::Texture(BIND_STORED),
    Bind::Filter(BIND_LINEAR),
];

/// What a frame is bound to: compared, so that nothing is bound anew while it stays the same.
#[derive(Clone, PartialEq)]
pub(crate) enum BoundResource {
    /// So many bytes of a buffer; all of it without a number.
    Buffer(u32, wgpu::Buffer, Option<u64>),
    View(u32, wgpu::TextureView),
    Sampler(u32, wgpu::Sampler),
}

impl BoundResource {
    /// A whole buffer.
    pub(crate) fn buffer(at: u32, buffer: &wgpu::Buffer) -> Self {
        Self::Buffer(at, buffer.clone(), None)
    }

    /// As wgpu takes it.
    pub(crate) fn entry(&self) -> wgpu::BindGroupEntry<'_> {
        let (binding, resource) = match self {
            Self::Buffer(at, buffer, bytes) => {
                let size = bytes.and_then(std::num::NonZeroU64::new);
                let buffer = wgpu::BufferBinding {
                    buffer,
                    offset: 0,
                    size,
                };
                (*at, wgpu::BindingResource::Buffer(buffer))
            }
            Self::View(at, view) => (*at, wgpu::BindingResource::TextureView(view)),
            Self::Sampler(at, sampler) => (*at, wgpu::BindingResource::Sampler(sampler)),
        };
        wgpu::BindGroupEntry { binding, resource }
    }
}
