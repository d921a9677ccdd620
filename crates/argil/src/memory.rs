//! Checks memory before it is allocated.

use crate::{BuildError, Engine};
#[cfg(all(not(target_arch = "wasm32"), feature = "memory"))]
use std::sync::{LazyLock, Mutex, PoisonError};

/// Returns the smaller of a budget and the free memory, where volumes live in the machine's memory.
pub(crate) fn budget_on(engine: &Engine, budget: Option<u64>) -> Option<u64> {
    if engine.has_own_memory() {
        return budget;
    }
    match (budget, available_memory()) {
        (Some(budget), Some(free)) => Some(budget.min(free)),
        (budget, free) => budget.or(free),
    }
}

/// Turns an exceeded budget that nobody requested into a lack of memory.
pub(crate) fn without_budget(error: BuildError, requested: Option<u64>) -> BuildError {
    let Some([needed, available]) = error.exceeded_budget() else {
        return error;
    };
    if requested.is_some_and(|requested| available >= requested) {
        return error;
    }
    BuildError::Memory { needed, available }
}

/// Refuses work that needs more memory than is free.
pub(crate) fn check_memory(engine: &Engine, needed: u64) -> Result<(), BuildError> {
    if engine.has_own_memory() {
        return Ok(());
    }
    // A software GPU keeps its buffers in the same memory, next to the downloaded data.
    let needed = needed.saturating_mul(if engine.is_gpu() { 2 } else { 1 });
    match available_memory() {
        Some(available) if needed > available => Err(BuildError::Memory { needed, available }),
        // If the system does not report free memory, allow the work.
        _ => Ok(()),
    }
}

/// Returns the bytes of free memory, or `None` in a browser.
pub(crate) fn available_memory() -> Option<u64> {
    #[cfg(any(target_arch = "wasm32", not(feature = "memory")))]
    return None;
    #[cfg(all(not(target_arch = "wasm32"), feature = "memory"))]
    free_memory()
}

#[cfg(all(not(target_arch = "wasm32"), feature = "memory"))]
fn free_memory() -> Option<u64> {
    // Each edit asks, and creating a `System` takes longer than refreshing it.
    static SYSTEM: LazyLock<Mutex<sysinfo::System>> =
        LazyLock::new(|| Mutex::new(sysinfo::System::new()));
    let mut system = SYSTEM.lock().unwrap_or_else(PoisonError::into_inner);
    system.refresh_memory();
    Some(system.available_memory()).filter(|&bytes| bytes > 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use argil_volume::BricksError;

    #[test]
    fn a_budget_that_nobody_requested_is_the_machines_memory() {
        let exceeded = || {
            BuildError::Bricks(BricksError::Budget {
                bricks: 9,
                needed: 900,
                budget: 500,
            })
        };
        let found = without_budget(exceeded(), None);
        assert!(matches!(
            found,
            BuildError::Memory {
                needed: 900,
                available: 500
            }
        ));
        let found = without_budget(exceeded(), Some(600));
        assert!(matches!(found, BuildError::Memory { .. }));
        let found = without_budget(exceeded(), Some(500));
        assert!(matches!(found, BuildError::Bricks(_)));
    }

    #[test]
    fn what_no_machine_has_is_refused() {
        let refused = check_memory(&Engine::cpu(), u64::MAX);
        assert!(matches!(refused, Err(BuildError::Memory { .. })));
        assert!(check_memory(&Engine::cpu(), 1 << 20).is_ok());
    }
}
