#![doc = include_str!("crate.md")]

mod aabb;
mod bits;
mod control;
mod interval;
mod morton;
mod ray;

pub use aabb::Aabb;
pub use bits::{bits_of, set_indices};
pub use control::{Control, Progress};
pub use interval::Interval;
pub use morton::{morton, morton_cell};
pub use ray::Ray;

/// Returns the WGSL twin of [`morton`](fn@morton) and [`morton_cell`].
pub fn morton_wgsl() -> &'static str {
    include_str!("morton.wgsl")
}
