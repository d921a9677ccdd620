//! Drives the editor as a user would.

use argil::Backend;
use argil::scene::Scene;
use argil_studio::{FileAccess, FileRequest, Options, Studio, engine_of_window, share_device};
use eframe::egui::{self, Modifiers, PointerButton, Pos2, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::wgpu::default_wgpu_setup;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{Duration, Instant};

/// Answers to file dialogs, and the requests so far.
pub(crate) type Answers = Rc<RefCell<Vec<PathBuf>>>;

struct Scripted(Answers);

impl FileAccess for Scripted {
    fn ask(&mut self, _: FileRequest, _: &str) -> Option<PathBuf> {
        self.0.borrow_mut().pop()
    }
}

/// The editor in an offscreen window.
pub(crate) struct Desk {
    pub window: Harness<'static, Studio>,
    pub answers: Answers,
}

/// Options of a test's start.
#[derive(Default)]
pub(crate) struct Begin {
    pub scene: Option<PathBuf>,
    pub outside: bool,
    pub recovery: Option<PathBuf>,
    pub is_drawn: bool,
    /// Whether the engine is on the GPU of a window that is drawn.
    pub is_on_gpu: bool,
    /// Whether the window has a quarter of the pixels, though it is drawn.
    pub is_small: bool,
}

impl Desk {
    pub(crate) fn new(begin: Begin) -> Self {
        let answers = Answers::default();
        let files = Box::new(Scripted(answers.clone()));
        let mut builder = Harness::builder()
            .with_size(Vec2::new(1280.0, 800.0))
            .with_max_steps(64);
        // Where nobody looks at the picture, it has few pixels.
        if begin.is_small || !begin.is_drawn {
            builder = builder.with_pixels_per_point(0.5);
        }
        if begin.is_drawn {
            let mut setup = default_wgpu_setup();
            share_device(&mut setup);
            builder = builder.wgpu_setup(setup);
        }
        let backend = match begin.is_on_gpu {
            true => Backend::Gpu,
            false => Backend::Cpu,
        };
        let window = builder.build_eframe(|cc| {
            let engine = engine_of_window(cc.wgpu_render_state.as_ref(), backend);
            let options = Options {
                engine: engine.expect("an engine"),
                scene: begin.scene,
                outside: begin.outside,
                recovery: begin.recovery,
                files,
            };
            Studio::new(cc, options)
        });
        Self { window, answers }
    }

    pub(crate) fn studio(&self) -> &Studio {
        self.window.state()
    }

    pub(crate) fn scene(&self) -> &Scene {
        self.studio().document().scene()
    }

    /// Whether a widget has this label.
    pub(crate) fn has(&self, label: &str) -> bool {
        self.window.query_all_by_label(label).next().is_some()
    }

    /// Whether the editor offers to restore an earlier session.
    pub(crate) fn asks_to_bring_back(&self) -> bool {
        self.has("Restore")
    }

    /// Returns the reason why nothing is rendered.
    pub(crate) fn fault(&self) -> Option<&str> {
        self.studio().fault()
    }

    /// Leaves a session in a folder, as if another process had ended.
    pub(crate) fn crash(self, sessions: &Path) {
        let files = std::fs::read_dir(sessions).expect("a folder").flatten();
        let journal = files
            .map(|file| file.path())
            .find(|path| path.extension().is_some_and(|e| e == "journal"))
            .expect("a journal");
        for ending in ["journal", "origin", "saved"] {
            let other = sessions.join("4294967294-1").with_extension(ending);
            if journal.with_extension(ending).exists() {
                std::fs::copy(journal.with_extension(ending), other).expect("a copy");
            }
        }
    }

    /// Runs a few frames.
    pub(crate) fn step(&mut self) {
        self.window.run_steps(4);
    }

    /// Runs until the image shows the current scene.
    pub(crate) fn settle(&mut self) {
        let start = Instant::now();
        loop {
            self.window.run_steps(2);
            if self.studio().is_settled() {
                return;
            }
            assert!(
                start.elapsed() < Duration::from_secs(120),
                "no picture came"
            );
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Runs until a message contains a word.
    pub(crate) fn until_told(&mut self, word: &str) {
        let start = Instant::now();
        while !self.studio().note().is_some_and(|note| note.contains(word)) {
            self.window.run_steps(1);
            let note = self.studio().note();
            assert!(
                start.elapsed() < Duration::from_secs(120),
                "{word}: {note:?}"
            );
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    pub(crate) fn click(&mut self, label: &str) {
        self.node(label).click();
        self.step();
    }

    /// Runs a command through a menu.
    pub(crate) fn choose(&mut self, menu: &str, item: &str) {
        self.click(menu);
        self.click(item);
    }

    pub(crate) fn press(&mut self, modifiers: Modifiers, key: egui::Key) {
        self.window.key_press_modifiers(modifiers, key);
        self.step();
    }

    pub(crate) fn type_text(&mut self, text: &str) {
        self.window.event(egui::Event::Text(text.into()));
        self.step();
    }

    /// Returns the center of a widget.
    pub(crate) fn place_of(&self, label: &str) -> Pos2 {
        self.node(label).rect().center()
    }

    /// Returns the widget with a label that can be pressed or dragged. Text with the same words does not count.
    fn node<'a>(&'a self, label: &'a str) -> egui_kittest::Node<'a> {
        let text = egui::accesskit::Role::Label;
        let mut all = self.window.query_all_by_label(label);
        let found = all.find(|node| node.accesskit_node().role() != text);
        found.unwrap_or_else(|| panic!("there is no {label}"))
    }

    fn button(&mut self, at: Pos2, button: PointerButton, pressed: bool, modifiers: Modifiers) {
        self.window.event(egui::Event::ModifiersChanged(modifiers));
        self.window.event(egui::Event::PointerButton {
            pos: at,
            button,
            pressed,
            modifiers,
        });
    }

    /// Presses and holds.
    pub(crate) fn hold(&mut self, at: Pos2) {
        self.hold_with(at, Modifiers::NONE);
    }

    pub(crate) fn hold_with(&mut self, at: Pos2, modifiers: Modifiers) {
        self.window.event(egui::Event::PointerMoved(at));
        self.step();
        self.button(at, PointerButton::Primary, true, modifiers);
        self.window.run_steps(1);
    }

    pub(crate) fn move_to(&mut self, at: Pos2) {
        self.window.event(egui::Event::PointerMoved(at));
        self.step();
    }

    /// Releases the pointer.
    pub(crate) fn let_go(&mut self, at: Pos2) {
        self.button(at, PointerButton::Primary, false, Modifiers::NONE);
        self.step();
    }

    pub(crate) fn click_at(&mut self, at: Pos2, modifiers: Modifiers) {
        self.window.event(egui::Event::PointerMoved(at));
        self.step();
        self.button(at, PointerButton::Primary, true, modifiers);
        self.window.run_steps(1);
        self.button(at, PointerButton::Primary, false, modifiers);
        self.step();
        self.window
            .event(egui::Event::ModifiersChanged(Modifiers::NONE));
    }

    /// Presses, moves over a few places, and releases.
    pub(crate) fn drag(&mut self, from: Pos2, to: Pos2, modifiers: Modifiers) {
        self.window.event(egui::Event::PointerMoved(from));
        self.step();
        self.button(from, PointerButton::Primary, true, modifiers);
        self.window.run_steps(1);
        for i in 1..=8 {
            let at = from + (to - from) * (i as f32 / 8.0);
            self.window.event(egui::Event::PointerMoved(at));
            self.window.run_steps(1);
        }
        self.button(to, PointerButton::Primary, false, modifiers);
        self.step();
        self.window
            .event(egui::Event::ModifiersChanged(Modifiers::NONE));
    }
}
