//! How rays are traced on the device, as each representation declares it.

use crate::bindings::Bind;
use argil_abi::{BIND_LINEAR, BIND_STORED, BIND_VOLUME};

/// How images of a representation are traced.
#[derive(Debug)]
pub(crate) struct TraceMode {
    /// Unique name.
    pub name: &'static str,
    /// Unique name of its passes with those of `MORE_LIGHT`.
    pub more_name: &'static str,
    /// WGSL that traces rays.
    pub march: &'static str,
    /// WGSL of its bindings, and what else it needs.
    pub tables: fn() -> String,
    /// The same bindings, with their types.
    pub binds: &'static [Bind],
    /// Constants of the pipelines.
    pub constants: &'static [(&'static str, f64)],
    /// Whether each sample begins with drawn triangles.
    pub draws: bool,
    /// Whether the march evaluates the field, which makes it long.
    pub is_exact: bool,
    /// How paths of light pass through it, if they can.
    pub paths: Option<PathMode>,
    /// How shaders of a host ask it, if they can.
    pub host: Option<&'static HostMode>,
    /// Whether cones go first, and leave a list of active blocks of pixels. Then hits have normals, and light and
    /// materials come from the volume.
    pub has_cones: bool,
    /// Whether points evaluate the field by the lists of their parts.
    pub by_lists: bool,
}

impl TraceMode {
    /// Whether a ray's march is one dispatch, which knows the normal.
    pub(crate) fn marches_at_once(&self) -> bool {
        !self.is_exact && !self.draws
    }
}

/// How paths of light pass through a representation.
#[derive(Debug)]
pub(crate) struct PathMode {
    /// Unique name of its passes.
    pub name: &'static str,
    /// WGSL that answers what paths ask, besides [`TraceMode::tables`].
    pub wgsl: &'static str,
    /// The bindings that it uses.
    pub binds: &'static [Bind],
}

/// How shaders of a host ask a representation. What all of them have is the frame's uniform and the materials.
#[derive(Debug)]
pub(crate) struct HostMode {
    /// WGSL of its bindings, and what else it needs.
    pub tables: fn() -> String,
    /// WGSL of what the shaders ask.
    pub wgsl: &'static str,
    /// The bindings that it uses.
    pub binds: &'static [Bind],
}

/// A volume's uniform, its texture and a sampler.
pub(crate) const VOLUME_BINDS: [Bind; 3] = [
    Bind::Uniform(BIND_VOLUME),
    Bind::Texture(BIND_STORED),
    Bind::Filter(BIND_LINEAR),
];

/// What a frame is bound to. It is compared, so that nothing is bound again while it stays the same.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum BoundResource {
    /// A number of bytes of a buffer, or all of it.
    Buffer(u32, wgpu::Buffer, Option<u64>),
    View(u32, wgpu::TextureView),
    Sampler(u32, wgpu::Sampler),
}

impl BoundResource {
    /// Returns the number of the binding.
    pub(crate) fn place(&self) -> u32 {
        match self {
            Self::Buffer(at, ..) | Self::View(at, _) | Self::Sampler(at, _) => *at,
        }
    }

    /// Returns a whole buffer.
    pub(crate) fn buffer(at: u32, buffer: &wgpu::Buffer) -> Self {
        Self::Buffer(at, buffer.clone(), None)
    }

    /// Converts to wgpu's type.
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
