//! `argil schema`.

/// What `argil-scene` makes of its types, as it is committed: a test there holds them to be the same.
const SCHEMA: &str = include_str!("../../../scenes/argil.schema.json");

pub(crate) fn run() -> anyhow::Result<()> {
    crate::output::line(SCHEMA.trim_end());
    Ok(())
}
