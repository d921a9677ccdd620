//! Scenes of groups and their children.

use crate::case::{SceneCase, one, push};
use crate::shape_cases::vase;
use argil_scene::{Brush, Group, Modifier, Scene, Shape};

/// Returns scenes with orders, nesting, empty cuts and hidden nodes.
#[expect(clippy::too_many_lines, reason = "a list of cases")]
pub fn structure_cases() -> Vec<SceneCase> {
    let ball = |x: f32, r: f32| Brush::new(Shape::sphere(r)).at([x, 0.0, 0.0]);
    let mut all = vec![SceneCase {
        name: "nothing".into(),
        scene: Scene::new(),
    }];
    all.push(one("a cut of nothing", ball(0.0, 0.5).subtract()));
    all.push(one("a hidden ball", ball(0.0, 0.5).hidden()));

    let mut scene = Scene::new();
    push(&mut scene, Scene::ROOT, ball(0.9, 0.3).subtract());
    push(&mut scene, Scene::ROOT, ball(0.0, 0.5));
    push(
        &mut scene,
        Scene::ROOT,
        ball(0.2, 0.4).intersect().smooth(0.1),
    );
    push(&mut scene, Scene::ROOT, Group::new());
    push(&mut scene, Scene::ROOT, Group::new().subtract());
    all.push(SceneCase {
        name: "a cut first, empty groups last".into(),
        scene,
    });

    // A chain of nested groups, where the second operand of each group is a group. The operand that needs more
    // slots comes first.
    let mut scene = Scene::new();
    let mut group = Scene::ROOT;
    for depth in 0..40 {
        let angle = depth as f32 * 0.7;
        let at = [
            0.6 * angle.cos(),
            0.02 * depth as f32 - 0.4,
            0.6 * angle.sin(),
        ];
        push(&mut scene, group, Brush::new(Shape::sphere(0.12)).at(at));
        let next = match depth % 4 {
            0 => Group::new().smooth(0.05),
            1 => Group::new().subtract().smooth(0.03),
            2 => Group::new().chamfer(0.04),
            _ => Group::new().morph(0.9),
        };
        group = push(&mut scene, group, next.rotated([0.0, 1.0, 0.0], 3.0));
    }
    push(&mut scene, group, ball(0.1, 0.2));
    all.push(SceneCase {
        name: "a chain of forty groups".into(),
        scene,
    });

    // Nested loops under deformations.
    let mut scene = Scene::new();
    let outer = Group::new()
        .with_modifier(Modifier::Repeat {
            spacing: [0.8, 0.0, 0.0],
            count: Some([2, 1, 1]),
        })
        .with_modifier(Modifier::Twist {
            degrees_per_unit: 40.0,
        })
        .with_modifier(Modifier::Shell {
            half_thickness: 0.03,
        });
    let outer = push(&mut scene, Scene::ROOT, outer);
    let ring = push(
        &mut scene,
        outer,
        Group::new().with_modifier(Modifier::RadialRepeat { count: 5 }),
    );
    push(
        &mut scene,
        ring,
        Brush::new(Shape::rounded_box([0.1, 0.2, 0.05], 0.02)).at([0.22, 0.0, 0.0]),
    );
    push(
        &mut scene,
        outer,
        Brush::new(Shape::sphere(0.15))
            .at([0.0, 0.2, 0.0])
            .smooth(0.05),
    );
    push(
        &mut scene,
        Scene::ROOT,
        ball(0.0, 0.3)
            .subtract()
            .smooth(0.05)
            .with_modifier(Modifier::Round { radius: 0.02 }),
    );
    all.push(SceneCase {
        name: "loops in loops".into(),
        scene,
    });

    // Inside its own cut, a curve is as near as what it cuts, although its box is at distance 0.
    let mut scene = Scene::new();
    let lathe = || Brush::new(Shape::Lathe { outline: vase() });
    push(&mut scene, Scene::ROOT, lathe());
    for _ in 0..2 {
        push(&mut scene, Scene::ROOT, lathe().subtract().smooth(0.05));
    }
    all.push(SceneCase {
        name: "a curve cut from itself twice".into(),
        scene,
    });
    all
}
