//! Keeps a hardware GPU at its full clock.
//!
//! *Practice.* A GPU lowers its clock within a tenth of a second without work, to a fifth on a data center's. Short work
//! does not raise it. [`Awake`] renders frames that are not counted: up to a second before a sitting, and some
//! milliseconds before each sample. It samples the clock all the while.

use crate::clock_range::{ClockMeter, ClockRange, Interval};
use crate::clock_sampler::ClockSampler;
use argil::render::{Camera, RenderMode, RenderSettings};
use argil::{Engine, World};
use std::time::{Duration, Instant};

/// How long a GPU is warmed up, at least and at most.
const WARM_UP: [Duration; 2] = [Duration::from_millis(300), Duration::from_secs(1)];

/// How long a GPU whose clock is unknown is warmed up.
const WARM_UP_BLIND: Duration = Duration::from_millis(500);

/// How long a frame of the work that is not counted takes, at least.
const BURST: Duration = Duration::from_millis(8);

/// The sizes of frames and samples per pixel to choose from.
const LOADS: [([u32; 2], u32); 7] = [
    ([160, 90], 4),
    ([320, 180], 4),
    ([320, 180], 16),
    ([320, 180], 64),
    ([640, 360], 64),
    ([1280, 720], 64),
    ([1920, 1080], 64),
];

/// Work that is not counted: frames of a scene's field.
struct Heater {
    world: World,
    camera: Camera,
    settings: RenderSettings,
}

impl Heater {
    /// Chooses the smallest frame that takes long enough.
    fn new(engine: &Engine) -> anyhow::Result<Self> {
        let world = engine.build(&crate::scenes::scene("csg20")?)?.field();
        let camera = world.camera();
        let settings = world.render_settings(LOADS[0].0, RenderMode::Shaded);
        let mut heater = Self {
            world,
            camera,
            settings,
        };
        // The first frame compiles.
        heater.burst()?;
        for (size, samples) in LOADS {
            heater.settings.size = size;
            heater.settings.samples = samples;
            heater.burst()?;
            let start = Instant::now();
            heater.burst()?;
            if start.elapsed() >= BURST {
                break;
            }
        }
        Ok(heater)
    }

    fn burst(&self) -> anyhow::Result<()> {
        self.world.render(&self.camera, &self.settings)?;
        Ok(())
    }
}

/// Keeps a GPU awake and samples its clock. Does nothing for other devices.
pub(crate) struct Awake {
    heater: Option<Heater>,
    clock: Box<dyn ClockMeter>,
}

impl Awake {
    /// Starts for a hardware GPU with a name.
    ///
    /// # Errors
    /// If the device fails.
    pub(crate) fn start(engine: &Engine, device: &str) -> anyhow::Result<Self> {
        Ok(Self {
            heater: Some(Heater::new(engine)?),
            clock: Box::new(ClockSampler::start(device)),
        })
    }

    /// Returns what does nothing: for the CPU and software GPUs.
    pub(crate) fn idle() -> Self {
        Self::with_clock(ClockSampler::unknown(
            "no clock is read for the CPU and software GPUs",
        ))
    }

    /// Returns what only tells a clock.
    pub(crate) fn with_clock(clock: impl ClockMeter + 'static) -> Self {
        Self {
            heater: None,
            clock: Box::new(clock),
        }
    }

    /// Returns the reason why the clock of a hardware GPU is unknown.
    pub(crate) fn unknown_clock(&self) -> Option<&str> {
        let heater = self.heater.as_ref();
        heater.and_then(|_| self.clock.unknown_because())
    }

    /// Works until the clock has stopped rising.
    ///
    /// # Errors
    /// If the device fails.
    pub(crate) fn warm_up(&self) -> anyhow::Result<()> {
        let Some(heater) = &self.heater else {
            return Ok(());
        };
        let start = Instant::now();
        let [least, most] = WARM_UP;
        loop {
            heater.burst()?;
            let passed = start.elapsed();
            let is_done = match self.clock.has_settled(start) {
                Some(has_settled) => has_settled && passed >= least,
                None => passed >= WARM_UP_BLIND,
            };
            if is_done || passed >= most {
                return Ok(());
            }
        }
    }

    /// Works for some milliseconds, right before a sample.
    ///
    /// # Errors
    /// If the device fails.
    pub(crate) fn burst(&self) -> anyhow::Result<()> {
        self.heater.as_ref().map_or(Ok(()), Heater::burst)
    }

    /// Returns the range of the clock in intervals.
    pub(crate) fn clocks(&self, intervals: &[Interval]) -> Option<ClockRange> {
        self.clock.range(intervals)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use argil::Backend;

    /// A GPU whose clock is unknown is warmed up for a while.
    #[test]
    fn a_gpu_is_warmed_up() {
        let engine = Engine::with_backend(Backend::Gpu).expect("a GPU");
        let awake = Awake::start(&engine, "a GPU without a clock").expect("work");
        let start = Instant::now();
        awake.warm_up().expect("work");
        assert!(start.elapsed() >= WARM_UP_BLIND);
        awake.burst().expect("work");
        assert_eq!(awake.clocks(&[(start, Instant::now())]), None);
        assert!(awake.unknown_clock().is_some());
        // Nothing is done for a CPU, and nothing is said.
        let idle = Awake::idle();
        idle.warm_up().and_then(|()| idle.burst()).expect("nothing");
        assert_eq!(idle.unknown_clock(), None);
    }
}
