//! Scenes of each operator.

use crate::case::{SceneCase, push};
use argil_scene::{Brush, Material, Scene, Shape};

/// Returns each operator with each blend, between a ball and a rotated box.
pub fn operator_cases() -> Vec<SceneCase> {
    let mut all = Vec::new();
    type Apply = fn(Brush) -> Brush;
    let operators: [(&str, Apply); 5] = [
        ("union", |b| b),
        ("subtract", Brush::subtract),
        ("intersect", Brush::intersect),
        ("paint", Brush::paint),
        ("morph", |b| b.morph(0.3)),
    ];
    for (name, operator) in operators {
        for (joint, k, chamfer) in [
            ("hard", 0.0, false),
            ("smooth", 0.2, false),
            ("chamfer", 0.2, true),
        ] {
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
    all
}
