//! A frame as data: its passes in order.

/// Words of a histogram beyond a ray's steps: what is looked up in the last of them.
pub(crate) const MARGIN: u32 = 64;

/// Side of a workgroup.
pub(crate) const GROUP: u32 = 8;

/// What a recording depends on: while it stays the same, so do the passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrameKey {
    pub size: [u32; 2],
    pub samples: usize,
    pub show: u32,
    pub normals: u32,
    pub has_ground: bool,
    pub max_steps: u32,
    /// Instructions of the field, and evaluations that a thread may do in a dispatch.
    pub field: (usize, u32),
    pub with_hits: bool,
}

impl FrameKey {
    /// Words of a histogram.
    pub(super) fn bins(&self) -> u32 {
        self.max_steps.saturating_add(MARGIN)
    }

    pub(super) fn pixels(&self) -> u64 {
        self.size.map(u64::from).iter().product()
    }
}

/// One step of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FrameStep {
    /// Sets colors and counts to zero.
    Clear,
    /// Draws triangles, by the numbers of a dispatch.
    Draw(usize),
    /// Empties the list of blocks of pixels.
    EmptyBlocks,
    /// Takes over how many blocks there are.
    TakeBlocks,
    /// Runs a pass.
    Pass {
        label: &'static str,
        /// Its place among the pipelines.
        pipeline: usize,
        /// Its place among the numbers of dispatches.
        dispatch: usize,
        /// So many workgroups; as many as there are blocks without.
        groups: Option<[u32; 3]>,
    },
    /// Counts what the rays of the first sample did.
    Count(usize),
    /// Keeps what they hit.
    KeepHits,
    /// Makes bytes of the colors.
    Resolve(usize),
    /// What follows is submitted apart: a device takes so much at once.
    Submit,
}

/// What is the dispatch's own in a [`Frame`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dispatch {
    pub sample: usize,
    pub first_row: u32,
    pub first_step: u32,
    pub step_count: u32,
    pub max_steps: u32,
}

/// The passes of a frame, and the numbers that each reads.
#[derive(Debug, Default)]
pub(crate) struct Recording {
    pub steps: Vec<FrameStep>,
    pub dispatches: Vec<Dispatch>,
}

impl Recording {
    /// Passes that take time.
    pub(super) fn passes(&self) -> u32 {
        let is_pass =
            |step: &&FrameStep| matches!(step, FrameStep::Pass { .. } | FrameStep::Draw(_));
        self.steps.iter().filter(is_pass).count() as u32
    }
}
