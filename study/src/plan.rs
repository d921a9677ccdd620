//! The amount of measurements.

/// The amount of measurements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Preset {
    /// About 15 minutes on two cores.
    #[default]
    Quick,
    /// Everything.
    Full,
    /// A hardware GPU in at most five minutes.
    Hardware,
}

impl Preset {
    /// Returns the preset as a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Quick => "quick",
            Self::Full => "full",
            Self::Hardware => "hardware",
        }
    }
}

/// The amount of measurements for a device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Plan {
    /// The preset.
    pub preset: Preset,
    /// Whether the device is a software GPU, which takes about a hundred times as long as hardware.
    pub is_software_gpu: bool,
    /// Whether the device is a GPU.
    pub is_gpu: bool,
    /// Whether another renderer can be measured.
    pub has_peer: bool,
}

impl Plan {
    /// Returns one of three values: for a software GPU in a short run, for another device in a short run, or for a
    /// full run.
    pub fn pick<T>(&self, software: T, quick: T, full: T) -> T {
        match (self.preset, self.is_software_gpu) {
            (Preset::Full, _) => full,
            (_, true) => software,
            (_, false) => quick,
        }
    }

    /// Returns true if the device is a hardware GPU.
    pub fn is_hardware(&self) -> bool {
        self.is_gpu && !self.is_software_gpu
    }

    /// Returns the size of images in pixels.
    pub fn size(&self) -> [u32; 2] {
        match (self.preset, self.is_hardware()) {
            (Preset::Full, true) => [1920, 1080],
            (Preset::Hardware, true) => [1280, 720],
            (Preset::Hardware, false) => [64, 36],
            _ => self.pick([320, 180], [640, 360], [1280, 720]),
        }
    }

    /// Returns the default voxels along a side: the study's, where time allows.
    pub fn resolution(&self) -> u32 {
        self.pick(64, 256, 256)
    }

    /// Returns the frames of an orbit: the study's 250 on hardware.
    pub fn frames(&self) -> u32 {
        match (self.preset, self.is_hardware()) {
            (Preset::Full, true) => 250,
            (Preset::Hardware, true) => 24,
            _ => self.pick(3, 12, 40),
        }
    }
}
