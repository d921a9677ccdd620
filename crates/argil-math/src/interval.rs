/// All values from `min` to `max`, including both.
///
/// ```
/// use argil_math::Interval;
/// let near = Interval::around(0.5, 0.2);
/// assert!(near.is_positive() && near.contains(0.4));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The smallest value.
    pub min: f32,
    /// The largest value.
    pub max: f32,
}

impl Interval {
    /// Creates `center` ± `radius`.
    pub fn around(center: f32, radius: f32) -> Self {
        Self {
            min: center - radius,
            max: center + radius,
        }
    }

    /// Whether a value lies in the interval.
    pub fn contains(self, value: f32) -> bool {
        self.min <= value && value <= self.max
    }

    /// Whether every value is above zero. For a distance, the whole region is outside.
    pub fn is_positive(self) -> bool {
        self.min > 0.0
    }

    /// Whether every value is below zero. For a distance, the whole region is inside.
    pub fn is_negative(self) -> bool {
        self.max < 0.0
    }
}
