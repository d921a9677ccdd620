//! Errors and exit codes: 1 for the input or the request, 3 for the machine.

use argil::gpu::GpuError;
use argil::mesh::MeshReadError;
use argil::mesh::marching::surface::SurfaceError;
use argil::volume::BricksError;
use argil::{BuildError, EngineError, MeshError, MeshFileError, RenderError, VolumeFileError};
use std::error::Error;
use std::process::ExitCode;

/// What `argil --help` says of exit codes.
pub(crate) const EXIT_CODES: &str = "Exit codes: 0 done; 1 the input or the request is at fault, also if it exceeds its own --memory-budget; \
    2 usage; 3 the machine lacks a GPU, memory or a program that is needed; 130 interrupted";

pub(crate) fn report(error: &anyhow::Error) -> ExitCode {
    let remedies: Vec<&str> = error.chain().filter_map(remedy).collect();
    match remedies.first() {
        Some(remedy) => eprintln!("argil: {error:#} ({remedy})"),
        None => eprintln!("argil: {error:#}"),
    }
    let of_machine = error.chain().any(|cause| {
        cause.is::<EngineError>()
            || cause.is::<crate::companion::Missing>()
            || cause.is::<crate::companion::NotBuilt>()
            || matches!(cause.downcast_ref(), Some(RenderError::Gpu(_)))
            || cause.downcast_ref().is_some_and(lacks)
            || matches!(cause.downcast_ref(), Some(VolumeFileError::Build(e)) if lacks(e))
            || matches!(cause.downcast_ref(), Some(MeshError::Build(e)) if lacks(e))
    });
    ExitCode::from(if of_machine { 3 } else { 1 })
}

/// Returns true if the machine lacks something that the build needs.
fn lacks(error: &BuildError) -> bool {
    match error {
        // These are limits of Argil, which another request can avoid.
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

/// Returns the flag that resolves a library error. The library does not know the command's flags.
fn remedy(cause: &(dyn Error + 'static)) -> Option<&'static str> {
    let of_gpu = |error: &GpuError| match error {
        GpuError::None
        | GpuError::TooLarge { .. }
        | GpuError::TooManyBricks { .. }
        | GpuError::TooDeep { .. }
        | GpuError::TooLong { .. }
        | GpuError::TooFine { .. } => Some("--device cpu"),
        GpuError::TooLongToSpecialize => Some("omit --specialize"),
        GpuError::Budget { .. } => Some("--resolution, --bits, --memory-budget"),
        GpuError::Bricks(error) => of_bricks(error),
        _ => None,
    };
    let of_build = |error: &BuildError| match error {
        BuildError::Gpu(error) => of_gpu(error),
        BuildError::Bricks(error) => of_bricks(error),
        _ => None,
    };
    if let Some(error) = cause.downcast_ref::<BuildError>() {
        return of_build(error);
    }
    match cause.downcast_ref() {
        Some(MeshError::Build(error)) => return of_build(error),
        Some(MeshError::Surface(SurfaceError::Iso)) => return Some("omit --iso"),
        Some(MeshError::Levels) => return Some("omit --iso, --max-triangles, --method, --normals"),
        Some(MeshError::Surface(SurfaceError::Band { .. })) => return Some("--band, --stride"),
        _ => {}
    }
    match cause.downcast_ref() {
        Some(RenderError::Gpu(error)) => return of_gpu(error),
        Some(RenderError::NoBricks) => return Some("--via bricks, levels or octree"),
        _ => {}
    }
    if let Some(EngineError::Gpu(error)) = cause.downcast_ref() {
        return of_gpu(error);
    }
    if let Some(VolumeFileError::Build(error)) = cause.downcast_ref() {
        return of_build(error);
    }
    match cause.downcast_ref() {
        Some(MeshFileError::ExternalMesh { .. }) => return Some("--allow-external-meshes"),
        Some(MeshFileError::Empty { source, .. }) => return of_solid(source),
        _ => {}
    }
    cause.downcast_ref().and_then(of_solid)
}

fn of_bricks(error: &BricksError) -> Option<&'static str> {
    match error {
        BricksError::Budget { .. } => Some("--resolution, --bits, --memory-budget"),
        BricksError::Blocks { .. } => Some("--resolution, --voxel-size, --memory-budget"),
        _ => None,
    }
}

fn of_solid(error: &MeshReadError) -> Option<&'static str> {
    matches!(
        error,
        MeshReadError::Hollow { .. } | MeshReadError::Sheets { .. }
    )
    .then_some("--thickness")
}
