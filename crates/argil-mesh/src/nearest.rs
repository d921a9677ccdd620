//! Finds what is nearest to a point.

mod node;
mod points;
mod wide;

pub(crate) use node::BvhNode;
pub use points::SurfacePoints;
pub(crate) use wide::{Leaf, NearestSearch, WIDE, Wide3, WideTree};
