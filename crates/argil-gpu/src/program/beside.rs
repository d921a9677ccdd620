//! Another program with the same passes.

use super::GpuProgram;
use crate::GpuError;
use argil_field::Program;

impl GpuProgram {
    /// Creates a program without brushes on the same device. What was compiled for this program serves both, unless its shaders are
    /// for one program only.
    ///
    /// # Errors
    /// If the device has no memory left, or fails.
    pub fn beside(&self) -> Result<Self, GpuError> {
        let mut other = Self::new(self.gpu.clone(), &Program::default(), false)?;
        if !self.is_specialized() {
            other.interpreter = self.interpreter;
            other.passes = self.passes.clone();
        }
        Ok(other)
    }
}
