//! Poses of instances.

use crate::ValidationError;
use crate::validation::{coordinate, within};
use glam::{DAffine3, DQuat, DVec3, Vec3};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Maximum instances of a node.
const MAX_INSTANCES: usize = 1_000_000;

/// The pose of an instance: scaled first, then rotated, then moved. A file holds it as five numbers: the position,
/// the rotation about the y axis in degrees, and the scale.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[cfg_attr(feature = "schema", schemars(with = "[f32; 5]"))]
#[serde(from = "[f32; 5]", into = "[f32; 5]")]
pub struct Pose {
    /// The position of the solid's origin.
    pub position: [f32; 3],
    /// The rotation about the y axis in degrees, counterclockwise seen from above.
    pub degrees: f32,
    /// The factor by which all lengths grow, from 1e-4 to 1e4.
    pub scale: f32,
}

impl From<[f32; 5]> for Pose {
    fn from([x, y, z, degrees, scale]: [f32; 5]) -> Self {
        Self {
            position: [x, y, z],
            degrees,
            scale,
        }
    }
}

impl From<Pose> for [f32; 5] {
    fn from(pose: Pose) -> Self {
        let [x, y, z] = pose.position;
        [x, y, z, pose.degrees, pose.scale]
    }
}

impl Pose {
    /// Returns the map from the surrounding frame to the solid's own.
    ///
    /// ```
    /// use argil_scene::Pose;
    /// let pose = Pose { position: [1.0, 0.0, 0.0], degrees: 90.0, scale: 2.0 };
    /// let local = pose.own_from_outer().transform_point3([1.0, 0.0, -2.0].into());
    /// assert!((local - glam::DVec3::X).length() < 1e-6);
    /// ```
    pub fn own_from_outer(&self) -> DAffine3 {
        let turn = DQuat::from_rotation_y(f64::from(self.degrees).to_radians());
        let scale = DVec3::splat(f64::from(self.scale));
        let position = Vec3::from(self.position).as_dvec3();
        DAffine3::from_scale_rotation_translation(scale, turn, position).inverse()
    }

    fn check(&self) -> Result<(), ValidationError> {
        let numbers: [f32; 5] = (*self).into();
        for (i, value) in numbers[..4].iter().enumerate() {
            coordinate(&format!("[{i}]"), *value)?;
        }
        within("[4]", self.scale, 1e-4, 1e4)
    }
}

/// The poses of a node's instances, which clones share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[cfg_attr(feature = "schema", schemars(with = "Vec<Pose>"))]
#[serde(from = "Vec<Pose>", into = "Vec<Pose>")]
pub struct Poses(Arc<[Pose]>);

impl From<Vec<Pose>> for Poses {
    fn from(poses: Vec<Pose>) -> Self {
        Self(poses.into())
    }
}

impl From<Poses> for Vec<Pose> {
    fn from(poses: Poses) -> Self {
        poses.0.to_vec()
    }
}

impl std::ops::Deref for Poses {
    type Target = [Pose];

    fn deref(&self) -> &[Pose] {
        &self.0
    }
}

impl Poses {
    /// Returns the smallest and the largest scale.
    ///
    /// ```
    /// use argil_scene::{Pose, Poses};
    /// let rows = [[0.0, 0.0, 0.0, 0.0, 0.5], [3.0, 0.0, 0.0, 45.0, 2.0]];
    /// let poses: Poses = rows.map(Pose::from).to_vec().into();
    /// assert_eq!(poses.scales(), [0.5, 2.0]);
    /// ```
    pub fn scales(&self) -> [f32; 2] {
        let all = self.iter().map(|pose| pose.scale);
        let least = all.clone().fold(f32::INFINITY, f32::min);
        [least, all.fold(0.0, f32::max)]
    }
}

/// Checks the poses of instances.
pub(crate) fn poses(path: &str, all: &Poses) -> Result<(), ValidationError> {
    if all.is_empty() || all.len() > MAX_INSTANCES {
        let text = format!(
            "there are {}, which must be 1 to {MAX_INSTANCES}",
            all.len()
        );
        return Err(ValidationError::new(path, text));
    }
    for (i, pose) in all.iter().enumerate() {
        pose.check()
            .map_err(|fault| fault.within(&format!("{path}[{i}]")))?;
    }
    Ok(())
}
