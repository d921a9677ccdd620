//! Converts a frame's colors to bytes, and counts what its rays did.

use crate::bindings::{Bind, COLORS, COUNTS, FRAME, FRAME_WGSL, HITS, PICTURE_WGSL, PIXELS};
use crate::pass_module::PassModule;
use argil_render::wgsl;

const RESOLVE_WGSL: &str = "
@group(0) @binding(BIND_PIXELS) var<storage, read_write> pixels: array<u32>;
@group(0) @binding(BIND_COUNTS) var<storage, read_write> counts: array<atomic<u32>>;
";

/// Describes the last passes of a frame, for any representation.
pub(crate) fn resolve_module() -> PassModule {
    let source = [
        &argil_abi::wgsl(),
        FRAME_WGSL,
        PICTURE_WGSL,
        wgsl::HIT_RECORDS,
        RESOLVE_WGSL,
        wgsl::RESOLVE_SAMPLES,
    ];
    let binds = vec![
        Bind::Uniforms(FRAME),
        Bind::Write(HITS),
        Bind::Write(COLORS),
        Bind::Write(PIXELS),
        Bind::Write(COUNTS),
    ];
    PassModule::new("Resolve", &source, binds, &[], &["count", "resolve"])
}
