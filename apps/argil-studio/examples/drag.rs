//! From input to picture: csg20 as bricks of 256³ in a view of 1280×720, a brush dragged by its handle.
//! `cargo run --release -p argil-studio --example drag -- cpu|gpu`

use anyhow::Context;
use argil::{Backend, Engine};
use argil_studio::{FileAccess, FileRequest, Options, Studio, engine_of_window, share_device};
use eframe::egui::{self, Pos2, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use egui_kittest::wgpu::default_wgpu_setup;
use std::path::PathBuf;
use std::time::{Duration, Instant};

struct NoFiles;

impl FileAccess for NoFiles {
    fn ask(&mut self, _: FileRequest, _: &str) -> Option<PathBuf> {
        None
    }
}

type Window = Harness<'static, Studio>;

fn settle(window: &mut Window) {
    while !window.state().is_settled() {
        window.run_steps(1);
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn click(window: &mut Window, label: &str) {
    window.get_by_label(label).click();
    window.run_steps(4);
    settle(window);
}

fn median(all: &mut [f64]) -> f64 {
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
}

fn press(window: &Window, at: Pos2, pressed: bool) {
    window.event(egui::Event::PointerButton {
        pos: at,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: egui::Modifiers::NONE,
    });
}

/// Opens the editor on a back end.
fn opened(backend: Backend) -> Window {
    let begin = move |cc: &mut eframe::CreationContext<'_>| {
        let engine = engine_of_window(cc.wgpu_render_state.as_ref(), backend);
        let engine = engine.unwrap_or_else(|error| {
            eprintln!("{error}: on the CPU");
            Engine::cpu()
        });
        println!("{}", engine.device());
        let options = Options {
            engine,
            scene: Some("scenes/csg20.json".into()),
            outside: false,
            recovery: None,
            files: Box::new(NoFiles),
        };
        Studio::new(cc, options)
    };
    let mut setup = default_wgpu_setup();
    share_device(&mut setup);
    // The panels around the view take 500 × 75 points.
    Harness::builder()
        .with_size(Vec2::new(1780.0, 795.0))
        .wgpu_setup(setup)
        .build_eframe(begin)
}

fn main() -> anyhow::Result<()> {
    let backend = match std::env::args().nth(1).as_deref() {
        Some("gpu") => Backend::Gpu,
        _ => Backend::Cpu,
    };
    let mut window = opened(backend);
    settle(&mut window);
    click(&mut window, "Resolution");
    click(&mut window, "256 voxels");
    let view = window.get_by_label("Viewport").rect();
    println!("a view of {:.0}×{:.0}", view.width(), view.height());

    let scene = window.state().document().scene();
    let node = scene.node(argil::scene::Scene::ROOT).children()[2];
    window.state_mut().document_mut().select(Some(node), false);
    window.key_press(egui::Key::F);
    window.key_press(egui::Key::W);
    window.run_steps(4);
    settle(&mut window);
    let mut still = Vec::new();
    for i in 0..8 {
        // A key turns the view: the picture after it is a still one.
        let key = [egui::Key::F5, egui::Key::F6][i % 2];
        window.key_press(key);
        window.run_steps(2);
        settle(&mut window);
        still.extend(window.state().shown().map(|(_, _, ms)| ms));
    }
    let still = median(&mut still);

    let middle = window.get_by_label("Viewport").rect().center();
    window.event(egui::Event::PointerMoved(middle));
    window.run_steps(2);
    press(&window, middle, true);
    window.run_steps(1);
    let mut moving = Vec::new();
    for i in 1..=20 {
        let before = window.state().version();
        let start = Instant::now();
        window.event(egui::Event::PointerMoved(
            middle + Vec2::new(i as f32, 0.5 * i as f32),
        ));
        window.run_steps(1);
        while window
            .state()
            .shown()
            .is_none_or(|(seen, _, _)| seen <= before)
        {
            anyhow::ensure!(start.elapsed() < Duration::from_secs(60), "no picture came");
            window.run_steps(1);
            std::thread::sleep(Duration::from_micros(200));
        }
        moving.push(start.elapsed().as_secs_f64() * 1e3);
    }
    press(&window, middle, false);
    window.run_steps(2);
    let worst = moving.iter().copied().reduce(f64::max).context("a drag")?;
    let moving = median(&mut moving);
    println!(
        "a still picture takes {still:.1} ms, from input to picture {moving:.1} ms: {:.2}; at worst {worst:.1} ms: {:.2}",
        moving / still,
        worst / still
    );
    println!("expected: no more than 1.5");
    Ok(())
}
