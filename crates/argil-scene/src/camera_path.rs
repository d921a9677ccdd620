//! Paths of cameras.

use crate::CameraPose;
use crate::validation::{ValidationError, coordinate, each, within};
use glam::Vec3;
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Maximum time on a path in seconds: a day.
const MAX_SECONDS: f32 = 86_400.0;

/// A point that a camera passes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PathPoint {
    /// Time in seconds, later than that of the previous point.
    pub time: f32,
    /// Position of the camera.
    pub eye: [f32; 3],
    /// The point in the middle of the image.
    pub target: [f32; 3],
}

/// The path of a camera: at least two points in order of time.
///
/// Between points, eye and target move on cubic curves with continuous velocities (Catmull and Rom, 1974, for
/// uneven times).
///
/// ```
/// use argil_scene::{CameraPath, CameraPose, PathPoint};
/// let point = |time, x| PathPoint { time, eye: [x, 2.0, 0.0], target: [x, 2.0, -1.0] };
/// let path = CameraPath(vec![point(0.0, 0.0), point(1.0, 3.0)]);
/// assert!(path.check().is_ok());
/// let CameraPose::LookAt { eye, .. } = path.at(0.5) else { unreachable!() };
/// assert!((eye[0] - 1.5).abs() < 1e-6);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct CameraPath(pub Vec<PathPoint>);

impl CameraPath {
    /// Checks that there are two points or more, in order of time, with values in their ranges.
    ///
    /// # Errors
    /// The first value that is out of range.
    pub fn check(&self) -> Result<(), ValidationError> {
        if self.0.len() < 2 {
            return Err(ValidationError::new("", "a path needs two points or more"));
        }
        for (i, point) in self.0.iter().enumerate() {
            let fault = |fault: ValidationError| fault.within(&format!("[{i}]"));
            within("time", point.time, 0.0, MAX_SECONDS).map_err(fault)?;
            each("eye", point.eye, coordinate).map_err(fault)?;
            each("target", point.target, coordinate).map_err(fault)?;
            if point.eye == point.target {
                return Err(fault(ValidationError::new(
                    "target",
                    "eye and target coincide",
                )));
            }
            if i > 0 && point.time <= self.0[i - 1].time {
                let text = format!("{} is not later than the point before", point.time);
                return Err(fault(ValidationError::new("time", text)));
            }
        }
        Ok(())
    }

    /// Returns the time from the first point to the last, in seconds. 0 for an empty path.
    pub fn duration(&self) -> f32 {
        match (self.0.first(), self.0.last()) {
            (Some(first), Some(last)) => last.time - first.time,
            _ => 0.0,
        }
    }

    /// Returns the pose at a time after the first point. Before and after the path, it is that of the nearest point.
    pub fn at(&self, time: f32) -> CameraPose {
        let Some(first) = self.0.first() else {
            return CameraPose::Orbit([30.0, 20.0, 3.6]);
        };
        let time = first.time + time.max(0.0);
        let after = self.0.partition_point(|point| point.time <= time);
        let (Some(a), Some(b)) = (self.0.get(after.wrapping_sub(1)), self.0.get(after)) else {
            let end = self.0[after.saturating_sub(1)];
            return CameraPose::LookAt {
                eye: end.eye,
                target: end.target,
            };
        };
        let before = if after > 1 { self.0[after - 2] } else { *a };
        let beyond = self.0.get(after + 1).copied().unwrap_or(*b);
        let around = [before, *a, *b, beyond];
        let mix = |value: fn(&PathPoint) -> [f32; 3]| curve(&around, time, value).to_array();
        CameraPose::LookAt {
            eye: mix(|point| point.eye),
            target: mix(|point| point.target),
        }
    }
}

/// Returns a value between the middle two of four points, by a cubic whose slopes at both ends are those between
/// their neighbors.
fn curve(around: &[PathPoint; 4], time: f32, value: fn(&PathPoint) -> [f32; 3]) -> Vec3 {
    let [p0, p1, p2, p3] = around.map(|point| Vec3::from(value(&point)));
    let [t0, t1, t2, t3] = around.map(|point| point.time);
    let length = t2 - t1;
    let t = (time - t1) / length;
    let slope = |a: Vec3, b: Vec3, from: f32, to: f32| (b - a) * (length / (to - from));
    let (m1, m2) = (slope(p0, p2, t0, t2), slope(p1, p3, t1, t3));
    let (square, cube) = (t * t, t * t * t);
    p1 * (2.0 * cube - 3.0 * square + 1.0)
        + m1 * (cube - 2.0 * square + t)
        + p2 * (3.0 * square - 2.0 * cube)
        + m2 * (cube - square)
}
