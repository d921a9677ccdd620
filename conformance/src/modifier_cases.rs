//! Scenes of each modifier.

use crate::case::{SceneCase, one, push};
use argil_scene::{Brush, Curve, Group, Modifier, Pose, Ramp, Scene, Shape};

/// Returns instances of two scales, which overlap here and there.
fn instances() -> Modifier {
    let rows = [
        [0.5, 0.1, 0.0, 30.0, 1.0],
        [-0.5, -0.1, 0.2, -70.0, 0.6],
        [0.1, 0.4, -0.5, 200.0, 1.0],
        [0.0, -0.4, 0.4, 10.0, 0.6],
        [-0.6, 0.3, -0.3, 90.0, 0.6],
    ];
    Modifier::Instances {
        poses: rows.map(Pose::from).to_vec().into(),
    }
}

/// Returns each modifier, on a brush and on a blended group, with transforms around it.
#[expect(clippy::too_many_lines, reason = "a list of cases")]
pub fn modifier_cases() -> Vec<SceneCase> {
    let modifiers: Vec<(&str, Modifier)> = vec![
        (
            "translate",
            Modifier::Translate {
                by: [0.2, -0.1, 0.3],
            },
        ),
        (
            "rotate",
            Modifier::Rotate {
                axis: [1.0, 0.5, -0.2],
                degrees: 40.0,
            },
        ),
        ("scale", Modifier::Scale { by: 0.6 }),
        (
            "stretch",
            Modifier::Stretch {
                by: [1.4, 0.6, 0.9],
            },
        ),
        (
            "mirror",
            Modifier::Mirror {
                axes: [true, false, true],
            },
        ),
        (
            "repeat",
            Modifier::Repeat {
                spacing: [0.9, 0.7, 1.0],
                count: Some([3, 2, 4]),
            },
        ),
        (
            "repeat along x",
            Modifier::Repeat {
                spacing: [0.9, 0.0, 0.0],
                count: Some([3, 1, 1]),
            },
        ),
        (
            "infinite repeat",
            Modifier::Repeat {
                spacing: [1.1, 0.0, 1.3],
                count: None,
            },
        ),
        (
            "overlapping repeat",
            Modifier::Repeat {
                spacing: [0.4, 0.0, 0.0],
                count: Some([4, 1, 1]),
            },
        ),
        ("instances", instances()),
        (
            "elongate",
            Modifier::Elongate {
                by: [0.2, 0.0, 0.1],
            },
        ),
        ("round", Modifier::Round { radius: 0.08 }),
        (
            "shell",
            Modifier::Shell {
                half_thickness: 0.04,
            },
        ),
        (
            "twist",
            Modifier::Twist {
                degrees_per_unit: 110.0,
            },
        ),
        (
            "bend",
            Modifier::Bend {
                degrees_per_unit: 50.0,
            },
        ),
        ("round inward", Modifier::Round { radius: -0.06 }),
        (
            "shift along a line",
            Modifier::Shift {
                by: [0.1, 0.3, -0.2],
                along: Ramp::Line {
                    from: [-0.2, 0.0, 0.1],
                    to: [0.3, 0.1, 0.0],
                    curve: Curve::from_fn(2, |t| {
                        if t < 0.5 {
                            2.0 * t * t
                        } else {
                            1.0 - 2.0 * (1.0 - t) * (1.0 - t)
                        }
                    }),
                },
            },
        ),
        (
            "shift with the radius",
            Modifier::Shift {
                by: [0.0, 0.25, 0.0],
                along: Ramp::Radius {
                    from: 0.5,
                    to: 0.05,
                    curve: Curve::linear(),
                },
            },
        ),
        (
            "wrap",
            Modifier::Wrap {
                from: -1.0,
                to: 0.8,
                radius: 0.5,
                curve: Curve::linear(),
            },
        ),
        (
            "wrap onto itself",
            Modifier::Wrap {
                from: 0.3,
                to: -0.3,
                radius: 0.2,
                curve: Curve::from_fn(4, |t| t + 0.05 * (12.0 * t).sin()),
            },
        ),
        ("extrude", Modifier::Extrude { half_depth: 0.35 }),
        ("revolve", Modifier::Revolve { offset: 0.2 }),
        ("scale distance", Modifier::ScaleDistance { by: 0.4 }),
        (
            "displace",
            Modifier::Displace {
                amplitude: 0.05,
                frequency: 4.0,
                seed: 7,
                octaves: 3,
            },
        ),
    ];
    let mut all = Vec::new();
    let body = || Brush::new(Shape::rounded_box([0.3, 0.2, 0.25], 0.05)).at([0.06, 0.04, -0.03]);
    for (name, modifier) in modifiers {
        all.push(one(name, body().with_modifier(modifier.clone())));
        let around = body()
            .with_modifier(modifier.clone())
            .rotated([0.0, 1.0, 0.3], 35.0)
            .scaled(1.3)
            .at([0.1, 0.2, 0.0]);
        all.push(one(&format!("{name}, placed"), around));
        let mut scene = Scene::new();
        let group = Group::new()
            .with_modifier(modifier)
            .rotated([1.0, 0.0, 0.3], 20.0)
            .scaled(0.8);
        let group = push(&mut scene, Scene::ROOT, group);
        push(&mut scene, group, body());
        push(
            &mut scene,
            group,
            Brush::new(Shape::sphere(0.18))
                .at([0.15, 0.15, 0.1])
                .smooth(0.1),
        );
        all.push(SceneCase {
            name: format!("{name}, group"),
            scene,
        });
    }
    all.extend(nested_instances());
    for (name, count, x) in [
        ("ring", 7, 0.7),
        ("ring around the axis", 5, 0.1),
        ("ring of one", 1, 0.5),
        ("ring of two", 2, 0.6),
    ] {
        let spoke = Brush::new(Shape::cuboid([0.2, 0.15, 0.12]))
            .rotated([0.0, 1.0, 0.0], 15.0)
            .at([x, 0.0, 0.05]);
        all.push(one(
            name,
            spoke
                .with_modifier(Modifier::RadialRepeat { count })
                .at([0.1, 0.0, 0.2]),
        ));
    }
    all
}

