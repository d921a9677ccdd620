//! NumPy arrays, NRRD files and raw samples as shapes. The first byte chooses.

#![no_main]

use argil::{RawLayout, VolumeReadOptions, read_volume_bytes};
use std::path::Path;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((&kind, bytes)) = bytes.split_first() else {
        return;
    };
    let name = ["a.npy", "a.nrrd", "a.raw"][usize::from(kind) % 3];
    let options = VolumeReadOptions {
        is_fog: Some(kind & 64 != 0),
        raw: RawLayout {
            shape: Some([4, 5, 6]),
            ..RawLayout::default()
        },
        ..VolumeReadOptions::default()
    };
    let _ = read_volume_bytes(bytes, Path::new(name), &options);
});
