//! Applies a change of one selected node to the others.

use argil::scene::{Modifier, NodeDesc, NodeKind, Operator};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Applies the difference between `before` and `after` to another node, where it has the same kind of shape, or the
/// same kind of modifier at the same index.
pub(crate) fn apply_same_change(before: &NodeDesc, after: &NodeDesc, other: &NodeDesc) -> NodeDesc {
    let mut own = other.clone();
    own.operator = operator(&before.operator, &after.operator, other.operator);
    if before.material != after.material {
        own.material.clone_from(&after.material);
    }
    if let (NodeKind::Shape(from), NodeKind::Shape(to), NodeKind::Shape(shape)) =
        (&before.kind, &after.kind, &mut own.kind)
        && shape.file().is_none()
    {
        merge(from, to, shape);
    }
    modifiers(&before.modifiers, &after.modifiers, &mut own.modifiers);
    own
}

fn operator(before: &Operator, after: &Operator, own: Operator) -> Operator {
    fn pick<T: PartialEq>(before: T, after: T, own: T) -> T {
        if before == after { own } else { after }
    }
    Operator {
        kind: pick(before.kind, after.kind, own.kind),
        blend: pick(before.blend, after.blend, own.blend),
        profile: pick(before.profile, after.profile, own.profile),
        morph_amount: pick(before.morph_amount, after.morph_amount, own.morph_amount),
    }
}

fn modifiers(before: &[Modifier], after: &[Modifier], own: &mut Vec<Modifier>) {
    if after.len() > before.len() {
        // Added modifiers are appended.
        own.extend_from_slice(&after[before.len()..]);
        return;
    }
    if before == after || kinds(own) != kinds(before) {
        return;
    }
    if after.len() < before.len() {
        let gone = before.iter().zip(after).position(|(b, a)| b != a);
        own.remove(gone.unwrap_or(after.len()));
        return;
    }
    let swapped = (1..before.len()).find(|&at| {
        let mut own = before.to_vec();
        own.swap(at - 1, at);
        own == after
    });
    if let Some(at) = swapped {
        return own.swap(at - 1, at);
    }
    for ((before, after), own) in before.iter().zip(after).zip(own) {
        merge(before, after, own);
    }
}

fn kinds(all: &[Modifier]) -> Vec<std::mem::Discriminant<Modifier>> {
    all.iter().map(std::mem::discriminant).collect()
}

/// Copies the values that differ between two objects, where the types match.
fn merge<T: Serialize + DeserializeOwned + PartialEq>(before: &T, after: &T, own: &mut T) {
    if before == after {
        return;
    }
    let values = [before, after, own].map(|v| serde_json::to_value(v).expect("an entry is JSON"));
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
        *own = merged;
    }
}

fn merge_values(before: &Value, after: &Value, own: &mut Value) {
    match (before, after, own) {
        (Value::Object(before), Value::Object(after), Value::Object(own)) => {
            for (key, after) in after {
                match (before.get(key), own.get_mut(key)) {
                    (Some(before), Some(own)) => merge_values(before, after, own),
                    (before, _) if before == Some(after) => {}
                    _ => drop(own.insert(key.clone(), after.clone())),
                }
            }
        }
        (Value::Array(before), Value::Array(after), Value::Array(own))
            if before.len() == after.len() && own.len() == after.len() =>
        {
            for ((before, after), own) in before.iter().zip(after).zip(own) {
                merge_values(before, after, own);
            }
        }
        (before, after, own) if before != after => *own = after.clone(),
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
        let own = apply_same_change(&before, &after, &other);
        let moved = [Modifier::Translate {
            by: [2.0, 5.0, 0.0],
        }];
        assert_eq!(own.operator.kind, OperatorKind::Subtract);
        assert_eq!(own.operator.blend, 0.3);
        assert_eq!((own.kind, own.modifiers), (other.kind, moved.to_vec()));
        let own = apply_same_change(&before, &ball(3.0), &ball(2.0));
        assert_eq!(own.kind, ball(3.0).kind);
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
        let own = apply_same_change(&repeat(1.0, count), &repeat(2.0, count), &repeat(1.0, None));
        assert_eq!(own, repeat(2.0, None));
    }

    #[test]
    fn what_is_of_another_kind_stays() {
        let cube: NodeDesc = Brush::new(Shape::rounded_box([1.0; 3], 0.1))
            .with_modifier(Modifier::Round { radius: 0.1 })
            .into();
        let own = apply_same_change(&ball(1.0), &ball(3.0), &cube);
        assert_eq!(own, cube);
    }

    #[test]
    fn modifiers_come_go_and_change_places() {
        let twist = Modifier::Twist {
            degrees_per_unit: 9.0,
        };
        let before = ball(1.0);
        let mut after = before.clone();
        after.modifiers.push(twist.clone());
        let own = apply_same_change(&before, &after, &ball(2.0));
        assert_eq!(own.modifiers.len(), 2);
        let mut swapped = after.clone();
        swapped.modifiers.swap(0, 1);
        let moved = apply_same_change(&after, &swapped, &own);
        assert_eq!(moved.modifiers, [twist.clone(), own.modifiers[0].clone()]);
        // Two of a kind change places, too, not their values.
        let moved = |x: f32| Modifier::Translate { by: [x, 0.0, 0.0] };
        let two = |x: f32, y: f32| {
            let mut entry = ball(1.0);
            entry.modifiers = vec![moved(x), moved(y)];
            entry
        };
        let other = apply_same_change(&two(1.0, 2.0), &two(2.0, 1.0), &two(5.0, 6.0));
        assert_eq!(other, two(6.0, 5.0));
        let gone = apply_same_change(&after, &before, &own);
        assert_eq!(gone, ball(2.0));
        let mut first_gone = after.clone();
        first_gone.modifiers.remove(0);
        assert_eq!(
            apply_same_change(&after, &first_gone, &own).modifiers,
            [twist]
        );
    }
}
