//! Callbacks that a world calls when boxes of it change.

use argil_math::Aabb;

/// Identifies a subscription, to end it with [`World::unsubscribe`](crate::World::unsubscribe).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SubscriptionId(u64);

type Callback = Box<dyn FnMut(&[Aabb]) + Send + Sync>;

#[derive(Default)]
pub(crate) struct Observers {
    callbacks: Vec<(SubscriptionId, Callback)>,
    last_id: u64,
}

impl std::fmt::Debug for Observers {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Observers").finish_non_exhaustive()
    }
}

impl Observers {
    pub(crate) fn add(&mut self, callback: Callback) -> SubscriptionId {
        self.last_id += 1;
        let id = SubscriptionId(self.last_id);
        self.callbacks.push((id, callback));
        id
    }

    /// Returns whether there was such a subscription.
    pub(crate) fn remove(&mut self, id: SubscriptionId) -> bool {
        let before = self.callbacks.len();
        self.callbacks
            .retain(|(subscription, _)| *subscription != id);
        self.callbacks.len() < before
    }

    /// Calls every callback with boxes that changed, unless there are none.
    pub(crate) fn notify(&mut self, boxes: &[Aabb]) {
        if !boxes.is_empty() {
            self.callbacks
                .iter_mut()
                .for_each(|(_, callback)| callback(boxes));
        }
    }
}
