//! The painter beside the window: on a thread of its own, or in a browser, where there is none, while it waits for the GPU.

use crate::painter::{Answer, Painter, Request};
use argil::{Engine, Scene};

enum Message {
    Load(Box<Scene>, u64),
    Follow(Vec<String>),
    Draw(Box<Request>),
}

async fn take(painter: &mut Painter, message: Message) -> Option<Answer> {
    match message {
        Message::Load(scene, version) => painter.load(*scene, version),
        Message::Follow(lines) => painter.follow(&lines),
        Message::Draw(request) => return Some(painter.draw(*request).await),
    }
    None
}

#[cfg(not(target_arch = "wasm32"))]
mod place {
    use super::{Answer, Message, Painter, take};
    use std::sync::mpsc::{Receiver, Sender, channel};

    /// A thread with a painter.
    pub struct Place {
        messages: Sender<Message>,
        answers: Receiver<Answer>,
        thread: std::thread::JoinHandle<()>,
    }

    impl Place {
        pub fn new(mut painter: Painter, wake: impl Fn() + Send + 'static) -> Self {
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

        pub fn send(&mut self, message: Message) {
            // It is gone only with the program.
            let _ = self.messages.send(message);
        }

        pub fn answer(&mut self) -> Option<Answer> {
            self.answers.try_recv().ok()
        }

        /// Whether it has ended by a fault.
        pub fn is_gone(&self) -> bool {
            self.thread.is_finished()
        }
    }
}

#[cfg(target_arch = "wasm32")]
mod place {
    use super::{Answer, Message, Painter, take};
    use std::cell::RefCell;
    use std::collections::VecDeque;
    use std::rc::Rc;

    /// A painter that goes on whenever the GPU has answered.
    pub struct Place {
        inner: Rc<RefCell<Inner>>,
        wake: Rc<dyn Fn()>,
    }

    struct Inner {
        /// Not here while it paints.
        painter: Option<Painter>,
        messages: VecDeque<Message>,
        answers: VecDeque<Answer>,
    }

    impl Place {
        pub fn new(painter: Painter, wake: impl Fn() + Send + 'static) -> Self {
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

        pub fn send(&mut self, message: Message) {
            let mut inner = self.inner.borrow_mut();
            inner.messages.push_back(message);
            if let Some(painter) = inner.painter.take() {
                let (inner, wake) = (self.inner.clone(), self.wake.clone());
                wasm_bindgen_futures::spawn_local(paint(inner, wake, painter));
            }
        }

        pub fn answer(&mut self) -> Option<Answer> {
            self.inner.borrow_mut().answers.pop_front()
        }

        /// A page ends as a whole.
        pub fn is_gone(&self) -> bool {
            false
        }
    }

    /// Take all messages, then put the painter back.
    async fn paint(inner: Rc<RefCell<Inner>>, wake: Rc<dyn Fn()>, mut painter: Painter) {
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

/// See the module's page.
pub struct Renderer {
    place: place::Place,
    device: String,
    most_pixels: u64,
    /// What is being drawn.
    waiting: bool,
}

impl Renderer {
    /// On an engine; `wake` is called when there is an answer.
    pub fn new(engine: Engine, wake: impl Fn() + Send + 'static) -> Self {
        let (device, most_pixels) = (engine.device(), engine.most_pixels());
        Self {
            place: place::Place::new(Painter::new(engine), wake),
            device,
            most_pixels,
            waiting: false,
        }
    }

    /// What it draws on.
    pub fn device(&self) -> &str {
        &self.device
    }

    /// Pixels of the largest picture.
    pub fn most_pixels(&self) -> u64 {
        self.most_pixels
    }

    /// Another scene, as it is after so many lines.
    pub fn load(&mut self, scene: &Scene, version: u64) {
        let message = Message::Load(Box::new(scene.clone()), version);
        self.place.send(message);
    }

    /// Lines of the document.
    pub fn follow(&mut self, lines: Vec<String>) {
        if !lines.is_empty() {
            self.place.send(Message::Follow(lines));
        }
    }

    /// Whether a request is on its way.
    pub fn is_busy(&self) -> bool {
        self.waiting
    }

    /// Draw; to be asked when it is not busy.
    pub fn draw(&mut self, request: Request) {
        self.waiting = true;
        self.place.send(Message::Draw(Box::new(request)));
    }

    /// Whether no picture will come any more.
    pub fn is_gone(&self) -> bool {
        self.place.is_gone()
    }

    /// What came, if something did.
    pub fn answer(&mut self) -> Option<Answer> {
        let answer = self.place.answer();
        self.waiting &= answer.is_none();
        answer
    }
}
