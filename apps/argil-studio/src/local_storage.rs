//! What a browser keeps of a scene and its meshes from one visit of the page to the next.

use crate::browser::NamedBytes;
use anyhow::Context;
use base64::prelude::{BASE64_STANDARD, Engine as _};
use eframe::egui;
use std::cell::Cell;
use wasm_bindgen::prelude::*;
use web_sys::StorageEvent;

const KEY: &str = "argil-scene";

/// There where the kept scene is saved nowhere else.
const UNSAVED: &str = "argil-scene-unsaved";

/// So long nothing must change before a scene is kept.
const REST: std::time::Duration = std::time::Duration::from_millis(400);

thread_local! {
    static OTHERS: Cell<bool> = const { Cell::new(false) };
}

/// The scene, from one visit of the page to the next.
pub struct LocalStorage {
    /// What is kept: the document's lines, and whether they are saved.
    kept: (u64, bool),
    changed: Option<((u64, bool), web_time::Instant)>,
    /// Whether it was told that another page keeps another scene.
    has_told: bool,
}

impl LocalStorage {
    /// Of nothing.
    pub fn new() -> Self {
        Self {
            kept: (0, false),
            changed: None,
            has_told: false,
        }
    }

    /// What was kept by another visit.
    pub fn found() -> Option<String> {
        storage()?.get_item(KEY).ok()?
    }

    /// Whether that is saved nowhere else.
    pub fn is_unsaved() -> bool {
        let found = storage().and_then(|s| s.get_item(UNSAVED).ok()?);
        found.is_some()
    }

    /// Keep a scene once it rests.
    ///
    /// # Errors
    /// If the browser does not take it, or another page keeps one.
    pub fn keep(
        &mut self,
        ctx: &egui::Context,
        what: (u64, bool),
        text: impl FnOnce() -> String,
    ) -> anyhow::Result<()> {
        if self.kept == what {
            return Ok(());
        }
        let now = web_time::Instant::now();
        match self.changed {
            Some((changed, since)) if changed == what => {
                let rested = now - since;
                if rested >= REST {
                    return self.keep_now(what, text);
                }
                ctx.request_repaint_after(REST - rested);
            }
            _ => {
                self.changed = Some((what, now));
                ctx.request_repaint_after(REST);
            }
        }
        Ok(())
    }

    /// Keep a scene, as the page may be about to go.
    ///
    /// # Errors
    /// As [`LocalStorage::keep`].
    pub fn keep_now(
        &mut self,
        what: (u64, bool),
        text: impl FnOnce() -> String,
    ) -> anyhow::Result<()> {
        if self.kept == what || OTHERS.get() && self.has_told {
            return Ok(());
        }
        if OTHERS.get() {
            self.has_told = true;
            anyhow::bail!(
                "another tab has opened Argil Studio, and the browser keeps its scene: what is done here from now on is to be saved"
            );
        }
        (self.kept, self.changed) = (what, None);
        let storage =
            storage().context("the browser keeps nothing for this page: save the scene")?;
        let mark = if what.1 {
            storage.set_item(UNSAVED, "1")
        } else {
            storage.remove_item(UNSAVED)
        };
        mark.and_then(|()| storage.set_item(KEY, &text())).map_err(|_| {
            anyhow::anyhow!(
                "the scene is larger than what the browser keeps for a page, some 5 MB: save it before you leave"
            )
        })
    }
}

/// Take note of other pages that keep a scene of theirs.
pub fn listen_to_others() -> Result<(), JsValue> {
    let note = Closure::<dyn Fn(StorageEvent)>::new(|event: StorageEvent| {
        if event.key().as_deref() == Some(KEY) {
            OTHERS.set(true);
        }
    });
    let window = web_sys::window().ok_or_else(|| JsValue::from_str("there is no window"))?;
    window.add_event_listener_with_callback("storage", note.as_ref().unchecked_ref())?;
    // As long as the page is there.
    note.forget();
    Ok(())
}

/// Keep a scene that cannot be read where it is not written over, for whoever can mend it.
pub fn quarantine(text: &str) {
    if let Some(storage) = storage() {
        // Where there is no room for it twice, it is lost.
        let _ = storage.set_item("argil-scene-unreadable", text);
    }
}

/// What the keys of kept meshes begin with.
const MESH: &str = "argil-mesh:";

/// Keep a mesh's file beside the scene.
///
/// # Errors
/// If the browser does not take it.
pub fn keep_mesh((name, bytes): &NamedBytes) -> anyhow::Result<()> {
    let text = BASE64_STANDARD.encode(bytes);
    let kept = storage().map(|s| s.set_item(&format!("{MESH}{name}"), &text));
    if matches!(kept, Some(Ok(()))) {
        return Ok(());
    }
    anyhow::bail!(
        "{name} is larger than what the browser keeps for a page, some 5 MB in all: after a reload it is to be opened again"
    )
}

/// A mesh that was kept.
pub fn kept_mesh(name: &str) -> Option<NamedBytes> {
    let text = storage()?.get_item(&format!("{MESH}{name}")).ok()??;
    Some((name.into(), BASE64_STANDARD.decode(text).ok()?))
}

/// The meshes that were kept and that something names; the others are let go.
pub fn kept_meshes(is_named: impl Fn(&str) -> bool) -> Vec<NamedBytes> {
    let Some(storage) = storage() else {
        return Vec::new();
    };
    let keys = (0..storage.length().unwrap_or(0)).filter_map(|i| storage.key(i).ok()?);
    let keys: Vec<String> = keys.filter(|key| key.starts_with(MESH)).collect();
    let mut all = Vec::new();
    for key in keys {
        let name = key[MESH.len()..].to_owned();
        if !is_named(&name) {
            // It is in nobody's way but another mesh's.
            let _ = storage.remove_item(&key);
        } else {
            all.extend(kept_mesh(&name));
        }
    }
    all
}

fn storage() -> Option<web_sys::Storage> {
    web_sys::window()?.local_storage().ok()?
}
