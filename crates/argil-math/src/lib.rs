//! Boxes, intervals and rays: the small geometry that every other crate of Argil shares.

mod aabb;
mod interval;
mod ray;

pub use aabb::Aabb;
pub use interval::Interval;
pub use ray::Ray;
