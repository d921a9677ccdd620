//! The browser's local storage, which keeps the scene between visits of the page.

use crate::browser::NamedBytes;
use anyhow::Context;
use base64::prelude::{BASE64_STANDARD, Engine as _};
use eframe::egui;
use std::cell::Cell;
use wasm_bindgen::prelude::*;
use web_sys::StorageEvent;

const KEY: &str = "argil-scene";

/// This key exists if the stored scene is saved nowhere else.
const UNSAVED: &str = "argil-scene-unsaved";

/// Duration without changes before a scene is stored.
const REST: std::time::Duration = std::time::Duration::from_millis(400);

thread_local! {
    static OTHERS: Cell<bool> = const { Cell::new(false) };
}

/// The stored scene.
pub(crate) struct LocalStorage {
    /// Version of the stored document, and whether it was saved.
    kept: (u64, bool),
    changed: Option<((u64, bool), web_time::Instant)>,
    /// Whether the user was told that another page stores another scene.
    has_told: bool,
}

impl LocalStorage {
    /// Creates an empty storage.
    pub(crate) fn new() -> Self {
        Self {
            kept: (0, false),
            changed: None,
            has_told: false,
        }
    }

    /// Returns the scene of an earlier visit.
    pub(crate) fn found() -> Option<String> {
        storage()?.get_item(KEY).ok()?
    }

    /// Returns true if the stored scene is saved nowhere else.
    pub(crate) fn is_unsaved() -> bool {
        let found = storage().and_then(|s| s.get_item(UNSAVED).ok()?);
        found.is_some()
    }

    /// Stores a scene once it has not changed for a while.
    ///
    /// # Errors
    /// If the browser refuses, or another page stores a scene.
    pub(crate) fn keep(
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

    /// Stores a scene at once, because the page may be about to close.
    ///
    /// # Errors
    /// As [`LocalStorage::keep`].
    pub(crate) fn keep_now(
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
                "another tab has opened Argil Studio, and the browser now stores the scene of that tab: save the changes here to a file"
            );
        }
        (self.kept, self.changed) = (what, None);
        let storage = storage()
            .context("the browser stores nothing for this page: save the scene to a file")?;
        let mark = if what.1 {
            storage.set_item(UNSAVED, "1")
        } else {
            storage.remove_item(UNSAVED)
        };
        mark.and_then(|()| storage.set_item(KEY, &text())).map_err(|_| {
            anyhow::anyhow!(
                "the scene is larger than the 5 MB that the browser stores for a page: save it to a file before you leave"
            )
        })
    }
}

/// Listens for other pages that store a scene.
pub(crate) fn listen_to_others() -> Result<(), JsValue> {
    let note = Closure::<dyn Fn(StorageEvent)>::new(|event: StorageEvent| {
        if event.key().as_deref() == Some(KEY) {
            OTHERS.set(true);
        }
    });
    let window = web_sys::window().ok_or_else(|| JsValue::from_str("there is no window"))?;
    window.add_event_listener_with_callback("storage", note.as_ref().unchecked_ref())?;
    // The listener lives as long as the page.
    note.forget();
    Ok(())
}

/// Moves an unreadable scene to another key, where it can be repaired.
pub(crate) fn quarantine(text: &str) {
    if let Some(storage) = storage() {
        // Without room for a second copy, it is lost.
        let _ = storage.set_item("argil-scene-unreadable", text);
    }
}

/// Prefix of the keys of stored meshes.
const MESH: &str = "argil-mesh:";

/// Stores a mesh file next to the scene.
///
/// # Errors
/// If the browser refuses.
pub(crate) fn keep_mesh((name, bytes): &NamedBytes) -> anyhow::Result<()> {
    let text = BASE64_STANDARD.encode(bytes);
    let kept = storage().map(|s| s.set_item(&format!("{MESH}{name}"), &text));
    if matches!(kept, Some(Ok(()))) {
        return Ok(());
    }
    anyhow::bail!(
        "{name} does not fit into the 5 MB that the browser stores for a page: open it again after a reload"
    )
}

/// Returns a stored mesh.
pub(crate) fn kept_mesh(name: &str) -> Option<NamedBytes> {
    let text = storage()?.get_item(&format!("{MESH}{name}")).ok()??;
    Some((name.into(), BASE64_STANDARD.decode(text).ok()?))
}

/// Returns the stored meshes that a scene names, and deletes the others.
pub(crate) fn kept_meshes(is_named: impl Fn(&str) -> bool) -> Vec<NamedBytes> {
    let Some(storage) = storage() else {
        return Vec::new();
    };
    let keys = (0..storage.length().unwrap_or(0)).filter_map(|i| storage.key(i).ok()?);
    let keys: Vec<String> = keys.filter(|key| key.starts_with(MESH)).collect();
    let mut all = Vec::new();
    for key in keys {
        let name = key[MESH.len()..].to_owned();
        if !is_named(&name) {
            // A leftover key does no harm.
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
