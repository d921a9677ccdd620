//! NanoVDB files.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = argil::vdb::nvdb::read(bytes);
});
