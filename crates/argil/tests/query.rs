//! Tests queries of the surface, in the field and in volumes, from many threads.

use argil::scene::{Brush, Scene, Shape};
use argil::{BoxPosition, BricksOptions, Engine, Query, World};
use std::sync::RwLock;

/// Returns a sphere with a cut, next to a box.
fn scene() -> Scene {
    let mut scene = Scene::new();
    scene.view.bounds = Some([[-1.0; 3], [1.0; 3]]);
    let brushes = [
        Brush::new(Shape::sphere(0.5)).at([-0.3, 0.0, 0.0]),
        Brush::new(Shape::sphere(0.3))
            .at([-0.3, 0.5, 0.0])
            .subtract(),
        Brush::new(Shape::cuboid([0.2, 0.3, 0.1]))
            .at([0.6, 0.0, 0.0])
            .smooth(0.05),
    ];
    for brush in brushes {
        scene.push(brush).expect("a valid brush");
    }
    scene
}

fn worlds() -> [World; 3] {
    let scene = scene();
    let build = || Engine::cpu().build(&scene).expect("a world");
    [
        build().field(),
        build().dense(128).expect("a world"),
        build().bricks(128).expect("a world"),
    ]
}

/// Runs a query on the field and both volumes, with the tolerance of each volume.
fn ask(check: impl Fn(&Query<'_>, f32)) {
    let [field, dense, bricks] = worlds();
    check(&field.query(), 1e-3);
    check(&dense.query_volume().expect("a volume"), 0.02);
    check(&bricks.query_volume().expect("a volume"), 0.02);
    assert!(field.query_volume().is_none());
}

/// Returns points on a spiral over the unit sphere.
fn directions(count: usize) -> impl Iterator<Item = [f32; 3]> {
    (0..count).map(move |i| {
        let y = 1.0 - 2.0 * (i as f32 + 0.5) / count as f32;
        let (r, turn) = ((1.0 - y * y).sqrt(), 2.399_963 * i as f32);
        [r * turn.cos(), y, r * turn.sin()]
    })
}

#[test]
fn distances_and_gradients_come_one_by_one_and_in_batches() {
    ask(|query, off| {
        let points: Vec<[f32; 3]> = directions(700).map(|p| p.map(|c| 0.55 * c)).collect();
        let (mut d, mut g) = (vec![0.0; 700], vec![(0.0, [0.0; 3]); 700]);
        query.distances(&points, &mut d);
        query.gradients(&points, &mut g);
        for ((p, d), (also, _)) in points.iter().zip(&d).zip(&g) {
            assert!((query.distance(*p) - d).abs() < 1e-6 && (d - also).abs() < 1e-6);
        }
        let (d, [x, y, z]) = query.gradient([-0.3, -0.51, 0.0]);
        assert!((d - 0.01).abs() < off && x.abs() < 0.05 && z.abs() < 0.05);
        assert!((y + 1.0).abs() < 0.05, "{y}");
    });
}

#[test]
fn rays_and_balls_meet_the_surface() {
    ask(|query, off| {
        let hit = query
            .cast_ray([-0.3, -2.0, 0.0], [0.0, 3.0, 0.0], 10.0)
            .expect("a hit");
        assert!((hit.distance - 1.5).abs() < off && (hit.point[1] + 0.5).abs() < off);
        assert!(hit.normal[1] < -0.99);
        // Through the bite, which is 0.2 deep.
        let hit = query
            .cast_ray([-0.3, 2.0, 0.0], [0.0, -1.0, 0.0], 10.0)
            .expect("a hit");
        assert!((hit.distance - 1.8).abs() < off, "{}", hit.distance);
        // From inside to where it leaves.
        let hit = query
            .cast_ray([-0.3, -0.2, 0.0], [0.0, -1.0, 0.0], 10.0)
            .expect("a hit");
        assert!((hit.distance - 0.3).abs() < off);
        // A ball of 0.2 stops so much before, and does not fit between the solids.
        let hit = query
            .cast_sphere([-0.3, -2.0, 0.0], [0.0, 1.0, 0.0], 0.2, 10.0)
            .expect("a hit");
        assert!((hit.distance - 1.3).abs() < off && (hit.point[1] + 0.5).abs() < off);
        assert!(
            query
                .cast_sphere([0.28, 0.0, -2.0], [0.0, 0.0, 1.0], 0.2, 10.0)
                .is_some()
        );
        assert!(
            query
                .cast_ray([0.28, 0.0, -2.0], [0.0, 0.0, 1.0], 10.0)
                .is_none()
        );
        let touching = query.cast_sphere([-0.3, -0.6, 0.0], [0.0, -1.0, 0.0], 0.2, 1.0);
        assert_eq!(touching.map(|hit| hit.distance), Some(0.0));
        // Too short, beside, and what makes no sense.
        assert!(
            query
                .cast_ray([-0.3, -2.0, 0.0], [0.0, 1.0, 0.0], 1.0)
                .is_none()
        );
        assert!(
            query
                .cast_ray([0.0, 3.0, 0.0], [1.0, 0.0, 0.0], 100.0)
                .is_none()
        );
        assert!(query.cast_ray([0.0; 3], [0.0; 3], 1.0).is_none());
        assert!(
            query
                .cast_ray([f32::NAN; 3], [1.0, 0.0, 0.0], 1.0)
                .is_none()
        );
        assert!(
            query
                .cast_sphere([0.0, 2.0, 0.0], [0.0, -1.0, 0.0], f32::NAN, 9.0)
                .is_none()
        );
        let origins: Vec<_> = directions(200).map(|p| p.map(|c| 3.0 * c)).collect();
        let inwards: Vec<_> = origins.iter().map(|p| p.map(|c| -c)).collect();
        let hits = query.cast_rays(&origins, &inwards, 9.0);
        for ((origin, inwards), hit) in origins.iter().zip(&inwards).zip(&hits) {
            assert_eq!(*hit, query.cast_ray(*origin, *inwards, 9.0));
        }
        assert!(hits.iter().flatten().count() > 100);
    });
}

#[test]
fn closest_points_are_the_closest() {
    ask(|query, off| {
        // In the bite's middle all of its surface is 0.3 away; the solid's edge around it is not nearer.
        for (p, expected) in [
            ([-0.3, 0.5, 0.0], 0.3),
            ([-0.3, -0.9, 0.0], 0.4),
            ([0.9, 0.0, 0.9], 0.8062),
            ([0.6, 0.0, 0.05], 0.05),
        ] {
            let found = query.closest_point(p, 5.0).expect("a point");
            // Where much of the surface is as near, no search ends.
            assert!(found.is_nearest || expected > 0.1, "{p:?}");
            let (way, found) = (found.distance, found.point);
            assert!(
                (way - expected).abs() < 0.012 * expected + off,
                "{p:?}: {way}"
            );
            assert!(query.distance(found).abs() < off);
            assert!(
                query.closest_point(p, 0.7 * expected - off).is_none(),
                "{p:?}"
            );
        }
        assert!(query.closest_point([f32::INFINITY; 3], 5.0).is_none());
        let points = [[0.0, 0.9, 0.0], [0.9, 0.9, 0.9]];
        let many = query.closest_points(&points, 5.0);
        assert!(many.iter().all(Option::is_some));
    });
}

#[test]
fn boxes_lie_outside_inside_or_across() {
    ask(|query, off| {
        let tolerance = 0.5 * off;
        let of = |center: [f32; 3], half: f32| {
            let (min, max) = (center.map(|c| c - half), center.map(|c| c + half));
            query.classify_box(min, max, tolerance)
        };
        assert_eq!(of([-0.3, 0.5, 0.0], 0.1), BoxPosition::Outside);
        assert_eq!(of([-0.3, -0.1, 0.0], 0.1), BoxPosition::Inside);
        assert_eq!(of([-0.3, -0.5, 0.0], 0.1), BoxPosition::Intersecting);
        assert_eq!(of([0.0, 0.0, 0.0], 0.9), BoxPosition::Intersecting);
        // A sliver in a large box.
        assert_eq!(
            query.classify_box([0.5, -2.0, -2.0], [0.9, 2.0, 2.0], tolerance),
            BoxPosition::Intersecting
        );
        assert_eq!(
            query.classify_box([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], tolerance),
            BoxPosition::Outside
        );
    });
}

/// Many threads query while edits run: each answer belongs to the scene before an edit or after it.
#[test]
fn threads_ask_while_edits_go_on() {
    let mut scene = scene();
    let options = BricksOptions {
        resolution: 96,
        ..Default::default()
    };
    let world = Engine::cpu().build(&scene).and_then(|w| w.bricks(options));
    let world = RwLock::new(world.expect("a world"));
    let done = std::sync::atomic::AtomicBool::new(false);
    let asked = std::thread::scope(|threads| {
        let askers: Vec<_> = (0..3)
            .map(|_| {
                threads.spawn(|| {
                    let mut answers = [0u32; 2];
                    while !done.load(std::sync::atomic::Ordering::Relaxed) {
                        let world = world.read().expect("a lock");
                        let way = |query: Query<'_>| {
                            let hit = query.cast_ray([-0.3, 0.0, 2.0], [0.0, 0.0, -1.0], 9.0);
                            hit.map_or(f32::NAN, |hit| hit.distance)
                        };
                        let volume = world.query_volume().expect("a volume");
                        let (a, b) = (way(world.query()), way(volume));
                        assert!((a - b).abs() < 0.02, "{a} {b}");
                        let before = (a - 1.5).abs() < 0.02;
                        let after = (a - 1.7).abs() < 0.02;
                        assert!(before || after, "{a}");
                        answers[usize::from(after)] += 1;
                    }
                    answers
                })
            })
            .collect();
        for index in 0..60 {
            if index % 2 == 0 {
                let bite = Brush::new(Shape::sphere(0.2))
                    .at([-0.3, 0.0, 0.5])
                    .subtract();
                scene.push(bite).expect("a valid brush");
            } else {
                scene.undo();
            }
            let applied = world
                .write()
                .expect("a lock")
                .apply(&scene)
                .expect("an edit");
            assert!(!applied.rebuilt);
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        done.store(true, std::sync::atomic::Ordering::Relaxed);
        askers
            .into_iter()
            .map(|t| t.join().expect("answers"))
            .fold([0; 2], |all, counts| {
                [all[0] + counts[0], all[1] + counts[1]]
            })
    });
    assert!(asked[0] > 10 && asked[1] > 10, "{asked:?}");
}

/// A near surface is found for any maximum distance. An invalid box contains nothing, and the query ends.
#[test]
fn near_surfaces_are_found_within_far_limits() {
    let mut scene = Scene::new();
    for i in 0..300u32 {
        let along = |k: u32| 4.0 * ((i * k) % 97) as f32 / 97.0 - 2.0;
        let brush = match i % 2 {
            0 => Brush::new(Shape::sphere(0.15)),
            _ => Brush::new(Shape::cuboid([0.1, 0.15, 0.1])).smooth(0.03),
        };
        scene
            .push(brush.at([along(13), along(31), along(57)]))
            .expect("a brush");
    }
    let world = Engine::cpu()
        .build(&scene)
        .and_then(|world| world.bricks(128));
    let world = world.expect("a world");
    for query in [world.query(), world.query_volume().expect("bricks")] {
        for i in 0..60u32 {
            let along = |k: u32| 4.0 * ((i * k) % 89) as f32 / 89.0 - 2.0;
            let p = [along(29), along(47), along(71)];
            let found = query.closest_point_among(p, 5.0, 4_096);
            let found = found.unwrap_or_else(|| panic!("{p:?}"));
            let d = world.distance(p).abs();
            assert!(found.distance >= 0.9 * d - 0.03, "{p:?}: {found:?}, {d}");
            let told = world.distance(found.point);
            assert!(told.abs() < 0.03, "{p:?}: {found:?}, {told}");
        }
        let nan = query.classify_box([f32::NAN; 3], [1.0; 3], 0.1);
        assert_eq!(nan, argil::BoxPosition::Outside);
        assert_eq!(
            query.classify_box([-1e30; 3], [1e30; 3], 1e-3),
            argil::BoxPosition::Intersecting
        );
    }
}
