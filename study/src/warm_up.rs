//! Frames before those that are timed.

use crate::experiment::Plan;
use argil::render::{Camera, RenderSettings};
use argil::{Orbit, World};
use std::time::{Duration, Instant};

/// How long a hardware GPU renders before its frames are timed.
const HARDWARE: Duration = Duration::from_millis(500);

/// The size and samples of frames that make a hardware GPU speed up.
const HEAVY: ([u32; 2], u32) = ([3840, 2160], 4);

/// Renders frames that are not counted: an orbit of some. A hardware GPU gets larger ones before: its clock falls to a
/// fifth while shaders are compiled, and short frames do not raise it.
pub(crate) fn warm_up(
    world: &World,
    (camera, settings): (Camera, &RenderSettings),
    plan: &Plan,
    count: u32,
) -> anyhow::Result<()> {
    let is_hardware = plan.is_gpu && !plan.is_software_gpu;
    let heavy = RenderSettings {
        size: HEAVY.0,
        samples: HEAVY.1,
        ..*settings
    };
    let start = Instant::now();
    while is_hardware && start.elapsed() < HARDWARE {
        world.render(&camera, &heavy)?;
    }
    for camera in Orbit::cameras(camera, count) {
        world.render(&camera, settings)?;
    }
    Ok(())
}
