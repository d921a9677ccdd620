//! The painter beside the window: on a thread of its own, or where there are none, between two frames.

use crate::painter::{Answer, Painter, Request};
use argil::{Engine, Scene};

enum Message {
    Load(Box<Scene>, u64),
    Follow(Vec<String>),
    Draw(Box<Request>),
}

fn take(painter: &mut Painter, message: Message) -> Option<Answer> {
    match message {
        Message::Load(scene, version) => painter.load(*scene, version),
        Message::Follow(lines) => painter.follow(&lines),
        Message::Draw(request) => return Some(painter.draw(*request)),
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
    }

    impl Place {
        pub fn new(mut painter: Painter, wake: impl Fn() + Send + 'static) -> Self {
            let (messages, inbox) = channel();
            let (outbox, answers) = channel();
            std::thread::spawn(move || {
                for message in inbox {
                    if let Some(answer) = take(&mut painter, message) {
                        if outbox.send(answer).is_err() {
                            return;
                        }
                        wake();
                    }
                }
            });
            Self { messages, answers }
        }

        pub fn send(&mut self, message: Message) {
            // It is gone only with the program.
            let _ = self.messages.send(message);
        }

        pub fn answer(&mut self) -> Option<Answer> {
            self.answers.try_recv().ok()
        }
    }
}

#[cfg(target_arch = "wasm32")]
mod place {
    use super::{Answer, Message, Painter, take};

    /// A painter that is asked at once.
    pub struct Place {
        painter: Painter,
        answer: Option<Answer>,
        wake: Box<dyn Fn()>,
    }

    impl Place {
        pub fn new(painter: Painter, wake: impl Fn() + Send + 'static) -> Self {
            Self {
                painter,
                answer: None,
                wake: Box::new(wake),
            }
        }

        pub fn send(&mut self, message: Message) {
            if let Some(answer) = take(&mut self.painter, message) {
                self.answer = Some(answer);
                (self.wake)();
            }
        }

        pub fn answer(&mut self) -> Option<Answer> {
            self.answer.take()
        }
    }
}

/// See the module's page.
pub struct Renderer {
    place: place::Place,
    device: String,
    /// What is being drawn.
    waiting: bool,
}

impl Renderer {
    /// On an engine; `wake` is called when there is an answer.
    pub fn new(engine: Engine, wake: impl Fn() + Send + 'static) -> Self {
        let device = engine.device();
        Self {
            place: place::Place::new(Painter::new(engine), wake),
            device,
            waiting: false,
        }
    }

    /// What it draws on.
    pub fn device(&self) -> &str {
        &self.device
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

    /// What came, if something did.
    pub fn answer(&mut self) -> Option<Answer> {
        let answer = self.place.answer();
        self.waiting &= answer.is_none();
        answer
    }
}
