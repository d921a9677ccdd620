//! The editor on a web page: its start, and functions for programs that drive the page.

use crate::app::{Options, Studio};
use crate::browser::{self, Browser, document, listen_to_pens, speak};
use crate::local_storage::listen_to_others;
use crate::window_device::{engine_of_window, share_device};
use argil::Backend;
use eframe::egui;
use std::cell::RefCell;
use std::collections::HashMap;
use wasm_bindgen::prelude::*;
use web_sys::{HtmlCanvasElement, KeyboardEvent};

thread_local! {
    static FOCUSED: RefCell<String> = RefCell::default();
    static PLACES: RefCell<HashMap<String, [f32; 4]>> = RefCell::default();
}

/// Runs the editor in a canvas.
///
/// # Errors
/// If the browser has no WebGPU device.
#[wasm_bindgen]
pub async fn start(canvas: HtmlCanvasElement) -> Result<(), JsValue> {
    listen_to_pens(&canvas)?;
    listen_to_others()?;
    hold_keys()?;
    let begin = move |cc: &eframe::CreationContext<'_>| -> Result<Box<dyn eframe::App>, _> {
        cc.egui_ctx.enable_accesskit();
        cc.egui_ctx.add_plugin(Places);
        let ctx = cc.egui_ctx.clone();
        let engine = engine_of_window(cc.wgpu_render_state.as_ref(), Backend::Gpu)?;
        let studio_options = Options {
            engine,
            scene: None,
            outside: false,
            recovery: None,
            files: Box::new(Browser { ctx }),
        };
        Ok(Box::new(Studio::new(cc, studio_options)) as Box<dyn eframe::App>)
    };
    let mut options = eframe::WebOptions::default();
    share_device(&mut options.wgpu_options.wgpu_setup);
    let runner = eframe::WebRunner::new();
    runner.start(canvas, options, Box::new(begin)).await
}

/// Returns the rectangle of the widget with a label, in points of the canvas: left, top, width, height.
#[wasm_bindgen]
pub fn widget_rect(label: &str) -> Option<Vec<f32>> {
    PLACES.with_borrow(|places| places.get(label).map(|place| place.to_vec()))
}

/// Returns true if the final image of the current document is shown.
#[wasm_bindgen]
pub fn is_settled() -> bool {
    browser::settled()
}

/// Returns the last message.
#[wasm_bindgen]
pub fn message() -> String {
    browser::message()
}

/// Returns the reason why nothing can be rendered, or an empty string.
#[wasm_bindgen]
pub fn fault() -> String {
    browser::fault()
}

/// Describes the widget with the keyboard focus: name, role and value.
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

/// Records the positions of widgets, and announces the focused widget, because egui supports no screen readers on a
/// page.
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
                    let bounds = [place.x0, place.y0, place.width(), place.height()];
                    let points = bounds.map(|v| (v / pixels) as f32);
                    places.entry(label.to_owned()).or_insert(points);
                }
            }
        });
    }
}

/// Prevents the browser from handling keys that the editor uses: reading them is not enough.
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
    // The listener lives as long as the page.
    hold.forget();
    Ok(())
}
