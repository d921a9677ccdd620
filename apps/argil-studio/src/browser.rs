//! The browser's counterparts of files, pens and a status bar.

use crate::files::{FileAccess, FileRequest};
use eframe::egui;
use std::cell::{Cell, RefCell};
use std::path::{Path, PathBuf};
use wasm_bindgen::prelude::*;
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_sys::{
    Blob, File, HtmlAnchorElement, HtmlCanvasElement, HtmlInputElement, PointerEvent, Url,
};

/// A file's name and contents.
pub(crate) type NamedBytes = (String, Vec<u8>);

/// Files with their contents, or the reason why there are none.
pub(crate) type Arrived = anyhow::Result<Vec<NamedBytes>>;

thread_local! {
    static ARRIVED: RefCell<Vec<Arrived>> = const { RefCell::new(Vec::new()) };
    static SETTLED: Cell<bool> = const { Cell::new(false) };
    static MESSAGE: RefCell<String> = RefCell::default();
    static FAULT: RefCell<String> = RefCell::default();
    static PRESSURE: Cell<Option<f32>> = const { Cell::new(None) };
}

/// Listens to pen pressure, which egui does not report.
pub(crate) fn listen_to_pens(canvas: &HtmlCanvasElement) -> Result<(), JsValue> {
    let note = Closure::<dyn Fn(PointerEvent)>::new(|event: PointerEvent| {
        let is_pen = event.pointer_type() == "pen";
        PRESSURE.set(is_pen.then(|| event.pressure()));
    });
    for what in ["pointerdown", "pointermove"] {
        canvas.add_event_listener_with_callback(what, note.as_ref().unchecked_ref())?;
    }
    // The listener lives as long as the page.
    note.forget();
    Ok(())
}

/// Returns the pressure of a pen from 0 to 1, or `None` for other pointers.
pub(crate) fn pen_pressure() -> Option<f32> {
    PRESSURE.get()
}

/// Stores the state for [`settled`], [`message`] and [`fault`].
pub(crate) fn store_state(settled: bool, message: Option<&str>, fault: Option<&str>) {
    SETTLED.set(settled);
    MESSAGE.with_borrow_mut(|last| {
        if last != message.unwrap_or_default() {
            *last = message.unwrap_or_default().to_owned();
            speak(last);
        }
    });
    FAULT.set(fault.unwrap_or_default().to_owned());
}

/// Announces text through a screen reader.
pub(crate) fn speak(text: &str) {
    let place = document().ok().and_then(|d| d.get_element_by_id("spoken"));
    if let Some(place) = place
        && place.text_content().as_deref() != Some(text)
    {
        place.set_text_content(Some(text));
    }
}

/// Returns the files that were chosen or dropped since the last call.
pub(crate) fn arrived() -> Vec<Arrived> {
    ARRIVED.with_borrow_mut(std::mem::take)
}

pub(crate) fn arrive(ctx: &egui::Context, files: Arrived) {
    ARRIVED.with_borrow_mut(|all| all.push(files));
    ctx.request_repaint();
}

/// Reads files that were dropped on the page.
pub(crate) fn read_dropped(ctx: &egui::Context, files: Vec<egui::DroppedFileHandle>) {
    let ctx = ctx.clone();
    spawn_local(async move {
        let mut read = Vec::new();
        for file in files {
            let name = file.path().to_string_lossy().into_owned();
            match file.bytes_async().await {
                Ok(bytes) => read.push((name, bytes)),
                Err(error) => {
                    let error = anyhow::anyhow!("{name}: {error}");
                    return arrive(&ctx, Err(error));
                }
            }
        }
        arrive(&ctx, Ok(read));
    });
}

/// The browser's file picker and downloads.
pub(crate) struct Browser {
    /// The context to repaint when files arrive.
    pub ctx: egui::Context,
}

impl FileAccess for Browser {
    fn ask(&mut self, what: FileRequest, name: &str) -> Option<PathBuf> {
        if !matches!(what, FileRequest::Open | FileRequest::Import) {
            return Some(name.into());
        }
        // Scenes are opened together with the meshes that they name.
        let meshes = FileRequest::Import.kind().1;
        let endings = what.kind().1.iter().chain(meshes);
        let accepted: Vec<String> = endings.map(|ending| format!(".{ending}")).collect();
        if let Err(error) = pick(&self.ctx, &accepted.join(",")) {
            arrive(&self.ctx, Err(said(&error)));
        }
        None
    }
}

pub(crate) fn said(error: &JsValue) -> anyhow::Error {
    anyhow::anyhow!("the browser reports: {error:?}")
}

pub(crate) fn document() -> Result<web_sys::Document, JsValue> {
    let document = web_sys::window().and_then(|window| window.document());
    document.ok_or_else(|| JsValue::from_str("there is no page"))
}

pub(crate) fn pick(ctx: &egui::Context, accepted: &str) -> Result<(), JsValue> {
    let input: HtmlInputElement = document()?.create_element("input")?.dyn_into()?;
    input.set_type("file");
    input.set_multiple(true);
    input.set_accept(accepted);
    let (chosen_input, ctx) = (input.clone(), ctx.clone());
    let chosen = Closure::once_into_js(move || {
        let files: Vec<File> = chosen_input
            .files()
            .map(|list| (0..list.length()).filter_map(|i| list.get(i)).collect())
            .unwrap_or_default();
        spawn_local(async move {
            let mut read = Vec::new();
            for file in files {
                match JsFuture::from(file.array_buffer()).await {
                    Ok(buffer) => {
                        read.push((file.name(), js_sys::Uint8Array::new(&buffer).to_vec()));
                    }
                    Err(error) => {
                        let error = said(&error).context(file.name());
                        return arrive(&ctx, Err(error));
                    }
                }
            }
            arrive(&ctx, Ok(read));
        });
    });
    input.set_onchange(Some(chosen.unchecked_ref()));
    input.click();
    Ok(())
}

/// Downloads bytes under a name.
///
/// # Errors
/// If the browser refuses.
pub(crate) fn download(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let give = || -> Result<(), JsValue> {
        let parts = js_sys::Array::of1(&js_sys::Uint8Array::from(bytes));
        let url = Url::create_object_url_with_blob(&Blob::new_with_u8_array_sequence(&parts)?)?;
        let link: HtmlAnchorElement = document()?.create_element("a")?.dyn_into()?;
        link.set_href(&url);
        link.set_download(&name);
        link.click();
        Url::revoke_object_url(&url)
    };
    give().map_err(|error| std::io::Error::other(said(&error)))
}

/// Yields to the browser's event loop.
pub(crate) async fn breathe() {
    let turn = js_sys::Promise::new(&mut |done, _| {
        if let Some(window) = web_sys::window() {
            // Without a timer the loop cannot be resumed: continue at once.
            if window.set_timeout_with_callback(&done).is_err() {
                let _ = done.call0(&JsValue::NULL);
            }
        }
    });
    let _ = JsFuture::from(turn).await;
}

/// Returns true if the final image of the current document was shown at the last update.
pub(crate) fn settled() -> bool {
    SETTLED.get()
}

/// Returns the last message at the last update.
pub(crate) fn message() -> String {
    MESSAGE.with_borrow(String::clone)
}

/// Returns the reason why nothing could be rendered at the last update, or an empty string.
pub(crate) fn fault() -> String {
    FAULT.with_borrow(String::clone)
}
