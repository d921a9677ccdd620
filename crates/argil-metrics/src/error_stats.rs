use serde::{Deserialize, Serialize};

/// Errors in sum: of distances, depths, points of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorStats {
    /// How many there are.
    pub count: u64,
    /// The mean of their sizes.
    pub mean: f64,
    /// The root of the mean of their squares.
    pub rms: f64,
    /// The greatest size.
    pub max: f64,
}

impl ErrorStats {
    /// Of errors with either sign; what is not a number counts as infinite.
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

    /// Of stored distances against the exact ones, where both are within a band: outside of it what is stored is cut.
    pub fn within_band(stored: &[f32], exact: &[f32], band: f32) -> Self {
        let held = |d: f32| d.abs() < band;
        let pairs = stored.iter().zip(exact);
        let pairs = pairs.filter(|&(&s, &e)| held(s) && held(e));
        Self::of(pairs.map(|(&s, &e)| f64::from(s) - f64::from(e)))
    }
}
