//! Lists of a program for the parts of a grid, where they pay.

use super::GpuProgram;
use crate::near_lists::{NearPasses, near_lists_module};
use crate::pass_module::Passes;
use crate::trace_mode::BoundResource;
use crate::{GpuError, HostEncoder};
use std::sync::PoisonError;

impl GpuProgram {
    /// Returns what is bound of the program's lists for some evaluations, or `None` if they evaluate the program whole. A host's encoder
    /// gets what makes the lists.
    pub(crate) fn near_for(
        &self,
        evaluations: u64,
        host: Option<&mut HostEncoder>,
    ) -> Result<Option<Vec<BoundResource>>, GpuError> {
        let mut near = self.near.lock().unwrap_or_else(PoisonError::into_inner);
        match near.pays_for(&self.gpu, evaluations) {
            true => near.bound(&self.gpu, || self.near_passes(), host),
            false => Ok(None),
        }
    }

    /// Returns what makes the lists.
    fn near_passes(&self) -> Result<NearPasses<'_>, GpuError> {
        let passes = self.passes("lists of parts", || {
            let module = near_lists_module(&self.interpreter.near_lists_wgsl());
            Passes::new(&self.gpu, module)
        })?;
        let tables = self.table_bindings().collect();
        Ok(NearPasses { passes, tables })
    }
}
