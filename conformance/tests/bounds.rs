//! Conservative: intervals over boxes contain every distance in them, and dirty boxes contain every change.

use argil_conformance::{CaseRng, SceneCase, all_cases, rounding};
use argil_field::{FAR, Program, naive};
use argil_math::Aabb;
use argil_scene::{Brush, Curve, Edit, Group, Modifier, MorphRamp, NodeId, Ramp, Scene, Shape};
use glam::Vec3;

fn lower(scene: &Scene) -> Program {
    Program::lower(scene).expect("a case that can be lowered")
}

#[test]
fn intervals_hold_the_oracles_distances() {
    let mut sharp = 0;
    for SceneCase { name, scene } in all_cases() {
        let program = lower(&scene);
        let mut numbers = CaseRng::new(11);
        for _ in 0..25 {
            let (center, size) = (numbers.point(1.2), numbers.between(0.02, 0.6));
            let region = Aabb::new(center - size * numbers.unit(), center + size);
            let interval = program.bounds(region);
            let mut extremes = (f64::INFINITY, f64::NEG_INFINITY);
            for i in 0..24 {
                let unit = Vec3::new(numbers.unit(), numbers.unit(), numbers.unit());
                let p = if i < 8 {
                    region.corners()[i]
                } else {
                    region.min + region.size() * unit
                };
                let d = naive::distance(&scene, p);
                extremes = (extremes.0.min(d), extremes.1.max(d));
            }
            if extremes.0 > 0.1 * f64::from(FAR) {
                continue;
            }
            let slack = f64::from(rounding(center.to_array()));
            let holds = f64::from(interval.min) <= extremes.0 + slack
                && extremes.1 <= f64::from(interval.max) + slack;
            assert!(
                holds,
                "{name}: {interval:?} over {region:?} does not hold {extremes:?}"
            );
            // Negative control: half of the width would not do.
            let (middle, half) = (
                f64::from(interval.min + interval.max) / 2.0,
                f64::from(interval.max - interval.min) / 4.0,
            );
            sharp += usize::from(extremes.0 < middle - half || extremes.1 > middle + half);
        }
    }
    assert!(sharp > 100, "{sharp}");
}

/// The program's box contains the solid.
#[test]
fn the_programs_box_holds_the_solid() {
    for SceneCase { name, scene } in all_cases() {
        let bounds = lower(&scene).aabb();
        let mut numbers = CaseRng::new(12);
        for _ in 0..1200 {
            let p = numbers.point(2.5);
            assert!(
                bounds.contains(p) || naive::distance(&scene, p) > 0.0,
                "{name}: {p} is solid and outside of {bounds:?}"
            );
        }
    }
}

/// Returns a scene to edit, with overlapping, blended and subtracted brushes in groups with modifiers.
fn garden() -> (Scene, Vec<NodeId>) {
    let mut scene = Scene::new();
    let mut nodes = Vec::new();
    let mut numbers = CaseRng::new(21);
    let mut brush = |i: usize| {
        let at = numbers.point(0.9).to_array();
        let shape = match i % 4 {
            0 => Shape::sphere(numbers.between(0.1, 0.35)),
            1 => Shape::rounded_box([0.2, 0.15, 0.3], 0.04),
            2 => Shape::torus(0.25, 0.08),
            _ => Shape::capsule([-0.2, 0.0, 0.0], [0.2, 0.1, 0.0], 0.1),
        };
        let brush = Brush::new(shape)
            .rotated([1.0, 0.3, 0.2], 30.0 * i as f32)
            .at(at);
        let k = numbers.between(0.0, 0.15);
        match i % 5 {
            1 => brush.subtract().smooth(k),
            2 => brush.chamfer(k),
            _ => brush.smooth(k),
        }
    };
    for i in 0..12 {
        nodes.push(scene.push(brush(i)).expect("valid").node);
    }
    let twisted = Group::new()
        .with_modifier(Modifier::Twist {
            degrees_per_unit: 60.0,
        })
        .at([0.3, 0.0, 0.2])
        .smooth(0.1);
    let mirrored = Group::new()
        .with_modifier(Modifier::Mirror {
            axes: [true, false, false],
        })
        .scaled(0.8)
        .subtract()
        .smooth(0.05);
    let repeated = Group::new().with_modifier(Modifier::Repeat {
        spacing: [1.2, 0.0, 0.0],
        count: Some([2, 1, 1]),
    });
    let rough = Modifier::Displace {
        amplitude: 0.03,
        frequency: 3.0,
        seed: 2,
        octaves: 2,
    };
    let rounded = Group::new()
        .with_modifier(rough)
        .with_modifier(Modifier::Shell {
            half_thickness: 0.05,
        });
    for (g, group) in [twisted, mirrored, repeated, rounded]
        .into_iter()
        .enumerate()
    {
        let group = scene.push(group).expect("valid").node;
        nodes.push(group);
        for i in 0..3 {
            nodes.push(
                scene
                    .push_into(group, brush(13 + 3 * g + i))
                    .expect("valid")
                    .node,
            );
        }
    }
    for i in 30..34 {
        nodes.push(scene.push(brush(i)).expect("valid").node);
    }
    (scene, nodes)
}

