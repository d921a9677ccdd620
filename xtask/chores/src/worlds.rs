//! Wide scenes: a valley and a city. Both are made from code, because their instances are too many to write.

use crate::world_parts::{lines_of, shorten};
use crate::{city, valley};
use serde_json::Value;
use std::path::PathBuf;
use xtask::root;

/// Returns the scenes, as paths and texts.
pub(crate) fn worlds() -> anyhow::Result<Vec<(PathBuf, String)>> {
    let all = [("valley", valley::valley()?), ("city", city::city())];
    let text = |(name, mut scene): (&str, Value)| {
        shorten(&mut scene);
        let path = root().join(format!("scenes/{name}.json"));
        (path, lines_of(&scene))
    };
    Ok(all.into_iter().map(text).collect())
}
