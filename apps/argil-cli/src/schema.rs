//! `argil schema`.

pub fn run() -> anyhow::Result<()> {
    crate::output::line(argil::schema().trim_end());
    Ok(())
}
