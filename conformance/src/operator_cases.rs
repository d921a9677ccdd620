//! Scenes of each operator.

use crate::case::{SceneCase, push};
use argil_scene::{Brush, Curve, Group, Material, MorphRamp, Ramp, Scene, Shape};

/// Returns each operator with each blend, between a ball and a rotated box.
pub fn operator_cases() -> Vec<SceneCase> {
    let mut all = Vec::new();
    type Apply = fn(Brush) -> Brush;
    let operators: [(&str, Apply); 7] = [
        ("union", |b| b),
        ("subtract", Brush::subtract),
        ("intersect", Brush::intersect),
        ("paint", Brush::paint),
        ("morph", |b| b.morph(0.3)),
        ("morph along a line", |b| {
            let along = Ramp::Line {
                from: [-0.4, -0.1, 0.0],
                to: [0.5, 0.2, 0.0],
                curve: Curve::from_fn(1, |t| t * t),
            };
            b.morph(0.9).with_ramp(MorphRamp {
                along,
                max_difference: 1.2,
            })
        }),
        ("morph with the radius", |b| {
            let along = Ramp::Radius {
                from: 0.1,
                to: 0.6,
                curve: Curve::from_fn(1, |t| 2.2 * t * t * t - 1.2 * t * t),
            };
            b.morph(1.0).with_ramp(MorphRamp {
                along,
                max_difference: 1.2,
            })
        }),
    ];
    for (name, operator) in operators {
        for (joint, k, chamfer) in [
            ("hard", 0.0, false),
            ("smooth", 0.2, false),
            ("chamfer", 0.2, true),
        ] {
            // A morph has no joint.
            if name.starts_with("morph ") && k > 0.0 {
                continue;
            }
            let mut scene = Scene::new();
            scene
                .set_material("red", Material::colored([0.8, 0.1, 0.1]))
                .expect("a valid material");
            scene
                .set_material("blue", Material::colored([0.1, 0.1, 0.8]))
                .expect("a valid material");
            push(
                &mut scene,
                Scene::ROOT,
                Brush::new(Shape::sphere(0.5)).with_material("red"),
            );
            let second = Brush::new(Shape::cuboid([0.3; 3]))
                .rotated([1.0, 1.0, 0.0], 30.0)
                .at([0.4, 0.2, 0.0]);
            let second = if chamfer {
                second.chamfer(k)
            } else {
                second.smooth(k)
            };
            push(
                &mut scene,
                Scene::ROOT,
                operator(second.with_material("blue")),
            );
            all.push(SceneCase {
                name: format!("{joint} {name}"),
                scene,
            });
        }
    }
    all.push(ramps_in_groups());
    all
}

/// Returns morphs with ramps whose operands are groups, in a group with a transform.
fn ramps_in_groups() -> SceneCase {
    let along = Ramp::Line {
        from: [0.0, -0.5, 0.0],
        to: [0.0, 0.5, 0.0],
        curve: Curve::linear(),
    };
    let ramp = MorphRamp {
        along,
        max_difference: 0.8,
    };
    let mut scene = Scene::new();
    let outer = Group::new().rotated([1.0, 0.0, 0.2], 40.0).scaled(0.8);
    let outer = push(&mut scene, Scene::ROOT, outer.at([0.1, 0.0, 0.2]));
    push(&mut scene, outer, Brush::new(Shape::cylinder(0.4, 0.5)));
    let cut = Brush::new(Shape::cylinder(0.2, 1e6)).rotated([1.0, 0.0, 0.0], 90.0);
    push(&mut scene, outer, cut.subtract().smooth(0.05));
    let star = push(&mut scene, outer, Group::new().morph(1.0).with_ramp(ramp));
    for degrees in [0.0, 45.0] {
        let part = Brush::new(Shape::cuboid([0.3, 0.5, 0.3])).rotated([0.0, 1.0, 0.0], degrees);
        push(&mut scene, star, part);
    }
    push(
        &mut scene,
        outer,
        Brush::new(Shape::sphere(0.2))
            .at([0.4, 0.3, 0.0])
            .smooth(0.1),
    );
    SceneCase {
        name: "ramps in groups".to_owned(),
        scene,
    }
}
