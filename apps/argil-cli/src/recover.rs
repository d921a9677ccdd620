//! `argil recover`.

use crate::args::Recover;
use crate::output;
use argil::scene::Journal;
use serde_json::json;

pub(crate) fn run(options: &Recover) -> anyhow::Result<()> {
    output::check_place(&options.output, &options.journal)?;
    output::check_ending(&options.output, "a scene", "json")?;
    let found = Journal::recover(&options.journal)?;
    found.scene.save(&options.output)?;
    if options.json {
        output::json(&json!({
            "edits": found.edits,
            "torn_bytes": found.torn_bytes,
            "brushes": found.scene.brush_count(),
            "scene": options.output.display().to_string(),
        }));
        return Ok(());
    }
    output::line(&format!(
        "{}: {} after {}{}",
        options.output.display(),
        output::count(found.scene.brush_count(), "brush"),
        output::count(found.edits, "edit"),
        if found.torn_bytes > 0 {
            "; the last edit was incomplete and was dropped"
        } else {
            ""
        }
    ));
    Ok(())
}
