//! Lengths of rays, pixel by pixel.

use crate::ErrorStats;
use serde::{Deserialize, Serialize};

/// How the hits of two pictures differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DepthErrors {
    /// Errors of length where both hit.
    pub both: ErrorStats,
    /// Pixels of which only the reference hits: silhouettes that are missed.
    pub missed: u64,
    /// Pixels of which only the other hits.
    pub added: u64,
}

/// Compare the lengths of rays, infinite or not a number where nothing was hit; the first are the reference's.
///
/// # Panics
/// If there are not as many of each.
pub fn compare(reference: &[f32], other: &[f32]) -> DepthErrors {
    assert_eq!(reference.len(), other.len(), "as many pixels");
    let pairs = || reference.iter().zip(other);
    let hit = |t: &f32| t.is_finite();
    let both = pairs().filter(|(a, b)| hit(a) && hit(b));
    DepthErrors {
        both: ErrorStats::of(both.map(|(&a, &b)| f64::from(b) - f64::from(a))),
        missed: pairs().filter(|(a, b)| hit(a) && !hit(b)).count() as u64,
        added: pairs().filter(|(a, b)| !hit(a) && hit(b)).count() as u64,
    }
}
