//! Opens worlds in stores, and saves edits beside them.

use crate::open_world::FoundWorld;
#[cfg(not(target_arch = "wasm32"))]
use crate::open_world::OpenWorld;
#[cfg(not(target_arch = "wasm32"))]
use crate::render_worker::StoredPages;
use crate::session::Session;
use std::path::PathBuf;

impl Session {
    /// Opens a world in place of the document.
    pub(crate) fn show_world(&mut self, found: FoundWorld) -> anyhow::Result<()> {
        let path = cfg!(not(target_arch = "wasm32")).then(|| PathBuf::from(&found.address));
        self.replace_with(found.planned, None, Some(found.world));
        self.preferences.pipeline = crate::pipeline::Pipeline::default();
        if let Some(path) = path {
            self.preferences.remember(&path);
        }
        // What the tiles lack is performed as an edit, so that the renderer follows.
        for delta in &found.deltas {
            self.document.replay_saved(delta)?;
        }
        self.document.keep_log();
        self.show_note(format!("Opened {}", found.address));
        Ok(())
    }

    /// Saves the edits since the last time: beside the world, or as a download.
    pub(crate) fn save_world(&mut self) -> anyhow::Result<()> {
        self.document.end_stroke();
        let lines = self.document.log().to_owned();
        if lines.is_empty() {
            self.show_note("There are no new edits");
            return Ok(());
        }
        let note = self.put_edits(&lines)?;
        self.document.keep_log();
        self.show_note(note);
        Ok(())
    }

    #[cfg(target_arch = "wasm32")]
    fn put_edits(&mut self, lines: &str) -> anyhow::Result<String> {
        let name = "edits.jsonl";
        crate::browser::download(name.as_ref(), lines.as_bytes())?;
        Ok(format!(
            "Saved {name}: argil world edit WORLD --edits {name} puts it beside the world"
        ))
    }

    #[cfg(not(target_arch = "wasm32"))]
    fn put_edits(&mut self, lines: &str) -> anyhow::Result<String> {
        use anyhow::Context;
        let world = self.world.as_mut().context("no world is open")?;
        let before = world.stored.deltas().len();
        let saved = world.stored.save_edits(lines, "the edits of this window");
        let others = world.stored.deltas().len() - before;
        let saved = saved.with_context(|| match others {
            0 => "The edits were not saved",
            _ => "Others have saved edits that these do not fit: save the scene as a file, and open the world again",
        })?;
        let others = others - 1;
        Ok(match others {
            0 => format!("Saved {saved}"),
            _ => format!(
                "Saved {saved}, after edits that others have saved: open the world again to see them"
            ),
        })
    }

    /// Opens a world by the path of its folder or manifest, or by its address.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn open_world(&mut self, path: &std::path::Path) -> anyhow::Result<()> {
        use anyhow::Context;
        use argil_world::{ReadMode, StoredWorld, TileCacheOptions};
        let address = path.to_str().context("the address is no text")?;
        let stored = StoredWorld::open(address, &TileCacheOptions::from_environment())?;
        // It is shown, and kept among the preferences.
        let address = argil_world::redacted(address);
        let deltas = stored
            .deltas()
            .map(|(_, bytes)| String::from_utf8_lossy(bytes));
        self.show_world(FoundWorld {
            address,
            planned: stored.planned_scene().clone(),
            deltas: deltas.map(std::borrow::Cow::into_owned).collect(),
            world: OpenWorld {
                pages: StoredPages {
                    options: stored.levels_options(),
                    source: stored.source(ReadMode::Eventually),
                },
                stored,
            },
        })
    }
}

/// Whether a path is that of a world: an address, a manifest or a folder with one.
#[cfg(not(target_arch = "wasm32"))]
pub fn is_world(path: &std::path::Path) -> bool {
    path.to_str().is_some_and(|text| text.contains("://"))
        || path.file_name().is_some_and(|name| name == "manifest.json")
        || path.join("manifest.json").is_file()
}
