//! The editor on a page: how it begins, and what a browser has in place of files.

use crate::app::{Options, Studio};
use crate::files::{Ask, Files};
use crate::given::Given;
use anyhow::Context;
use argil::{Backend, Engine};
use base64::prelude::{BASE64_STANDARD, Engine as _};
use eframe::egui;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use wasm_bindgen::prelude::*;
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_sys::{
    Blob, File, HtmlAnchorElement, HtmlCanvasElement, HtmlInputElement, KeyboardEvent,
    PointerEvent, StorageEvent, Url,
};

/// Files with what is in them, or why there are none.
type Arrived = anyhow::Result<Vec<Given>>;

thread_local! {
    static ARRIVED: RefCell<Vec<Arrived>> = const { RefCell::new(Vec::new()) };
    static SETTLED: Cell<bool> = const { Cell::new(false) };
    static OTHERS: Cell<bool> = const { Cell::new(false) };
    static TOLD: RefCell<String> = RefCell::default();
    static FOCUSED: RefCell<String> = RefCell::default();
    static PRESSURE: Cell<Option<f32>> = const { Cell::new(None) };
    static PLACES: RefCell<HashMap<String, [f32; 4]>> = RefCell::default();
}

/// Run the editor in a canvas.
///
/// # Errors
/// If the browser has no WebGPU device.
#[wasm_bindgen]
pub async fn start(canvas: HtmlCanvasElement) -> Result<(), JsValue> {
    let engine = Engine::on_async(Backend::Gpu)
        .await
        .map_err(|error| JsValue::from_str(&error.to_string()))?;
    listen_to_pens(&canvas)?;
    listen_to_others()?;
    hold_keys()?;
    let begin = move |cc: &eframe::CreationContext<'_>| -> Result<Box<dyn eframe::App>, _> {
        cc.egui_ctx.enable_accesskit();
        cc.egui_ctx.add_plugin(Places);
        let ctx = cc.egui_ctx.clone();
        let own = Options {
            engine,
            scene: None,
            outside: false,
            recovery: None,
            files: Box::new(Browser { ctx }),
        };
        Ok(Box::new(Studio::new(cc, own)) as Box<dyn eframe::App>)
    };
    let options = eframe::WebOptions::default();
    let runner = eframe::WebRunner::new();
    runner.start(canvas, options, Box::new(begin)).await
}

/// Take note of how hard a pen presses, which the toolkit does not tell.
fn listen_to_pens(canvas: &HtmlCanvasElement) -> Result<(), JsValue> {
    let note = Closure::<dyn Fn(PointerEvent)>::new(|event: PointerEvent| {
        let is_pen = event.pointer_type() == "pen";
        PRESSURE.set(is_pen.then(|| event.pressure()));
    });
    for what in ["pointerdown", "pointermove"] {
        canvas.add_event_listener_with_callback(what, note.as_ref().unchecked_ref())?;
    }
    // As long as the page is there.
    note.forget();
    Ok(())
}

/// How hard a pen presses, from 0 to 1, where it is a pen.
pub fn pen_pressure() -> Option<f32> {
    PRESSURE.get()
}

/// The rectangle of what is labelled so, in points of the canvas: left, top, width, height. For programs that drive the page.
#[wasm_bindgen]
pub fn place_of(label: &str) -> Option<Vec<f32>> {
    PLACES.with_borrow(|places| places.get(label).map(|place| place.to_vec()))
}

/// Whether the picture is of what there is, in full.
#[wasm_bindgen]
pub fn is_settled() -> bool {
    SETTLED.get()
}

/// What was told last, below the picture.
#[wasm_bindgen]
pub fn told() -> String {
    TOLD.with_borrow(String::clone)
}

/// Take note for [`is_settled`] and [`told`].
pub fn note(settled: bool, note: Option<&str>) {
    SETTLED.set(settled);
    TOLD.with_borrow_mut(|told| {
        if told != note.unwrap_or_default() {
            *told = note.unwrap_or_default().to_owned();
            speak(told);
        }
    });
}

/// Have a screen reader say something.
fn speak(text: &str) {
    let place = document().ok().and_then(|d| d.get_element_by_id("spoken"));
    if let Some(place) = place
        && place.text_content().as_deref() != Some(text)
    {
        place.set_text_content(Some(text));
    }
}

/// What has the keyboard, in words: its name, what it is, and its value.
fn words_of(node: &egui::accesskit::Node) -> Option<String> {
    let name = node.label().or(node.value())?;
    let mut words = vec![name.to_owned(), format!("{:?}", node.role()).to_lowercase()];
    words.extend(node.numeric_value().map(|value| value.to_string()));
    words.extend(node.toggled().map(|is| match is {
        egui::accesskit::Toggled::True => "on".into(),
        _ => "off".into(),
    }));
    Some(words.join(", "))
}

/// Notes where things are, and has what the keyboard is at said, as the toolkit gives screen readers nothing on a page.
struct Places;

