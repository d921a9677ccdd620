//! Appends transforms to a node.

use crate::Modifier;
use glam::{DQuat, DVec3, Vec3};

/// Maximum transforms at the end of a node, before they are combined into a scale, a rotation and a translation.
const MAX_TRANSFORMS: usize = 6;

/// Appends a transform. Consecutive transforms of one kind combine, and so do long runs, so that thousands of small
/// rotations cost no more than one.
pub(crate) fn push_transform(modifiers: &mut Vec<Modifier>, by: Modifier) {
    match (modifiers.last_mut(), &by) {
        (Some(Modifier::Translate { by: old }), Modifier::Translate { by: more }) => {
            *old = std::array::from_fn(|i| old[i] + more[i]);
            return;
        }
        (
            Some(Modifier::Rotate { axis, degrees }),
            Modifier::Rotate {
                axis: a,
                degrees: d,
            },
        ) if axis == a => {
            *degrees = (*degrees + d) % 360.0;
            return;
        }
        _ => modifiers.push(by),
    }
    let run = modifiers.iter().rev();
    let run = run.take_while(|m| m.is_similarity()).count();
    if run > MAX_TRANSFORMS {
        let first = modifiers.len() - run;
        if let Some(composed) = composed(&modifiers[first..]) {
            modifiers.truncate(first);
            modifiers.extend(composed);
        }
    }
}

/// Returns a scale, a rotation and a translation that do what a list of transforms does. Returns `None` if a value
/// would be out of range.
fn composed(transforms: &[Modifier]) -> Option<Vec<Modifier>> {
    let (mut scale, mut turn, mut shift) = (1.0f64, DQuat::IDENTITY, DVec3::ZERO);
    for transform in transforms {
        match *transform {
            Modifier::Translate { by } => shift += Vec3::from(by).as_dvec3(),
            Modifier::Rotate { axis, degrees } => {
                let axis = Vec3::from(axis).as_dvec3().normalize();
                let rotation = DQuat::from_axis_angle(axis, f64::from(degrees).to_radians());
                turn = (rotation * turn).normalize();
                shift = rotation * shift;
            }
            Modifier::Scale { by } => {
                scale *= f64::from(by);
                shift *= f64::from(by);
            }
            _ => return None,
        }
    }
    let (axis, angle) = turn.to_axis_angle();
    let composed = [
        Modifier::Scale { by: scale as f32 },
        Modifier::Rotate {
            axis: axis.as_vec3().to_array(),
            degrees: angle.to_degrees() as f32,
        },
        Modifier::Translate {
            by: shift.as_vec3().to_array(),
        },
    ];
    composed
        .iter()
        .all(|modifier| modifier.check().is_ok())
        .then(|| composed.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;

    fn map_of(modifiers: &[Modifier]) -> DAffine3 {
        let maps = modifiers.iter().filter_map(Modifier::affine);
        // Each map leads back to what the modifier before it made.
        maps.fold(DAffine3::IDENTITY, |all, map| all * map)
    }

    #[test]
    fn many_transforms_become_three_that_do_the_same() {
        // What keeps no angles stays where it is, and what comes after it is composed all the same.
        let by = [1.0, 2.0, 1.0];
        let mut modifiers = vec![Modifier::Stretch { by }];
        let mut all = Vec::new();
        for i in 0..2_000 {
            let by = match i % 3 {
                0 => Modifier::Translate {
                    by: [0.01, -0.02, 0.005 * (i % 7) as f32],
                },
                1 => Modifier::Rotate {
                    axis: [1.0, (i % 5) as f32, 0.5],
                    degrees: 3.0,
                },
                _ => Modifier::Scale {
                    by: if i % 2 == 0 { 1.01 } else { 1.0 / 1.01 },
                },
            };
            all.push(by.clone());
            push_transform(&mut modifiers, by);
            assert!(modifiers.len() <= 1 + MAX_TRANSFORMS, "{}", modifiers.len());
        }
        let (actual, expected) = (map_of(&modifiers[1..]), map_of(&all));
        assert!(
            actual.abs_diff_eq(expected, 1e-3),
            "{actual:?} and {expected:?}"
        );
        assert_eq!(modifiers[0], Modifier::Stretch { by });
    }

    #[test]
    fn a_scale_that_would_be_too_large_is_left_in_parts() {
        let mut modifiers = Vec::new();
        for _ in 0..3 {
            push_transform(&mut modifiers, Modifier::Scale { by: 1e3 });
            push_transform(&mut modifiers, Modifier::Translate { by: [1.0; 3] });
            push_transform(&mut modifiers, Modifier::Scale { by: 1e2 });
        }
        assert!(modifiers.len() > MAX_TRANSFORMS);
        assert!(modifiers.iter().all(|m| m.check().is_ok()));
    }
}
