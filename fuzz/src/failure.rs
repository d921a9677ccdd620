//! Saves the input that a target fails on.

use std::path::Path;
use std::sync::Mutex;
use std::time::Instant;

/// An input, while its target runs.
pub(crate) struct Current {
    pub(crate) name: &'static str,
    pub(crate) input: Vec<u8>,
    pub(crate) start: Instant,
}

pub(crate) static CURRENT: Mutex<Option<Current>> = Mutex::new(None);

/// Saves the current input, says what is wrong with it, and ends the program.
pub(crate) fn fail(reason: &str) -> ! {
    let current = CURRENT
        .try_lock()
        .ok()
        .and_then(|mut current| current.take());
    if let Some(Current { name, input, .. }) = current {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/fuzz");
        let path = folder.join(format!("{name}.input"));
        let saved = std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&path, &input));
        let place = saved.map_or_else(|error| error.to_string(), |()| path.display().to_string());
        eprintln!(
            "{name}: {reason}, for an input of {} bytes: {place}",
            input.len()
        );
    } else {
        eprintln!("{reason}");
    }
    std::process::abort()
}