/// Counts sampled distances, clamped to the band, that change outside and inside of a box.
fn changes(
    before: &Program,
    after: &Program,
    dirty: Aabb,
    band: f32,
    numbers: &mut CaseRng,
) -> (usize, usize) {
    let (mut outside, mut inside) = (0, 0);
    for _ in 0..1500 {
        let p = numbers.point(1.8);
        let (a, b) = (
            before.distance(p).clamp(-band, band),
            after.distance(p).clamp(-band, band),
        );
        // Removing an operand reorders nothing, so what does not depend on it keeps its bits; 2⁻²⁴ of a blend may stay.
        if (a - b).abs() > 1e-6 {
            if dirty.contains(p) {
                inside += 1
            } else {
                outside += 1
            }
        }
    }
    (outside, inside)
}

fn edits(nodes: &[NodeId]) -> Vec<Edit> {
    let mut edits = Vec::new();
    for (i, &node) in nodes.iter().enumerate() {
        edits.push(match i % 5 {
            0 => Edit::Remove { node },
            1 => Edit::Transform {
                node,
                by: Modifier::Translate {
                    by: [0.1, -0.05, 0.08],
                },
            },
            2 => Edit::SetVisible {
                node,
                visible: false,
            },
            3 => Edit::Move {
                node,
                parent: Scene::ROOT,
                index: 3,
            },
            _ => Edit::Transform {
                node,
                by: Modifier::Rotate {
                    axis: [0.0, 1.0, 0.0],
                    degrees: 20.0,
                },
            },
        });
    }
    let ball = || Brush::new(Shape::sphere(0.3)).at([0.2, 0.1, -0.3]);
    for entry in [
        ball().smooth(0.1),
        ball().subtract().smooth(0.05),
        ball().intersect(),
        ball().morph(0.4),
    ] {
        edits.push(Edit::Insert {
            parent: Scene::ROOT,
            index: 5,
            desc: entry.into(),
        });
    }
    edits
}

#[test]
fn nothing_changes_outside_of_dirty_boxes_and_undo_restores() {
    let mut numbers = CaseRng::new(22);
    let (mut seen, mut smaller_would_miss) = (0, 0);
    for (band, crowd) in [(0.05, 0), (0.2, 0), (0.1, 300)] {
        let (mut scene, nodes) = garden();
        // So many operands that the box does not look at each of them.
        for _ in 0..crowd {
            let small = Brush::new(Shape::sphere(0.05))
                .at(numbers.point(1.5).to_array())
                .smooth(0.02);
            scene.push(small).expect("a valid brush");
        }
        let _watch = scene.request_margins([band, 2.0 * band]);
        for edit in edits(&nodes) {
            let text = scene.to_json();
            let before = lower(&scene);
            let edited = scene.apply(edit.clone()).expect("a valid edit");
            let after = lower(&scene);
            let (outside, inside) = changes(&before, &after, edited.dirty_box, band, &mut numbers);
            assert_eq!(outside, 0, "{edit:?}: outside of {:?}", edited.dirty_box);
            seen += inside;
            let change = scene
                .changes_since(0)
                .expect("changes")
                .last()
                .expect("the edit's");
            let (outside, _) = changes(
                &before,
                &after,
                change.influence_box,
                2.0 * band,
                &mut numbers,
            );
            assert_eq!(
                outside, 0,
                "{edit:?}: outside of {:?}",
                change.influence_box
            );
            // Negative control: the box half as large misses changes.
            let b = edited.dirty_box;
            if b.is_finite() {
                let half = Aabb::new(b.center() - b.size() * 0.25, b.center() + b.size() * 0.25);
                smaller_would_miss += changes(&before, &after, half, band, &mut numbers).0;
            }

            // Back and forth and back: the same text, and the same boxes hold.
            let done = scene.to_json();
            let undone = scene.undo().expect("one to undo");
            assert_eq!(scene.to_json(), text, "{edit:?}");
            assert_eq!(undone.dirty_box, edited.dirty_box);
            scene.redo().expect("one to redo");
            assert_eq!(scene.to_json(), done);
            scene.undo().expect("one to undo");
        }
    }
    assert!(
        seen > 1000 && smaller_would_miss > 50,
        "{seen}, {smaller_would_miss}"
    );
}

