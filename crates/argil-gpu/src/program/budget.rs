//! How often a thread may evaluate a program.

use super::GpuProgram;
use crate::{DeviceKind, GpuError};

/// lavapipe silently ends all loops of a thread after 65,535 iterations, and the passes' own loops need some.
const SOFTWARE_ITERATIONS: u64 = 60_000;

/// Evaluations that the longest pass does at once: six for a normal, or a material and five taps for light.
const MIN_BUDGET: u64 = 7;

impl GpuProgram {
    /// Notes how long an evaluation is. On hardware, only the image's size limits how many a thread may do.
    pub(super) fn set_iterations(&mut self, iterations: u64) {
        self.iterations = iterations.max(1);
        self.budget = u32::MAX;
        if self.gpu.info().kind == DeviceKind::Software {
            // Every instruction executes the cases with noise and with searches, whose loops take a round each.
            let opcodes = self.interpreter.opcodes();
            let noise = opcodes.contains(argil_abi::OP_DISPLACE);
            let mut searches = argil_abi::OP_FIRST_ITERATIVE..argil_abi::OP_SHAPES_END;
            let searches = searches.any(|op| opcodes.contains(op));
            self.iterations *= 1 + u64::from(noise) + u64::from(searches);
            let budget = SOFTWARE_ITERATIONS / (self.iterations + 1);
            self.budget = (budget as u32).max(1);
        }
    }

    /// Checks that the device can evaluate the field. Rays through levels of detail do not.
    ///
    /// # Errors
    /// If this is a software device, and it would cut the program's loops short.
    pub(crate) fn check_length(&self) -> Result<(), GpuError> {
        if u64::from(self.budget) >= MIN_BUDGET {
            return Ok(());
        }
        Err(self.too_long(MIN_BUDGET))
    }

    /// Checks that a pass can evaluate the field as often as needed.
    pub(crate) fn check_evaluations(&self, needed: u64) -> Result<(), GpuError> {
        let is_software = self.gpu.info().kind == DeviceKind::Software;
        if !is_software || u64::from(self.budget) >= needed {
            return Ok(());
        }
        Err(self.too_long(needed))
    }

    /// Returns the error of a pass that evaluates the field too often.
    fn too_long(&self, evaluations: u64) -> GpuError {
        GpuError::TooLong {
            name: self.gpu.info().name.clone(),
            iterations: self.iterations,
            limit: SOFTWARE_ITERATIONS / evaluations,
        }
    }
}
