//! The render thread. In a browser, which has no threads, rendering continues whenever the GPU has finished.

use crate::render_worker::{RenderAnswer, RenderRequest, RenderWorker, StoredPages};
use crate::texture_pool::TexturePool;
use argil::Engine;
use argil::gpu::wgpu;
use argil::scene::{Action, Scene};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use web_time::Instant;

enum Message {
    Load(Box<Scene>, u64, Option<StoredPages>),
    Follow(Vec<Action>),
    Time(f32),
    Draw(Box<RenderRequest>),
}

async fn take(painter: &mut RenderWorker, message: Message) -> Option<RenderAnswer> {
    match message {
        Message::Load(scene, version, pages) => painter.load(*scene, version, pages).await,
        Message::Follow(actions) => painter.follow(&actions),
        Message::Time(time) => painter.set_time(time),
        Message::Draw(request) => return Some(painter.draw(*request).await),
    }
    None
}

#[cfg(not(target_arch = "wasm32"))]
mod place {
    use super::{Message, RenderAnswer, RenderWorker, take};
    use std::sync::mpsc::{Receiver, Sender, channel};

    /// A thread with a render worker.
    pub(super) struct Place {
        messages: Sender<Message>,
        answers: Receiver<RenderAnswer>,
        thread: std::thread::JoinHandle<()>,
    }

    impl Place {
        pub(super) fn new(mut painter: RenderWorker, wake: impl Fn() + Send + 'static) -> Self {
            let (messages, inbox) = channel();
            let (outbox, answers) = channel();
            let thread = std::thread::spawn(move || {
                for message in inbox {
                    if let Some(answer) = pollster::block_on(take(&mut painter, message)) {
                        if outbox.send(answer).is_err() {
                            return;
                        }
                        wake();
                    }
                }
            });
            Self {
                messages,
                answers,
                thread,
            }
        }

        pub(super) fn send(&mut self, message: Message) {
            // The thread ends only with the program.
            let _ = self.messages.send(message);
        }

        pub(super) fn answer(&mut self) -> Option<RenderAnswer> {
            self.answers.try_recv().ok()
        }

        /// Returns true if it has ended because of a panic.
        pub(super) fn is_gone(&self) -> bool {
            self.thread.is_finished()
        }
    }
}

#[cfg(target_arch = "wasm32")]
mod place {
    use super::{Message, RenderAnswer, RenderWorker, take};
    use std::cell::RefCell;
    use std::collections::VecDeque;
    use std::rc::Rc;

    /// A render worker that continues whenever the GPU has finished.
    pub(crate) struct Place {
        inner: Rc<RefCell<Inner>>,
        wake: Rc<dyn Fn()>,
    }

    struct Inner {
        /// The worker; `None` while it renders.
        painter: Option<RenderWorker>,
        messages: VecDeque<Message>,
        answers: VecDeque<RenderAnswer>,
    }

    impl Place {
        pub(crate) fn new(painter: RenderWorker, wake: impl Fn() + Send + 'static) -> Self {
            let inner = Inner {
                painter: Some(painter),
                messages: VecDeque::new(),
                answers: VecDeque::new(),
            };
            Self {
                inner: Rc::new(RefCell::new(inner)),
                wake: Rc::new(wake),
            }
        }

        pub(crate) fn send(&mut self, message: Message) {
            let mut inner = self.inner.borrow_mut();
            inner.messages.push_back(message);
            if let Some(painter) = inner.painter.take() {
                let (inner, wake) = (self.inner.clone(), self.wake.clone());
                wasm_bindgen_futures::spawn_local(paint(inner, wake, painter));
            }
        }

        pub(crate) fn answer(&mut self) -> Option<RenderAnswer> {
            self.inner.borrow_mut().answers.pop_front()
        }

        /// A page ends as a whole.
        pub(crate) fn is_gone(&self) -> bool {
            false
        }
    }

    /// Handles all messages, then returns the worker.
    async fn paint(inner: Rc<RefCell<Inner>>, wake: Rc<dyn Fn()>, mut painter: RenderWorker) {
        loop {
            let message = inner.borrow_mut().messages.pop_front();
            let Some(message) = message else {
                inner.borrow_mut().painter = Some(painter);
                return;
            };
            if let Some(answer) = take(&mut painter, message).await {
                inner.borrow_mut().answers.push_back(answer);
                wake();
            }
        }
    }
}

/// The render thread.
pub(crate) struct RenderThread {
    engine: Engine,
    /// The window's device, if the engine is on it.
    device: Option<wgpu::Device>,
    place: place::Place,
    wake: Arc<dyn Fn() + Send + Sync>,
    is_building: Arc<AtomicBool>,
    /// The request in progress, and its start.
    waiting: Option<(RenderRequest, Instant)>,
}

