//! Applies a change of one selected node to the others.

use argil::scene::{Modifier, NodeDesc, NodeKind, Operator};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Applies the difference between `before` and `after` to another node, where it has the same kind of shape, or the
/// same kind of modifier at the same index.
pub(crate) fn apply_same_change(before: &NodeDesc, after: &NodeDesc, other: &NodeDesc) -> NodeDesc {
    let mut changed = other.clone();
    changed.operator = operator(&before.operator, &after.operator, other.operator);
    if before.material != after.material {
        changed.material.clone_from(&after.material);
    }
    if let (NodeKind::Shape(from), NodeKind::Shape(to), NodeKind::Shape(shape)) =
        (&before.kind, &after.kind, &mut changed.kind)
        && shape.file().is_none()
    {
        merge(from, to, shape);
    }
    modifiers(&before.modifiers, &after.modifiers, &mut changed.modifiers);
    changed
}

fn operator(before: &Operator, after: &Operator, other: Operator) -> Operator {
    fn pick<T: PartialEq>(before: T, after: T, other: T) -> T {
        if before == after { other } else { after }
    }
    Operator {
        kind: pick(before.kind, after.kind, other.kind),
        blend: pick(before.blend, after.blend, other.blend),
        profile: pick(before.profile, after.profile, other.profile),
        morph_amount: pick(before.morph_amount, after.morph_amount, other.morph_amount),
    }
}

fn modifiers(before: &[Modifier], after: &[Modifier], other: &mut Vec<Modifier>) {
    if after.len() > before.len() {
        // Added modifiers are appended.
        other.extend_from_slice(&after[before.len()..]);
        return;
    }
    if before == after || kinds(other) != kinds(before) {
        return;
    }
    if after.len() < before.len() {
        let gone = before.iter().zip(after).position(|(b, a)| b != a);
        other.remove(gone.unwrap_or(after.len()));
        return;
    }
    let swapped = (1..before.len()).find(|&at| {
        let mut reordered = before.to_vec();
        reordered.swap(at - 1, at);
        reordered == after
    });
    if let Some(at) = swapped {
        return other.swap(at - 1, at);
    }
    for ((before, after), other) in before.iter().zip(after).zip(other) {
        merge(before, after, other);
    }
}

fn kinds(all: &[Modifier]) -> Vec<std::mem::Discriminant<Modifier>> {
    all.iter().map(std::mem::discriminant).collect()
}

/// Copies the values that differ between two objects, where the types match.
fn merge<T: Serialize + DeserializeOwned + PartialEq>(before: &T, after: &T, other: &mut T) {
    if before == after {
        return;
    }
    let values = [before, after, other].map(|v| serde_json::to_value(v).expect("an entry is JSON"));
    let [before, after, mut merged] = values;
    if [&after, &merged]
        .iter()
        .any(|v| v["type"] != before["type"])
    {
        return;
    }
    merge_values(&before, &after, &mut merged);
    // A result that is not valid leaves the value as it was.
    if let Ok(merged) = serde_json::from_value(merged) {
        *other = merged;
    }
}

fn merge_values(before: &Value, after: &Value, other: &mut Value) {
    match (before, after, other) {
        (Value::Object(before), Value::Object(after), Value::Object(other)) => {
            for (key, after) in after {
                match (before.get(key), other.get_mut(key)) {
                    (Some(before), Some(other)) => merge_values(before, after, other),
                    (before, _) if before == Some(after) => {}
                    _ => drop(other.insert(key.clone(), after.clone())),
                }
            }
        }
        (Value::Array(before), Value::Array(after), Value::Array(other))
            if before.len() == after.len() && other.len() == after.len() =>
        {
            for ((before, after), other) in before.iter().zip(after).zip(other) {
                merge_values(before, after, other);
            }
        }
        (before, after, other) if before != after => *other = after.clone(),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use argil::scene::{Brush, OperatorKind, Shape};

    fn ball(radius: f32) -> NodeDesc {
        Brush::new(Shape::sphere(radius))
            .at([radius, 0.0, 0.0])
            .into()
    }

    #[test]
    fn only_what_is_changed_is_changed() {
        let (before, mut other) = (ball(1.0), ball(2.0));
        other.operator.blend = 0.3;
        let mut after = before.clone();
        after.operator.kind = OperatorKind::Subtract;
        after.modifiers = vec![Modifier::Translate {
            by: [1.0, 5.0, 0.0],
        }];
        let changed = apply_same_change(&before, &after, &other);
        let moved = [Modifier::Translate {
            by: [2.0, 5.0, 0.0],
        }];
        assert_eq!(changed.operator.kind, OperatorKind::Subtract);
        assert_eq!(changed.operator.blend, 0.3);
        assert_eq!(
            (changed.kind, changed.modifiers),
            (other.kind, moved.to_vec())
        );
        let changed = apply_same_change(&before, &ball(3.0), &ball(2.0));
        assert_eq!(changed.kind, ball(3.0).kind);
    }

    #[test]
    fn what_only_one_has_stays_its_own() {
        let repeat = |x: f32, count: Option<[u32; 3]>| {
            let spacing = [x, 0.0, 0.0];
            let mut entry = ball(1.0);
            entry.modifiers = vec![Modifier::Repeat { spacing, count }];
            entry
        };
        let count = Some([3, 1, 1]);
        let changed =
            apply_same_change(&repeat(1.0, count), &repeat(2.0, count), &repeat(1.0, None));
        assert_eq!(changed, repeat(2.0, None));
    }

    #[test]
    fn what_is_of_another_kind_stays() {
        let cube: NodeDesc = Brush::new(Shape::rounded_box([1.0; 3], 0.1))
            .with_modifier(Modifier::Round { radius: 0.1 })
            .into();
        let changed = apply_same_change(&ball(1.0), &ball(3.0), &cube);
        assert_eq!(changed, cube);
    }

    #[test]
    fn modifiers_come_go_and_change_places() {
        let twist = Modifier::Twist {
            degrees_per_unit: 9.0,
        };
        let before = ball(1.0);
        let mut after = before.clone();
        after.modifiers.push(twist.clone());
        let changed = apply_same_change(&before, &after, &ball(2.0));
        assert_eq!(changed.modifiers.len(), 2);
        let mut swapped = after.clone();
        swapped.modifiers.swap(0, 1);
        let moved = apply_same_change(&after, &swapped, &changed);
        assert_eq!(
            moved.modifiers,
            [twist.clone(), changed.modifiers[0].clone()]
        );
        // Two of a kind change places, too, not their values.
        let moved = |x: f32| Modifier::Translate { by: [x, 0.0, 0.0] };
        let two = |x: f32, y: f32| {
            let mut entry = ball(1.0);
            entry.modifiers = vec![moved(x), moved(y)];
            entry
        };
        let other = apply_same_change(&two(1.0, 2.0), &two(2.0, 1.0), &two(5.0, 6.0));
        assert_eq!(other, two(6.0, 5.0));
        let gone = apply_same_change(&after, &before, &changed);
        assert_eq!(gone, ball(2.0));
        let mut first_gone = after.clone();
        first_gone.modifiers.remove(0);
        assert_eq!(
            apply_same_change(&after, &first_gone, &changed).modifiers,
            [twist]
        );
    }
}
