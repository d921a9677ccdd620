use serde::{Deserialize, Serialize};

/// Statistics of errors: of distances, depths, or points of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorStats {
    /// Number of errors.
    pub count: u64,
    /// Mean of the absolute errors.
    pub mean: f64,
    /// Root mean square of the errors.
    pub rms: f64,
    /// Maximum absolute error.
    pub max: f64,
}

impl ErrorStats {
    /// Summarizes errors of either sign. NaN counts as infinite.
    pub fn of(errors: impl IntoIterator<Item = f64>) -> Self {
        let (mut count, mut sum, mut squares, mut max) = (0u64, 0.0, 0.0, 0.0f64);
        for error in errors {
            let size = if error.is_nan() {
                f64::INFINITY
            } else {
                error.abs()
            };
            count += 1;
            sum += size;
            squares += size * size;
            max = max.max(size);
        }
        let n = count.max(1) as f64;
        Self {
            count,
            mean: sum / n,
            rms: (squares / n).sqrt(),
            max,
        }
    }

    /// Summarizes the errors of stored distances, where both the stored and the exact distance are within a band.
    /// Outside it, stored values are clamped.
    pub fn within_band(stored: &[f32], exact: &[f32], band: f32) -> Self {
        let held = |d: f32| d.abs() < band;
        let pairs = stored.iter().zip(exact);
        let pairs = pairs.filter(|&(&s, &e)| held(s) && held(e));
        Self::of(pairs.map(|(&s, &e)| f64::from(s) - f64::from(e)))
    }
}
