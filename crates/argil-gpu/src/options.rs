//! Descriptions of devices, and options of what they do.

use argil_mesh::MeshNormals;
use std::fmt;

/// The kind of a graphics device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceKind {
    /// A graphics card.
    Discrete,
    /// Graphics in the processor's package.
    Integrated,
    /// A virtual machine's device.
    Virtual,
    /// Software on the CPU, such as Mesa's lavapipe.
    Software,
    /// Unknown.
    Other,
}

impl DeviceKind {
    /// Whether the automatic selection uses it.
    pub fn is_real_gpu(self) -> bool {
        matches!(self, Self::Discrete | Self::Integrated | Self::Virtual)
    }
}

impl fmt::Display for DeviceKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Discrete => "discrete GPU",
            Self::Integrated => "integrated GPU",
            Self::Virtual => "virtual GPU",
            Self::Software => "software",
            Self::Other => "other",
        })
    }
}

/// A graphics device.
#[derive(Clone, Debug)]
pub struct DeviceInfo {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: DeviceKind,
    /// The interface, such as Vulkan.
    pub backend: String,
    /// The driver and its version.
    pub driver: String,
}

/// What a device has been asked to do since it was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GpuCounters {
    /// Submissions to the queue.
    pub submissions: u64,
    /// Waits of the CPU for the device.
    pub waits: u64,
    /// Buffers created.
    pub buffers: u64,
    /// Pipelines created.
    pub pipelines: u64,
    /// Bytes that came back to the CPU.
    pub bytes_read: u64,
}

impl GpuCounters {
    /// Returns what was asked since an earlier state.
    #[must_use]
    pub fn since(self, before: Self) -> Self {
        self.with(before, |now, before| now - before)
    }

    /// Returns the greater of two numbers of each kind, for example of the frames of a second.
    #[must_use]
    pub fn most(self, other: Self) -> Self {
        self.with(other, u64::max)
    }

    fn with(self, other: Self, of: impl Fn(u64, u64) -> u64) -> Self {
        Self {
            submissions: of(self.submissions, other.submissions),
            waits: of(self.waits, other.waits),
            buffers: of(self.buffers, other.buffers),
            pipelines: of(self.pipelines, other.pipelines),
            bytes_read: of(self.bytes_read, other.bytes_read),
        }
    }
}

/// Options of marching cubes on a GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceOptions {
    /// Distance at which to extract the surface.
    pub iso: f32,
    /// The source of normals.
    pub normals: MeshNormals,
    /// Whether vertices move to the exact surface of the field.
    pub project_to_field: bool,
    /// Whether each triangle gets its own vertices.
    pub is_unindexed: bool,
}

/// The name and the duration in milliseconds of each stage of a build.
pub type StageTimings = Vec<(&'static str, f64)>;