impl RenderThread {
    /// Starts on an engine. `wake` is called when an answer is ready. Images stay on the device of a window, if the engine is on
    /// it.
    pub(crate) fn new(
        engine: Engine,
        window: Option<&wgpu::Device>,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let device = window.filter(|device| engine.is_on(device)).cloned();
        Self::with(engine, device, Arc::new(wake))
    }

    fn with(
        engine: Engine,
        device: Option<wgpu::Device>,
        wake: Arc<dyn Fn() + Send + Sync>,
    ) -> Self {
        let textures = device.clone().map(TexturePool::new);
        let painter = RenderWorker::new(engine.clone(), textures);
        let wake_window = wake.clone();
        Self {
            engine,
            device,
            is_building: painter.is_building(),
            place: place::Place::new(painter, move || wake_window()),
            wake,
            waiting: None,
        }
    }

    /// Restarts with a scene, and discards the request in progress, which ends in the background.
    pub(crate) fn abandon(&mut self, scene: &Scene, version: u64) {
        *self = Self::with(self.engine.clone(), self.device.clone(), self.wake.clone());
        self.load(scene, version, None);
    }

    /// Returns the name of the device.
    pub(crate) fn device(&self) -> String {
        self.engine.device()
    }

    /// Returns the maximum number of pixels per image.
    pub(crate) fn max_pixels(&self) -> u64 {
        self.engine.max_pixels()
    }

    /// Loads another scene, at a version, or one whose world is in a store.
    pub(crate) fn load(&mut self, scene: &Scene, version: u64, pages: Option<StoredPages>) {
        let message = Message::Load(Box::new(scene.replica()), version, pages);
        self.place.send(message);
    }

    /// Applies actions of the document.
    pub(crate) fn follow(&mut self, actions: Vec<Action>) {
        if !actions.is_empty() {
            self.place.send(Message::Follow(actions));
        }
    }

    /// Sets the time of keyframes.
    pub(crate) fn set_time(&mut self, time: f32) {
        self.place.send(Message::Time(time));
    }

    /// Returns true if a request is in progress.
    pub(crate) fn is_busy(&self) -> bool {
        self.waiting.is_some()
    }

    /// Returns the request that waits for a build, and for how long.
    pub(crate) fn is_building(&self) -> Option<(&RenderRequest, Duration)> {
        let (request, since) = self.waiting.as_ref()?;
        let is_building = self.is_building.load(Ordering::Relaxed);
        is_building.then(|| (request, since.elapsed()))
    }

    /// Sends a request. No other request may be in progress.
    pub(crate) fn draw(&mut self, request: RenderRequest) {
        self.waiting = Some((request.clone(), Instant::now()));
        self.place.send(Message::Draw(Box::new(request)));
    }

    /// Returns true if no more images will arrive.
    pub(crate) fn is_gone(&self) -> bool {
        self.place.is_gone()
    }

    /// Returns an answer, if one has arrived.
    pub(crate) fn answer(&mut self) -> Option<RenderAnswer> {
        let answer = self.place.answer();
        if answer.is_some() {
            self.waiting = None;
        }
        answer
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::Pipeline;
    use crate::sample_scenes::first;
    use crate::viewport_camera::ViewportCamera;
    use argil::render::RenderMode;

    #[test]
    fn nothing_comes_of_what_is_abandoned() {
        let request = |pipeline, resolution| RenderRequest {
            pipelines: vec![pipeline],
            show: RenderMode::Normal,
            resolution,
            camera: ViewportCamera::default().camera(),
            size: [40, 30],
            is_still: true,
            traces_paths: false,
            counts_rays: false,
            version: 0,
        };
        let mut renderer = RenderThread::new(Engine::cpu(), None, || {});
        renderer.load(&first(), 0, None);
        let dense = Pipeline::all().find(|known| known.label() == "Dense");
        renderer.draw(request(dense.expect("a dense volume"), 256));
        renderer.abandon(&first(), 0);
        assert!(!renderer.is_busy());
        let wanted = request(Pipeline::field(), 32);
        renderer.draw(wanted.clone());
        let answer = loop {
            match renderer.answer() {
                Some(answer) => break answer,
                None => std::thread::sleep(Duration::from_millis(2)),
            }
        };
        assert_eq!(answer.request, wanted);
        assert_eq!(answer.pictures.expect("a picture").len(), 1);
        assert!(!renderer.is_busy() && renderer.answer().is_none());
    }
}
