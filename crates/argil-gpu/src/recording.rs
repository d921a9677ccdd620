//! A frame as data: its passes in order.

use crate::image_textures::ImageOutput;
use argil_abi::FrameUniform;

/// Bins of a histogram beyond a ray's maximum steps, for what the last step looks up.
pub(crate) const MARGIN: u32 = 64;

/// Histograms of what rays did: steps of rays that looked up only distances, and for the others steps, samples,
/// nodes and cells.
const HISTOGRAMS: u64 = 5;

/// Side of a workgroup.
pub(crate) const GROUP: u32 = 8;

/// Light that only some images have, and that passes of its own gather.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct MoreLight {
    pub lamps: u32,
    pub has_fog: bool,
    pub has_bent_normals: bool,
    /// Whether it has another tone curve than ACES.
    pub has_tone: bool,
}

impl MoreLight {
    /// Returns what a frame has.
    pub(crate) fn of(frame: &FrameUniform) -> Self {
        if frame.mode != argil_abi::MODE_SHADED {
            return Self::default();
        }
        Self {
            lamps: frame.lamp_count,
            has_fog: frame.fog_density > 0.0,
            has_bent_normals: frame.has_bent_normals != 0,
            has_tone: frame.tone != argil_abi::TONE_ACES,
        }
    }

    /// Whether there is any.
    pub(crate) fn is_any(self) -> bool {
        self != Self::default()
    }

    /// Returns the layers of the buffer of colors.
    pub(crate) fn color_layers(self) -> u64 {
        if self.is_any() {
            argil_abi::COLOR_LAYERS.into()
        } else {
            1
        }
    }
}

/// Where a frame goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Destination {
    Cpu,
    CpuWithHits,
    Textures,
    /// A host submits the passes, and draws what they find.
    Host,
}

impl From<ImageOutput<'_>> for Destination {
    fn from(output: ImageOutput<'_>) -> Self {
        match output {
            ImageOutput::Cpu => Self::Cpu,
            ImageOutput::CpuWithHits => Self::CpuWithHits,
            ImageOutput::Textures(_) => Self::Textures,
        }
    }
}

/// What a recording depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrameKey {
    pub size: [u32; 2],
    pub samples: usize,
    pub show: u32,
    pub normals: u32,
    pub has_ground: bool,
    pub max_steps: u32,
    /// Instructions of the program, and evaluations that a thread may do per dispatch.
    pub field: (usize, u32),
    pub goes: Destination,
    pub more: MoreLight,
    /// Whether what rays did is counted.
    pub has_statistics: bool,
    /// `RECORD_…` bits.
    pub records: u32,
}

impl FrameKey {
    /// Returns the records that are stored of each pixel.
    pub(super) fn records_per_pixel(&self) -> u64 {
        let each = match self.records {
            0 => return 0,
            bits if bits & argil_abi::RECORD_COUNTS != 0 => 2,
            _ => 1,
        };
        each + u64::from(self.show == argil_abi::MODE_SHADED)
    }

    /// Returns the bytes of what rays did, or 0 if that is not counted.
    pub(super) fn count_bytes(&self) -> u64 {
        u64::from(self.has_statistics) * 4 * HISTOGRAMS * u64::from(self.bins())
    }

    /// Returns the bins of a histogram.
    pub(super) fn bins(&self) -> u32 {
        self.max_steps.saturating_add(MARGIN)
    }

    pub(super) fn pixels(&self) -> u64 {
        self.size.map(u64::from).iter().product()
    }

    /// Returns the bytes of pixels that go to the CPU.
    pub(super) fn staged_pixels(&self) -> u64 {
        match self.goes {
            Destination::Cpu | Destination::CpuWithHits => 4 * self.pixels(),
            Destination::Textures | Destination::Host => 0,
        }
    }
}

/// One step of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FrameStep {
    /// Clears colors and counts.
    Clear,
    /// Draws triangles, with the values of a dispatch.
    Draw(usize),
    /// Empties the list of blocks of pixels.
    EmptyBlocks,
    /// Copies the number of blocks to the dispatch arguments.
    TakeBlocks,
    /// Runs a pass.
    Pass {
        label: &'static str,
        /// Index of its pipeline.
        pipeline: usize,
        /// Index of its dispatch values.
        dispatch: usize,
        /// The number of workgroups. `None` uses the number of blocks.
        groups: Option<[u32; 3]>,
    },
    /// Counts what the rays of the first sample did.
    Count(usize),
    /// Keeps what they hit.
    KeepHits,
    /// Keeps how far away that is, in a texture.
    KeepDistances(usize),
    /// Converts colors to bytes.
    Resolve(usize),
    /// Keeps these in a texture.
    KeepColors(usize),
    /// Submits, because a device accepts a limited amount of work at once.
    Submit,
}

/// The values of a [`argil_abi::FrameUniform`] that differ between dispatches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dispatch {
    pub sample: usize,
    pub first_row: u32,
    pub first_step: u32,
    pub step_count: u32,
    pub max_steps: u32,
}

/// The passes of a frame, and the values that each reads.
#[derive(Debug, Default)]
pub(crate) struct Recording {
    pub steps: Vec<FrameStep>,
    pub dispatches: Vec<Dispatch>,
}

impl Recording {
    /// Returns the number of passes that take time.
    pub(super) fn passes(&self) -> u32 {
        let is_pass =
            |step: &&FrameStep| matches!(step, FrameStep::Pass { .. } | FrameStep::Draw(_));
        self.steps.iter().filter(is_pass).count() as u32
    }
}
