//! The target that the environment variable `ARGIL_FUZZ_TARGET` names.

#![no_main]

use std::sync::LazyLock;

static TARGET: LazyLock<&argil_fuzz::Target> = LazyLock::new(|| {
    let name = std::env::var("ARGIL_FUZZ_TARGET").expect("ARGIL_FUZZ_TARGET names a target");
    argil_fuzz::find(&name).expect("a target of argil_fuzz::TARGETS")
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| (TARGET.run)(bytes));
