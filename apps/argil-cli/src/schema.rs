//! `argil schema`.

pub fn run() -> anyhow::Result<()> {
    print!("{}", argil::schema());
    Ok(())
}