/// A ramp divides the distances of all before it, by a factor that depends on the shapes before it.
#[test]
fn dirty_boxes_hold_what_a_ramp_divides() {
    let mut numbers = CaseRng::new(23);
    let (band, mut seen) = (0.05, 0);
    for endless in [true, false] {
        let half = if endless { 1e6 } else { 0.3 };
        let cylinder = |radius| Brush::new(Shape::cylinder(radius, half));
        let mut scene = Scene::new();
        scene.push(Shape::sphere(0.1)).expect("a valid brush");
        let group = scene.push(Group::new()).expect("a valid group").node;
        let ramped = cylinder(0.5).morph(1.0).with_ramp(MorphRamp {
            along: Ramp::Line {
                from: [0.0, -0.1, 0.0],
                to: [0.0, 0.05, 0.0],
                curve: Curve::linear(),
            },
            max_difference: 0.4,
        });
        let first = scene.push_into(group, cylinder(0.2)).expect("valid").node;
        scene.push_into(group, ramped).expect("valid");
        if endless {
            let slab = Brush::new(Shape::cuboid([1.0, 0.25, 1.0])).intersect();
            scene.push_into(group, slab).expect("valid");
        }
        let _watch = scene.request_margins([band, 2.0 * band]);
        for desc in [
            cylinder(0.25),
            Brush::new(Shape::sphere(0.25)),
            cylinder(0.15).rotated([1.0, 0.0, 0.0], 90.0),
        ] {
            let before = lower(&scene);
            let edited = scene.apply(Edit::Replace {
                node: first,
                desc: desc.into(),
            });
            let after = lower(&scene);
            let dirty_box = edited.expect("a valid edit").dirty_box;
            let (outside, inside) = changes(&before, &after, dirty_box, band, &mut numbers);
            assert_eq!(outside, 0, "{endless}: outside of {dirty_box:?}");
            seen += inside;
        }
    }
    assert!(seen > 30, "{seen}");
}

#[test]
fn dirty_boxes_are_tight() {
    let mut scene = Scene::new();
    for i in 0..100 {
        scene
            .push(
                Brush::new(Shape::sphere(0.2))
                    .at([i as f32, 0.0, 0.0])
                    .smooth(0.1),
            )
            .expect("valid");
    }
    let node = scene.node(Scene::ROOT).children()[3];
    let edited = scene
        .apply(Edit::SetVisible {
            node,
            visible: false,
        })
        .expect("valid");
    // 0.2 of radius, 0.1 of band, 0.1 of its own blend; its neighbors are too far to carry it on.
    assert!(
        edited.dirty_box.size().max_element() < 2.0 * 0.401,
        "{:?}",
        edited.dirty_box
    );
}

/// Boxes of edits rely on this: outside of its box, the distance to a shape is at least the distance to the box.
#[test]
fn no_shape_is_nearer_than_its_box() {
    for (name, shape) in argil_conformance::shapes() {
        let bounds = shape.aabb();
        if !bounds.is_finite() {
            continue;
        }
        let mut scene = Scene::new();
        scene.push(Brush::new(shape)).expect("a valid brush");
        let program = Program::lower(&scene).expect("a program");
        for p in argil_conformance::points(4000, 11) {
            let p = 2.0 * Vec3::from(p);
            let way = p.distance(p.clamp(bounds.min, bounds.max));
            if way == 0.0 {
                continue;
            }
            let d = program.distance(p);
            assert!(
                d >= 0.999 * way - 1e-5,
                "{name}: {d} at {p}, and the box is {way} away"
            );
        }
    }
}

/// Against the surface itself. A displaced sphere's distances are lower bounds, and away from it they fall short by no
/// more than the displacement, however steep the noise is.
#[test]
fn displaced_distances_are_nearly_true_far_away() {
    let (amplitude, octaves) = (0.1, 4);
    let rough = Modifier::Displace {
        amplitude,
        frequency: 3.0,
        seed: 5,
        octaves,
    };
    let mut scene = Scene::new();
    scene
        .push(Brush::new(Shape::sphere(1.0)).with_modifier(rough))
        .expect("valid");
    let program = lower(&scene);
    let most = amplitude * (2.0 - 0.5f32.powi(octaves as i32 - 1));
    let mut numbers = CaseRng::new(7);
    let mut far = 0;
    for _ in 0..400 {
        let p = numbers.point(4.0);
        let (d, of_sphere) = (program.distance(p), p.length() - 1.0);
        assert!(
            (d - of_sphere).abs() <= most + 1e-4,
            "{p}: {d} of {of_sphere}"
        );
        // No point of a ball of that radius is on the other side.
        for _ in 0..20 {
            let q = p + numbers.point(1.0).normalize_or_zero() * (0.99 * d.abs());
            assert!(program.distance(q) * d >= 0.0, "{p} and {q}");
        }
        far += u32::from(of_sphere > 1.0);
    }
    assert!(far > 100, "{far}");
}