/// Returns instances of what has loops and warps, and instances of instances, in joints of several kinds.
fn nested_instances() -> Vec<SceneCase> {
    let body = || Brush::new(Shape::rounded_box([0.2, 0.1, 0.12], 0.03)).at([0.05, 0.0, 0.0]);
    let twist = Modifier::Twist {
        degrees_per_unit: 90.0,
    };
    let row = Modifier::Repeat {
        spacing: [0.5, 0.0, 0.0],
        count: Some([2, 1, 1]),
    };
    let twisted = body()
        .with_modifier(twist)
        .with_modifier(row)
        .with_modifier(instances());
    let twice = body()
        .scaled(0.4)
        .with_modifier(instances())
        .scaled(0.5)
        .with_modifier(instances());
    // Many, so that clusters of them are skipped.
    let many = (0..120u16).map(|i| {
        let along = |k: u16| f32::from(i * k % 121) / 121.0 * 2.4 - 1.2;
        let scale = if i % 3 == 0 { 0.2 } else { 0.4 };
        [along(7), along(13), along(29), f32::from(i) * 11.0, scale]
    });
    let many = Modifier::Instances {
        poses: many.map(Pose::from).collect::<Vec<_>>().into(),
    };
    let mut scene = Scene::new();
    push(&mut scene, Scene::ROOT, Brush::new(Shape::cuboid([0.6; 3])));
    let holes = Brush::new(Shape::sphere(0.2)).with_modifier(instances());
    push(&mut scene, Scene::ROOT, holes.subtract().smooth(0.1));
    vec![
        one("instances of twisted rows", twisted),
        one("instances of instances", twice),
        one("many instances", body().with_modifier(many)),
        SceneCase {
            name: "instances as holes".to_owned(),
            scene,
        },
    ]
}
