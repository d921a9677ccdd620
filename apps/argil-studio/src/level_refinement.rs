//! Bakes bricks of levels for an image.

use crate::render_request::RenderRequest;
use argil::World;
use argil::render::{RenderMode, RenderSettings};
use web_time::Instant;

/// Bakes what a still image of levels needs, within a time. Returns whether that was enough.
pub(crate) async fn refine(
    world: &mut World,
    request: &RenderRequest,
    settings: &RenderSettings,
    max_ms: f64,
) -> anyhow::Result<bool> {
    if world.levels().is_none() {
        return Ok(true);
    }
    let start = Instant::now();
    let remaining_ms = || max_ms - start.elapsed().as_secs_f64() * 1e3;
    // Light needs little else than what rays do.
    let quick = RenderSettings {
        mode: RenderMode::Normal,
        samples: 1,
        ..*settings
    };
    // Small images ask for most of it. A large one that asks for nothing is the last, however long it takes.
    let mut is_small = true;
    loop {
        if is_small {
            world.prefetch_async(&request.camera, &quick).await?;
        } else {
            world.render_async(&request.camera, &quick).await?;
        }
        let filled = world.fill_pages(remaining_ms())?;
        let is_done = filled.answered == 0;
        if is_done && filled.pending > 0 {
            // Tiles are on their way. On a page, they arrive only while nothing is drawn.
            return Ok(false);
        }
        if is_done && !filled.is_full {
            if !is_small {
                return Ok(true);
            }
            is_small = false;
        } else if remaining_ms() <= 0.0 {
            // In a full memory, no more becomes sharp.
            return Ok(is_done);
        }
    }
}
