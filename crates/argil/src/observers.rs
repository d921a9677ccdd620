//! Who is told of changes.

use argil_math::Aabb;

/// A listener of a world, to be taken away by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SubscriptionId(u64);

type Call = Box<dyn FnMut(&[Aabb]) + Send + Sync>;

#[derive(Default)]
pub(crate) struct Observers {
    all: Vec<(SubscriptionId, Call)>,
    given: u64,
}

impl Observers {
    pub fn add(&mut self, call: Call) -> SubscriptionId {
        self.given += 1;
        let listener = SubscriptionId(self.given);
        self.all.push((listener, call));
        listener
    }

    pub fn remove(&mut self, listener: SubscriptionId) -> bool {
        let before = self.all.len();
        self.all.retain(|(own, _)| *own != listener);
        self.all.len() < before
    }

    pub fn notify(&mut self, boxes: &[Aabb]) {
        if !boxes.is_empty() {
            self.all.iter_mut().for_each(|(_, call)| call(boxes));
        }
    }
}
