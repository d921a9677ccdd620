//! `argil schema`.

/// The schema that `argil-scene` generates, as committed. A test compares the two.
const SCHEMA: &str = include_str!("../../../scenes/argil.schema.json");

pub(crate) fn run() -> anyhow::Result<()> {
    crate::output::line(SCHEMA.trim_end());
    Ok(())
}