impl egui::Plugin for Places {
    fn debug_name(&self) -> &'static str {
        "places"
    }

    fn output_hook(&mut self, ctx: &egui::Context, output: &mut egui::FullOutput) {
        let Some(update) = &output.platform_output.accesskit_update else {
            return;
        };
        let focused = update.nodes.iter().find(|(id, _)| *id == update.focus);
        if let Some(text) = focused.and_then(|(_, node)| words_of(node)) {
            FOCUSED.with_borrow_mut(|before| {
                if *before != text {
                    speak(&text);
                    *before = text;
                }
            });
        }
        let pixels = f64::from(ctx.pixels_per_point());
        PLACES.with_borrow_mut(|places| {
            places.clear();
            for (_, node) in &update.nodes {
                let is_text = node.role() == egui::accesskit::Role::Label;
                let label = node.label().or(node.value());
                if let (Some(label), Some(place), false) = (label, node.bounds(), is_text) {
                    let own = [place.x0, place.y0, place.width(), place.height()];
                    let points = own.map(|v| (v / pixels) as f32);
                    places.entry(label.to_owned()).or_insert(points);
                }
            }
        });
    }
}

/// Files that were chosen or dropped since the last time.
pub fn arrived() -> Vec<Arrived> {
    ARRIVED.with_borrow_mut(std::mem::take)
}

fn arrive(ctx: &egui::Context, files: Arrived) {
    ARRIVED.with_borrow_mut(|all| all.push(files));
    ctx.request_repaint();
}

/// Read files that were dropped on the page.
pub fn read_dropped(ctx: &egui::Context, files: Vec<egui::DroppedFileHandle>) {
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

/// The browser's own picker, and its downloads.
struct Browser {
    ctx: egui::Context,
}

impl Files for Browser {
    fn ask(&mut self, what: Ask, name: &str) -> Option<PathBuf> {
        if !matches!(what, Ask::Open | Ask::Import) {
            return Some(name.into());
        }
        // Scenes are opened with the meshes that they name.
        let meshes = Ask::Import.kind().1;
        let endings = what.kind().1.iter().chain(meshes);
        let accepted: Vec<String> = endings.map(|ending| format!(".{ending}")).collect();
        if let Err(error) = pick(&self.ctx, &accepted.join(",")) {
            arrive(&self.ctx, Err(said(&error)));
        }
        None
    }
}

fn said(error: &JsValue) -> anyhow::Error {
    anyhow::anyhow!("the browser says: {error:?}")
}

fn document() -> Result<web_sys::Document, JsValue> {
    let document = web_sys::window().and_then(|window| window.document());
    document.ok_or_else(|| JsValue::from_str("there is no page"))
}

fn pick(ctx: &egui::Context, accepted: &str) -> Result<(), JsValue> {
    let input: HtmlInputElement = document()?.create_element("input")?.dyn_into()?;
    input.set_type("file");
    input.set_multiple(true);
    input.set_accept(accepted);
    let (own, ctx) = (input.clone(), ctx.clone());
    let chosen = Closure::once_into_js(move || {
        let files: Vec<File> = own
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

/// Give bytes to the browser to be kept under a name.
///
/// # Errors
/// If it does not take them.
pub fn download(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
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

/// Let the page do what waits, and come back.
pub async fn breathe() {
    let turn = js_sys::Promise::new(&mut |done, _| {
        if let Some(window) = web_sys::window() {
            // Without a timer there is no coming back: go on at once then.
            if window.set_timeout_with_callback(&done).is_err() {
                let _ = done.call0(&JsValue::NULL);
            }
        }
    });
    let _ = JsFuture::from(turn).await;
}

/// The scene, from one visit of the page to the next.
pub struct Keeper {
    /// What is kept: the document's lines, and whether they are saved.
    kept: (u64, bool),
    changed: Option<((u64, bool), web_time::Instant)>,
    /// Whether it was told that another page keeps another scene.
    has_told: bool,
}

const KEY: &str = "argil-scene";
/// There where the kept scene is saved nowhere else.
const UNSAVED: &str = "argil-scene-unsaved";
/// So long nothing must change before a scene is kept.
const REST: std::time::Duration = std::time::Duration::from_millis(400);

impl Keeper {
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
    /// As [`Keeper::keep`].
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
fn listen_to_others() -> Result<(), JsValue> {
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

/// Have what browsers do by keys left to the editor, where it has something for them: reading them is not enough.
fn hold_keys() -> Result<(), JsValue> {
    let hold = Closure::<dyn Fn(KeyboardEvent)>::new(|event: KeyboardEvent| {
        let key = event.key();
        let is_held = event.ctrl_key() || event.meta_key();
        let is_function = ["F1", "F2", "F5", "F6", "F7"].contains(&key.as_str());
        let is_letter = ["d", "e", "g", "h", "i", "k"].contains(&key.as_str());
        if is_function || is_held && is_letter {
            event.prevent_default();
        }
    });
    document()?.add_event_listener_with_callback("keydown", hold.as_ref().unchecked_ref())?;
    // As long as the page is there.
    hold.forget();
    Ok(())
}

/// Keep a scene that cannot be read where it is not written over, for whoever can mend it.
pub fn set_aside(text: &str) {
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
pub fn keep_mesh((name, bytes): &Given) -> anyhow::Result<()> {
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
pub fn kept_mesh(name: &str) -> Option<Given> {
    let text = storage()?.get_item(&format!("{MESH}{name}")).ok()??;
    Some((name.into(), BASE64_STANDARD.decode(text).ok()?))
}

/// The meshes that were kept and that something names; the others are let go.
pub fn kept_meshes(is_named: impl Fn(&str) -> bool) -> Vec<Given> {
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
