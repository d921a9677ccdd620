//! Instances of all kinds, against the nearest of their spheres, and their size.

use argil_field::{Evaluator, Program, Pruner};
use argil_scene::{Brush, Group, Modifier, Pose, Scene, Shape};
use glam::{DVec3, Vec3};

/// Numbers from 0 to 1 (xorshift).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    fn poses(&mut self, count: usize, size: f32, is_scaled: bool) -> Vec<Pose> {
        let pose = |_| Pose {
            position: [self.next(), self.next(), self.next()].map(|t| size * (t - 0.5)),
            degrees: 360.0 * self.next(),
            scale: if is_scaled { 0.5 + self.next() } else { 1.0 },
        };
        (0..count).map(pose).collect()
    }
}

/// Spheres in the scene: their centers and radii.
type Spheres = Vec<(DVec3, f64)>;

/// Returns spheres at poses.
fn placed(spheres: &Spheres, poses: &[Pose]) -> Spheres {
    let each = poses.iter().flat_map(|pose| {
        let outer = pose.own_from_outer().inverse();
        let place = move |&(center, radius): &(DVec3, f64)| {
            (
                outer.transform_point3(center),
                radius * f64::from(pose.scale),
            )
        };
        spheres.iter().map(place)
    });
    each.collect()
}

fn instances(poses: &[Pose]) -> Modifier {
    let poses = poses.to_vec().into();
    Modifier::Instances { poses }
}

fn ball(at: [f32; 3], radius: f32) -> Brush {
    Brush::new(Shape::sphere(radius)).at(at)
}

/// A name, a scene, its spheres, and the most bytes that a copy of a brush may take.
fn cases() -> Vec<(&'static str, Scene, Spheres, usize)> {
    let mut random = Random(11);
    let mut scenes = Vec::new();
    let one = vec![(DVec3::X * 0.5, f64::from(0.2f32))];
    for (name, count, is_scaled) in [
        ("seven brushes", 7, false),
        ("brushes", 5000, false),
        ("brushes of many sizes", 5000, true),
    ] {
        let poses = random.poses(count, 20.0, is_scaled);
        let mut scene = Scene::new();
        let brush = ball([0.5, 0.0, 0.0], 0.2).with_modifier(instances(&poses));
        scene.push(brush).expect("a brush");
        scenes.push((name, scene, placed(&one, &poses), 150));
    }
    let two = vec![(DVec3::X * 0.5, 0.25), (DVec3::Y * -0.25, 0.125)];
    for (name, is_scaled) in [("groups", false), ("groups of many sizes", true)] {
        let poses = random.poses(600, 20.0, is_scaled);
        let mut scene = Scene::new();
        let group = Group::new().with_modifier(instances(&poses));
        let group = scene.push(group).expect("a group").node;
        for brush in [ball([0.5, 0.0, 0.0], 0.25), ball([0.0, -0.25, 0.0], 0.125)] {
            scene.push_into(group, brush).expect("a brush");
        }
        scenes.push((name, scene, placed(&two, &poses), 400));
    }
    let (inner, outer) = (random.poses(300, 4.0, true), random.poses(30, 30.0, true));
    let mut scene = Scene::new();
    let group = Group::new().with_modifier(instances(&outer));
    let group = scene.push(group).expect("a group").node;
    let brush = ball([0.5, 0.0, 0.0], 0.2).with_modifier(instances(&inner));
    scene.push_into(group, brush).expect("a brush");
    scenes.push((
        "copies of copies",
        scene,
        placed(&placed(&one, &inner), &outer),
        150,
    ));
    scenes
}

#[test]
fn a_distance_is_that_of_the_nearest_instance() {
    let mut random = Random(3);
    for (name, mut scene, spheres, _) in cases() {
        // With a blend, joints are not all hard unions.
        for is_blended in [false, true] {
            if is_blended {
                let far = ball([1e4, 0.0, 0.0], 1.0).smooth(0.1);
                scene.push(far).expect("a brush");
            }
            let program = Program::lower(&scene).expect("a program");
            assert_eq!(program.is_hard_union(), !is_blended, "{name}");
            let points: Vec<Vec3> = (0..256)
                .map(|_| {
                    Vec3::from(
                        [random.next(), random.next(), random.next()].map(|t| 24.0 * (t - 0.5)),
                    )
                })
                .collect();
            let along = |axis: usize| points.iter().map(|p| p[axis]).collect::<Vec<_>>();
            let mut found = vec![0.0; points.len()];
            Evaluator::new(&program).distances(&along(0), &along(1), &along(2), &mut found);
            for (point, d) in points.iter().zip(&found) {
                let distances = spheres
                    .iter()
                    .map(|(c, r)| c.distance(point.as_dvec3()) - r);
                let exact = distances.fold(f64::INFINITY, f64::min);
                assert!(
                    (exact - f64::from(*d)).abs() < 1e-4,
                    "{name} {point}: {d} for {exact}"
                );
            }
        }
    }
}

#[test]
fn pruned_instances_have_the_distances_of_all() {
    for (name, scene, _, _) in cases() {
        let program = Program::lower(&scene).expect("a program");
        let centers: Vec<Vec3> = (0..64u8)
            .map(|i| {
                4.0 * Vec3::new(f32::from(i & 3), f32::from(i >> 2 & 3), f32::from(i >> 4)) - 6.0
            })
            .collect();
        let mut pruner = Pruner::new(&program);
        pruner.classify_cells(program.instructions(), &centers, 1.8, &mut [0.0; 64]);
        let mut evaluator = Evaluator::new(&program);
        let mut longest = 0;
        for (cell, center) in centers.iter().enumerate() {
            let mut list = Vec::new();
            pruner.prune_into(program.instructions(), cell, &mut list);
            longest = longest.max(list.len());
            let along = |axis: usize| [-1.0, 0.1, 0.9].map(|by: f32| center[axis] + by);
            let [x, y, z] = [along(0), along(1), along(2)];
            let (mut whole, mut pruned) = ([0.0; 3], [0.0; 3]);
            evaluator.distances(&x, &y, &z, &mut whole);
            evaluator.distances_with(&list, &x, &y, &z, &mut pruned);
            assert_eq!(whole, pruned, "{name}, cell {cell}");
            // Nothing else is farther by more than the cell's size.
            let upper = whole[1] + 0.2 + 1.8;
            evaluator.distances_from(upper, &list, [&x, &y, &z], &mut pruned);
            let expected = whole.map(|d| d.min(upper));
            assert_eq!(expected, pruned, "{name}, cell {cell}");
        }
        let few = program.instructions().len() / 4;
        assert!(
            longest < few.max(100),
            "{name}: {longest} of {}",
            program.instructions().len()
        );
    }
}

#[test]
fn instances_take_little_memory() {
    for (name, scene, spheres, most) in cases() {
        let program = Program::lower(&scene).expect("a program");
        assert_eq!(program.brush_count(), spheres.len(), "{name}");
        if spheres.len() > 1000 {
            let each = program.memory_bytes() / spheres.len();
            assert!(each <= most, "{name}: {each} bytes");
        }
    }
}
