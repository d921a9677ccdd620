//! Edits of a finished world, saved beside its tiles.
//!
//! Tiles never change. An edit is a file of lines, as `argil edit` reads them, with a number in the world's folder: the next one
//! that is free. A reader performs all of them on the plan's scene. Pages that they reach come from the field then, and all
//! others from the tiles.

use crate::WorldError;
use argil::scene::Scene;

/// Most files of edits that a world can have.
pub const MOST_DELTAS: usize = 100_000;

/// Returns the name of the object with the edits of a number, from 1 on, in the folder of a world.
///
/// ```
/// assert_eq!(argil_world::delta_name(12), "edits/000012.jsonl");
/// ```
pub fn delta_name(number: u32) -> String {
    format!("edits/{number:06}.jsonl")
}

/// Whether an answer can be edits. Some web servers send a page, or nothing, for whatever they do not have.
pub fn is_delta(bytes: &[u8]) -> bool {
    let text = bytes.trim_ascii_start();
    !text.is_empty() && !text.starts_with(b"<")
}

/// Performs edits on a scene, line by line. Returns their number. `place` appears in messages. A stroke that has no end ends here.
///
/// # Errors
/// If a line cannot be read or performed, or brings a mesh that is no part of the world. The scene keeps the edits before it.
pub fn apply_delta(scene: &mut Scene, bytes: &[u8], place: &str) -> Result<usize, WorldError> {
    let broken =
        |index: usize, reason: String| WorldError::plan(format!("{place}:{}", index + 1), reason);
    let text = std::str::from_utf8(bytes)
        .map_err(|error| WorldError::plan(place, format!("this is no text: {error}")))?;
    let mut edits = 0;
    for (index, line) in text.lines().enumerate() {
        let line = line.trim_start_matches('\u{feff}').trim();
        if line.is_empty() {
            continue;
        }
        let done = scene.apply_log_line(line);
        done.map_err(|error| broken(index, error.to_string()))?;
        edits += 1;
    }
    scene.end_stroke();
    if let Some((mesh, _)) = scene.missing_meshes().first() {
        let reason = format!(
            "an edit brings the mesh {mesh}, which is no part of the world: plan and bake a world with it"
        );
        return Err(WorldError::plan(place, reason));
    }
    Ok(edits)
}
