//! The levels from which the light of sparse bricks reads distances: baked for the first shaded image, and then kept up
//! by edits.

use argil_field::{IncrementalProgram, Program};
use argil_volume::{BrickLayout, Levels, LightLevels};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Maximum brushes. Coarse bricks among more of them each depend on thousands, and take longer than the bricks themselves:
/// 16 s for the 100,000 blocks of the city.
const MAX_BRUSHES: usize = 16_384;

/// The levels of a world, if a shaded image needed them.
#[derive(Debug, Default)]
pub(crate) struct Light {
    state: Mutex<Option<LightLevels>>,
}

impl Light {
    /// Bakes the levels for bricks of a layout, unless they do not fit into memory or there are too many brushes.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn baked(program: &Program, bricks: &BrickLayout) -> Self {
        let light = Self::default();
        light.levels(program, None, bricks);
        light
    }

    /// Whether an image needed the levels.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn is_baked(&self) -> bool {
        self.lock().is_some()
    }

    /// Returns the levels for bricks of a layout, after all edits. Returns `None` if they do not fit into memory, or if there
    /// are too many brushes: light then reads what the bricks store.
    pub(crate) fn levels(
        &self,
        program: &Program,
        live: Option<&IncrementalProgram>,
        bricks: &BrickLayout,
    ) -> Option<Arc<Levels>> {
        if program.brush_count() > MAX_BRUSHES {
            return None;
        }
        // Not while the lock is held: baking waits for threads, and one of them may render another image of this world. It
        // bakes for itself then.
        let mut baked = self.lock().take();
        if let (Some(light), Some(live)) = (&mut baked, live)
            && light.update(live, program).is_err()
        {
            baked = None;
        }
        if baked.is_none() {
            baked = LightLevels::bake(program, bricks).ok();
        }
        let levels = baked.as_ref().map(|light| light.levels().clone());
        *self.lock() = baked;
        levels
    }

    fn lock(&self) -> MutexGuard<'_, Option<LightLevels>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes the last update of a program.
    pub(crate) fn note_edit(&mut self, live: Option<&IncrementalProgram>, bricks: &BrickLayout) {
        let state = self.state.get_mut().unwrap_or_else(PoisonError::into_inner);
        let follows = match (&mut *state, live) {
            (Some(light), Some(live)) => light.note_edit(live, bricks),
            _ => false,
        };
        if !follows {
            *state = None;
        }
    }

    /// Forgets the levels.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Returns the bytes of the levels.
    pub(crate) fn memory_bytes(&self) -> u64 {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state
            .as_ref()
            .map_or(0, |light| light.levels().memory_bytes())
    }
}
