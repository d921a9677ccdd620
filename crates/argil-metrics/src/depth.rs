//! Errors of ray lengths, pixel by pixel.

use crate::ErrorStats;
use serde::{Deserialize, Serialize};

/// How the hits of two images differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DepthErrors {
    /// Errors of length where both hit.
    pub both: ErrorStats,
    /// Pixels where only the reference hits: missed silhouettes.
    pub missed: u64,
    /// Pixels where only the other image hits.
    pub added: u64,
}

/// Compares the lengths of rays. Infinity or NaN means that nothing was hit.
///
/// # Panics
/// If the slices differ in length.
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
