//! Argil Studio: the editor, in a window and on a web page.
//!
//! *Practice.* The [`Studio`] owns a document. Every change of its scene is a line of a log, which a journal keeps
//! for recovery after a crash. A render thread follows the log with a world for each visible pipeline. The window
//! requests one image at a time and shows the last one. The user interface never blocks.

#![allow(
    missing_debug_implementations,
    reason = "a program's own types, which nobody prints"
)]

mod app;
mod bars;
#[cfg(target_arch = "wasm32")]
mod browser;
mod command_handlers;
mod commands;
mod dialog;
mod dialogs;
mod docs;
mod document;
mod document_edits;
mod drag;
mod files;
mod framing;
mod gallery;
mod gizmo;
mod grid;
mod icon;
mod inspector;
mod jobs;
mod keyframes;
mod level_refinement;
mod lighting;
#[cfg(target_arch = "wasm32")]
mod local_storage;
mod materials;
mod mesh_files;
mod meshes;
mod mirrors;
mod multi_edit;
mod names;
mod node_transform;
mod open_world;
mod opening;
mod outliner;
mod overlay;
mod picking;
mod pipeline;
mod preferences;
mod ready;
mod recovery;
mod render_request;
mod render_thread;
mod render_worker;
mod sample_scenes;
mod save_target;
mod sculpt;
mod sculpting;
mod segmented_control;
mod selection;
mod session;
mod stretch;
mod texture_pool;
mod textures;
mod tools;
#[cfg(not(target_arch = "wasm32"))]
mod traced_still;
mod values;
mod view;
mod viewport;
mod viewport_camera;
mod viewport_images;
mod viewport_renderer;
#[cfg(target_arch = "wasm32")]
mod web;
#[cfg(target_arch = "wasm32")]
mod web_files;
#[cfg(target_arch = "wasm32")]
mod web_world;
mod window_device;
mod world_files;

pub use app::{Options, Studio};
pub use document::Document;
pub use files::{FileAccess, FileRequest};
pub use window_device::{engine_of_window, share_device};
#[cfg(not(target_arch = "wasm32"))]
pub use world_files::is_world;

#[cfg(target_arch = "wasm32")]
pub use web::{fault, is_settled, message, start, widget_rect};

/// The machine has no screen, or no device for a window.
#[derive(Debug, thiserror::Error)]
#[error(
    "cannot open a window: {0}. The editor needs a screen and a Vulkan, Metal or Direct3D 12 device; a software device works too (on Debian and Ubuntu: mesa-vulkan-drivers)"
)]
pub struct NoWindow(String);

/// Opens the window, and returns after it is closed. If `outside` is true, meshes may lie outside the scene's
/// folder.
///
/// # Errors
/// If the window or its graphics device cannot be created.
#[cfg(not(target_arch = "wasm32"))]
pub fn run(
    backend: argil::Backend,
    scene: Option<std::path::PathBuf>,
    outside: bool,
) -> Result<(), NoWindow> {
    use eframe::egui::ViewportBuilder;
    let mut options = eframe::NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title("Argil Studio")
            .with_app_id("argil-studio")
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([640.0, 400.0])
            .with_drag_and_drop(true),
        ..eframe::NativeOptions::default()
    };
    share_device(&mut options.wgpu_options.wgpu_setup);
    let begin = move |cc: &eframe::CreationContext<'_>| -> Result<Box<dyn eframe::App>, _> {
        let engine = engine_of_window(cc.wgpu_render_state.as_ref(), backend)?;
        let studio_options = Options {
            engine,
            scene,
            outside,
            recovery: dirs::data_local_dir().map(|d| d.join("argil-studio").join("sessions")),
            files: Box::new(files::Native::default()),
        };
        Ok(Box::new(Studio::new(cc, studio_options)))
    };
    eframe::run_native("argil-studio", options, Box::new(begin))
        .map_err(|error| NoWindow(error.to_string()))
}
