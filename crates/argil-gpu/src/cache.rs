//! What is compiled once, when it is first asked for.

use crate::GpuError;
use std::any::Any;
use std::sync::{Arc, Mutex, PoisonError};

/// Passes by name, each of its own type.
#[derive(Debug, Default)]
pub(crate) struct Cache(Mutex<Vec<(&'static str, Arc<dyn Any + Send + Sync>)>>);

impl Cache {
    /// What has a name, made if there is none yet.
    pub(crate) fn get<T: Any + Send + Sync>(
        &self,
        name: &'static str,
        make: impl FnOnce() -> Result<T, GpuError>,
    ) -> Result<Arc<T>, GpuError> {
        let all = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let find = |of: &Vec<(&'static str, Arc<dyn Any + Send + Sync>)>| {
            let mut named = of.iter().filter(|(known, _)| *known == name);
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
        all.push((name, made.clone()));
        Ok(made)
    }
}
