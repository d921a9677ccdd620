//! Errors of values, with their place.

use std::fmt;

/// Maximum of lengths and coordinates. Squares and sums of them stay finite in `f32`.
pub const MAX_LENGTH: f32 = 1e6;

/// A value that is out of range.
#[derive(Clone, Debug, PartialEq)]
pub struct ValidationError {
    /// Path from the checked object to the value, such as `shape.radius`. Empty for the object itself.
    pub path: String,
    /// What is wrong, with the value and the valid range.
    pub reason: String,
}

impl ValidationError {
    pub(crate) fn new(path: impl Into<String>, reason: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            reason: reason.into(),
        }
    }

    /// Returns the error with the path from the owner of the checked object.
    pub(crate) fn within(mut self, owner: &str) -> Self {
        self.path = match (owner.is_empty(), self.path.is_empty()) {
            (true, _) => self.path,
            (false, true) => owner.to_owned(),
            (false, false) if self.path.starts_with('[') => format!("{owner}{}", self.path),
            (false, false) => format!("{owner}.{}", self.path),
        };
        self
    }
}

impl fmt::Display for ValidationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.path.is_empty() {
            f.write_str(&self.reason)
        } else {
            write!(f, "{}: {}", self.path, self.reason)
        }
    }
}

impl std::error::Error for ValidationError {}

/// Checks a finite number of at most [`MAX_LENGTH`].
pub(crate) fn coordinate(path: &str, value: f32) -> Result<(), ValidationError> {
    if value.abs() <= MAX_LENGTH {
        Ok(())
    } else {
        Err(ValidationError::new(
            path,
            format!("{value} is not a number from −{MAX_LENGTH} to {MAX_LENGTH}"),
        ))
    }
}

/// Checks a coordinate above zero.
pub(crate) fn positive(path: &str, value: f32) -> Result<(), ValidationError> {
    coordinate(path, value)?;
    if value <= 0.0 {
        Err(ValidationError::new(
            path,
            format!("{value} is not positive"),
        ))
    } else if value < 1e-6 {
        Err(ValidationError::new(
            path,
            format!("{value} is below the least length, 1e-6"),
        ))
    } else {
        Ok(())
    }
}

/// Checks a coordinate of zero or more.
pub(crate) fn not_negative(path: &str, value: f32) -> Result<(), ValidationError> {
    coordinate(path, value)?;
    if value < 0.0 {
        Err(ValidationError::new(path, format!("{value} is negative")))
    } else {
        Ok(())
    }
}

/// Checks a value in a range, including both ends. NaN is refused.
pub(crate) fn within<T: PartialOrd + std::fmt::Display + Copy>(
    path: &str,
    value: T,
    min: T,
    max: T,
) -> Result<(), ValidationError> {
    if (min..=max).contains(&value) {
        Ok(())
    } else {
        Err(ValidationError::new(
            path,
            format!("{value} is not from {min} to {max}"),
        ))
    }
}

/// Checks `value` ≤ `limit`. `what` describes the limit.
pub(crate) fn at_most(
    path: &str,
    value: f32,
    limit: f32,
    what: &str,
) -> Result<(), ValidationError> {
    if value <= limit {
        Ok(())
    } else {
        Err(ValidationError::new(
            path,
            format!("{value} is more than {what}, {limit}"),
        ))
    }
}

/// Calls a check for each element of an array.
pub(crate) fn each<const N: usize>(
    path: &str,
    values: [f32; N],
    check: fn(&str, f32) -> Result<(), ValidationError>,
) -> Result<(), ValidationError> {
    values
        .into_iter()
        .enumerate()
        .try_for_each(|(i, v)| check("", v).map_err(|fault| fault.within(&format!("{path}[{i}]"))))
}
