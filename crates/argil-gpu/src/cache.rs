//! What is compiled once, when it is first asked for.

use crate::GpuError;
use std::any::Any;
use std::sync::{Arc, Mutex, PoisonError};

/// The name of passes, and a number that tells variants apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PassKey(&'static str, u32);

impl From<&'static str> for PassKey {
    fn from(name: &'static str) -> Self {
        Self(name, 0)
    }
}

impl From<(&'static str, u32)> for PassKey {
    fn from((name, variant): (&'static str, u32)) -> Self {
        Self(name, variant)
    }
}

/// Passes by key, each of its own type.
#[derive(Debug, Default)]
pub(crate) struct Cache(Mutex<Vec<(PassKey, Arc<dyn Any + Send + Sync>)>>);

/// A clone has what was made so far.
impl Clone for Cache {
    fn clone(&self) -> Self {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        Self(Mutex::new(all.clone()))
    }
}

impl Cache {
    /// Returns what has a key, made if there is none yet.
    pub(crate) fn get<T: Any + Send + Sync>(
        &self,
        key: PassKey,
        make: impl FnOnce() -> Result<T, GpuError>,
    ) -> Result<Arc<T>, GpuError> {
        let all = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let find = |of: &Vec<(PassKey, Arc<dyn Any + Send + Sync>)>| {
            let mut named = of.iter().filter(|(known, _)| *known == key);
            named.find_map(|(_, made)| made.clone().downcast::<T>().ok())
        };
        if let Some(made) = find(&all()) {
            return Ok(made);
        }
        // Nobody waits for what another compiles: who comes second drops what it has made.
        let made = Arc::new(make()?);
        let mut all = all();
        if let Some(first) = find(&all) {
            return Ok(first);
        }
        all.push((key, made.clone()));
        Ok(made)
    }
}
