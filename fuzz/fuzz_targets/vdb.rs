//! OpenVDB files, grid by grid.

#![no_main]

use argil::vdb::vdb::VdbFile;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(file) = VdbFile::parse(bytes) {
        for i in 0..file.grids.len() {
            let _ = file.grid(i);
        }
    }
});
