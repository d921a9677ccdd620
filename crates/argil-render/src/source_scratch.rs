//! Buffers that only some code needs.

use std::any::Any;

/// Buffers that only one kind of source needs, created when first asked for.
#[derive(Debug, Default)]
pub(crate) struct SourceScratch(Vec<Box<dyn Any + Send>>);

impl SourceScratch {
    /// Returns the buffers of a type.
    pub(crate) fn of<T: Default + Send + 'static>(&mut self) -> &mut T {
        let place = self.0.iter().position(|one| one.is::<T>());
        let place = place.unwrap_or_else(|| {
            self.0.push(Box::new(T::default()));
            self.0.len() - 1
        });
        let scratch = self.0[place].downcast_mut();
        scratch.expect("the place was found by its type")
    }
}
