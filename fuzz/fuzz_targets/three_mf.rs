//! 3MF files.

#![no_main]

use argil::mesh::{MeshFormat, from_bytes};
use std::path::Path;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = from_bytes(bytes, MeshFormat::ThreeMf, Path::new("a.3mf"));
});
