//! Errors and exit codes: 1 the input or the request, 3 the machine.

use argil::{BuildError, EngineError, RenderError};
use std::process::ExitCode;

pub fn report(error: &anyhow::Error) -> ExitCode {
    eprintln!("argil: {error:#}");
    let of_machine = error.chain().any(|cause| {
        cause.is::<EngineError>()
            || matches!(cause.downcast_ref(), Some(RenderError::Gpu(_)))
            || matches!(cause.downcast_ref(), Some(BuildError::Gpu(_)))
    });
    ExitCode::from(if of_machine { 3 } else { 1 })
}
