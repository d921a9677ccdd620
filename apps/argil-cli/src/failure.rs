//! Errors and exit codes: 1 the input or the request, 3 the machine.

use argil::{BuildError, EngineError, GpuError, MeshError, RenderError, VolumeFileError};
use std::process::ExitCode;

pub fn report(error: &anyhow::Error) -> ExitCode {
    eprintln!("argil: {error:#}");
    let of_machine = error.chain().any(|cause| {
        cause.is::<EngineError>()
            || cause.is::<crate::companion::Missing>()
            || matches!(cause.downcast_ref(), Some(RenderError::Gpu(_)))
            || cause.downcast_ref().is_some_and(lacks)
            || matches!(cause.downcast_ref(), Some(VolumeFileError::Build(e)) if lacks(e))
            || matches!(cause.downcast_ref(), Some(MeshError::Build(e)) if lacks(e))
    });
    ExitCode::from(if of_machine { 3 } else { 1 })
}

/// Whether it is the machine that lacks something.
fn lacks(error: &BuildError) -> bool {
    match error {
        // Limits of our own, for which the request has another way.
        BuildError::Gpu(
            GpuError::TooManyToEnumerate { .. }
            | GpuError::TooLongToSpecialize
            | GpuError::Budget { .. }
            | GpuError::Bricks(_),
        ) => false,
        BuildError::Gpu(_) | BuildError::Memory { .. } => true,
        _ => false,
    }
}
