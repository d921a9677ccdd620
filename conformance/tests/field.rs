//! Tests the field: the batched CPU evaluator against the oracle, and the GPU's interpreter against the CPU.

use argil_conformance::Wait;
use argil_conformance::{CaseRng, SceneCase, all_cases, gpu, gpu_field, points, poison, rounding};
use argil_field::{Evaluator, FAR, LANES, NearEvaluator, NearField, Program, naive};
use argil_math::Aabb;
use argil_scene::{Brush, Exactness, Group, Modifier, Path2, Scene, Shape};
use glam::{DVec3, Vec3};

/// Evaluates a program in batches on the CPU.
pub(crate) fn measure(program: &Program, points: &[[f32; 3]]) -> Vec<f32> {
    let mut evaluator = Evaluator::new(program);
    let mut out = vec![0.0; points.len()];
    for (points, out) in points.chunks(LANES).zip(out.chunks_mut(LANES)) {
        let axis = |k: usize| points.iter().map(|p| p[k]).collect::<Vec<f32>>();
        evaluator.distances(&axis(0), &axis(1), &axis(2), out);
    }
    out
}

fn lower(case: &SceneCase) -> Program {
    Program::lower(&case.scene).unwrap_or_else(|e| panic!("{}: {e}", case.name))
}

/// `cargo xtask test` runs this before all other tests.
#[test]
fn a_gpu_is_there() {
    gpu();
}

/// Bounded: distances agree within rounding. Searches along curves add the error of the last Newton step.
#[test]
fn cpu_distances_are_the_oracles() {
    let mut worst: (f64, String) = (0.0, String::new());
    for case in all_cases() {
        let program = lower(&case);
        let points = points(600, 1);
        for (p, d) in points.iter().zip(measure(&program, &points)) {
            let expected = naive::distance(&case.scene, Vec3::from(*p));
            let error =
                (f64::from(d) - expected).abs() / f64::from(rounding(*p) * program.lipschitz());
            // FAR stands for nothing: all that counts is that nothing is near.
            let both_far = d > 0.1 * FAR && expected > 0.1 * f64::from(FAR);
            if error > worst.0 && !both_far {
                worst = (
                    error,
                    format!("{} at {p:?}: {d}, the oracle says {expected}", case.name),
                );
            }
        }
    }
    assert!(worst.0 <= 1.0, "{} times the bound: {}", worst.0, worst.1);
}

/// Overlapping copies are in the correct places, for any number. With an even number around an axis, one is at the
/// front.
#[test]
fn few_copies_are_where_the_oracle_has_them() {
    let mut scenes = Vec::new();
    for count in 1..=9 {
        for shape in [
            r#"{"type":"box","half_size":[0.5,0.1,0.1]}"#,
            r#"{"type":"ellipsoid","radii":[0.3,0.1,0.2]}"#,
        ] {
            let around = format!(r#"{{"type":"radial_repeat","count":{count}}}"#);
            let along =
                format!(r#"{{"type":"repeat","spacing":[0.15,0.2,0],"count":[{count},2,1]}}"#);
            for modifier in [around, along] {
                scenes.push(format!(
                    r#"{{"argil":1,"brushes":[{{"shape":{shape},"modifiers":[
                        {{"type":"rotate","degrees":20,"axis":[0,1,0]}},{modifier}]}}]}}"#
                ));
            }
        }
    }
    for text in scenes {
        let scene = Scene::from_json(&text, "copies").unwrap_or_else(|e| panic!("{text}: {e}"));
        let program = Program::lower(&scene).expect("a program");
        let points = points(200, 3);
        for (p, d) in points.iter().zip(measure(&program, &points)) {
            let expected = naive::distance(&scene, Vec3::from(*p));
            let error = (f64::from(d) - expected).abs();
            assert!(
                error <= f64::from(rounding(*p)),
                "{text} at {p:?}: {d}, the oracle says {expected}"
            );
        }
    }
}

/// Negative control: the next case in the list is another field.
#[test]
fn cpu_distances_are_not_another_fields() {
    let cases = all_cases();
    let mut told_apart = 0;
    for pair in cases.windows(2) {
        let program = lower(&pair[0]);
        let points = points(100, 2);
        let differs = points.iter().zip(measure(&program, &points)).any(|(p, d)| {
            (f64::from(d) - naive::distance(&pair[1].scene, Vec3::from(*p))).abs()
                > 2.0 * f64::from(rounding(*p))
        });
        told_apart += usize::from(differs);
    }
    // Nothing, a cut of nothing and a hidden ball are the same field, so are a hard joint of a paint and its chamfer.
    assert!(
        told_apart + 8 >= cases.len(),
        "{told_apart} of {}",
        cases.len()
    );
}

#[test]
fn points_outside_of_the_world_are_far_from_everything() {
    for case in all_cases() {
        let program = lower(&case);
        assert!(
            measure(&program, &poison()).iter().all(|&d| d == FAR),
            "{}",
            case.name
        );
    }
}

#[test]
fn a_batch_of_any_length_gives_the_same_bits() {
    for case in all_cases() {
        let program = lower(&case);
        let points = points(LANES - 1, 3);
        let together = measure(&program, &points);
        for i in [0, 1, 17, LANES - 2] {
            assert_eq!(
                measure(&program, &points[i..=i])[0].to_bits(),
                together[i].to_bits(),
                "{}",
                case.name
            );
        }
    }
}

/// Bounded: the GPU's distances and materials agree within rounding. On Mesa's lavapipe they are bit-equal.
#[test]
fn gpu_distances_and_materials_are_the_cpus() {
    let mut field = gpu_field();
    let mut previous: Option<Vec<f32>> = None;
    let mut told_apart = 0;
    let cases = all_cases();
    for case in &cases {
        let program = lower(case);
        field
            .update(&program)
            .expect("a field that runs every case");
        let mut points = points(60, 4);
        points.extend(poison());
        let answers = field.evaluate(&points).wait().expect("answers");
        let expected = measure(&program, &points);
        for ((p, answer), &d) in points.iter().zip(&answers).zip(&expected) {
            let found = answer.distance[0];
            // A point that is not in the world has no length; nothing is rounded there.
            let bound = if Vec3::from(*p).length() < 1e7 {
                rounding(*p) * program.lipschitz()
            } else {
                0.0
            };
            let both_far = found > 0.1 * FAR && d > 0.1 * FAR;
            assert!(
                both_far || (found - d).abs() <= bound,
                "{} at {p:?}: gpu {found}, cpu {d}",
                case.name
            );
        }

        // Materials, where there is something to have one.
        let mut words = vec![argil_abi::GpuMaterial::default(); points.len()];
        let mut d = vec![0.0; points.len()];
        let mut evaluator = Evaluator::new(&program);
        let axis = |k: usize| points.iter().map(|p| p[k]).collect::<Vec<f32>>();
        evaluator.materials(&axis(0), &axis(1), &axis(2), &mut d, &mut words);
        for (i, (answer, words)) in answers.iter().zip(&words).enumerate() {
            if expected[i].abs() < 0.1 * FAR {
                let found = [answer.base_roughness, answer.emission_metallic];
                let expected = [words.base_roughness, words.emission_metallic];
                let gap = found
                    .iter()
                    .flatten()
                    .zip(expected.iter().flatten())
                    .map(|(a, b)| (a - b).abs());
                // A weight is a difference of distances over 2 k, and k is 0.05 or more.
                assert!(
                    gap.fold(0.0, f32::max) <= 20.0 * rounding([1.0; 3]),
                    "{} at {:?}",
                    case.name,
                    points[i]
                );
            }
        }

        // Negative control: the answers are not those of the case before.
        let found: Vec<f32> = answers.iter().map(|a| a.distance[0]).collect();
        told_apart += usize::from(previous.is_some_and(|p| p != found));
        previous = Some(found);
    }
    assert!(
        told_apart + 8 >= cases.len(),
        "{told_apart} of {}",
        cases.len()
    );
}

/// Returns the oracle's gradient where forward and backward differences agree.
fn oracle_gradient(scene: &Scene, p: Vec3) -> Option<DVec3> {
    let over = |ahead: f32, behind: f32| {
        let axis = |a: Vec3| {
            let (high, low) = (p + a * ahead, p - a * behind);
            let width = f64::from((high - low).dot(a));
            (naive::distance(scene, high) - naive::distance(scene, low)) / width
        };
        DVec3::new(axis(Vec3::X), axis(Vec3::Y), axis(Vec3::Z))
    };
    let (ahead, behind, both) = (over(1e-3, 0.0), over(0.0, 1e-3), over(1e-3, 1e-3));
    (ahead.abs_diff_eq(behind, 5e-3) && both.is_finite()).then_some(both)
}

#[test]
fn gradients_are_the_oracles() {
    for case in all_cases() {
        let program = lower(&case);
        let mut compared = 0;
        for p in points(60, 5).into_iter().take(60).map(Vec3::from) {
            let Some(expected) = oracle_gradient(&case.scene, p) else {
                continue;
            };
            let (d, gradient) = program.gradient(p);
            assert_eq!(
                d.to_bits(),
                program.distance(p).to_bits(),
                "{} at {p}",
                case.name
            );
            let error = (gradient.as_dvec3() - expected).length();
            assert!(
                error < 2e-2,
                "{} at {p}: {gradient}, the oracle says {expected}",
                case.name
            );
            compared += 1;
        }
        assert!(
            compared >= 20,
            "{}: {compared} points have a gradient",
            case.name
        );
    }
}

/// An exact distance has a gradient of length 1, which leads to the surface in one step.
#[test]
fn exact_shapes_are_exact() {
    let mut inexact = 0;
    for (name, shape) in argil_conformance::shapes() {
        let mut scene = Scene::new();
        scene
            .push(argil_scene::Brush::new(shape.clone()))
            .expect("a valid shape");
        let mut worst = 0.0f64;
        for p in points(120, 6).into_iter().map(Vec3::from) {
            let Some(gradient) = oracle_gradient(&scene, p) else {
                continue;
            };
            let d = naive::distance(&scene, p);
            let foot = p.as_dvec3() - gradient * d;
            let step = naive::distance(&scene, foot.as_vec3()).abs();
            worst = worst.max((gradient.length() - 1.0).abs()).max(step);
        }
        if shape.exactness() == Exactness::Exact {
            assert!(worst < 2e-2, "{name}: {worst}");
        } else {
            inexact += usize::from(worst > 2e-2);
        }
    }
    // Negative control: the ellipsoid's bound is told from a distance.
    assert!(inexact >= 1);
}

/// Returns many pieces of all kinds: in nested groups, blended, chamfered, subtracted and intersected.
fn many_pieces() -> Scene {
    let mut numbers = CaseRng::new(23);
    let mut scene = Scene::new();
    let ground = Brush::new(Shape::cuboid([1.1, 0.05, 1.1])).at([0.0, -0.9, 0.0]);
    scene.push(ground).expect("a brush");
    let outer = Group::new().rotated([0.0, 1.0, 0.0], 20.0).smooth(0.03);
    let outer = scene.push(outer).expect("a group").node;
    let inner = Group::new().scaled(0.5).at([0.2, 0.1, 0.0]).smooth(0.02);
    let inner = scene.push_into(outer, inner).expect("a group").node;
    let less = Group::new().subtract().smooth(0.02);
    let less = scene.push(less).expect("a group").node;
    for i in 0..1500 {
        let at = numbers.point(1.0).to_array();
        let size = numbers.between(0.01, 0.06);
        let shape = match i % 3 {
            0 => Shape::cuboid([size; 3]),
            1 => Shape::torus(size, 0.3 * size),
            _ => Shape::sphere(size),
        };
        let mut solid = Brush::new(shape);
        if i % 7 == 0 {
            solid = solid.with_modifier(Modifier::Twist {
                degrees_per_unit: 90.0,
            });
        }
        if i % 5 == 0 {
            solid = solid.smooth(0.02);
        }
        if i % 31 == 0 {
            solid = solid.chamfer(0.02);
        }
        let group = match i % 4 {
            0 if i % 31 != 0 => outer,
            1 if i % 31 != 0 => inner,
            2 if i % 31 != 0 => less,
            _ => Scene::ROOT,
        };
        scene.push_into(group, solid.at(at)).expect("a brush");
    }
    let cut = Brush::new(Shape::sphere(1.2)).intersect();
    scene.push(cut).expect("a brush");
    scene
}

/// Distances and materials from nearby pieces are bit-equal to the whole program below the far length, at any
/// point.
#[test]
fn nearby_pieces_give_the_whole_field() {
    let scene = many_pieces();
    let program = Program::lower(&scene).expect("a program");
    assert!(
        program.operand_count() > 1400,
        "{}",
        program.operand_count()
    );
    let around = Aabb::centered(Vec3::splat(1.2));
    let near = NearField::new(&program, around, 0.25).expect("it is of many pieces");
    assert!(near.far_length() >= 0.25);
    let mut evaluator = NearEvaluator::new(&near);
    let mut numbers = CaseRng::new(29);
    let count = 20_000;
    let points: Vec<Vec3> = (0..count).map(|_| numbers.point(1.3)).collect();
    let axis = |k: usize| points.iter().map(|p| p[k]).collect::<Vec<f32>>();
    let [x, y, z] = [axis(0), axis(1), axis(2)];
    let mut found = vec![0.0; count];
    evaluator.distances([&x, &y, &z], &mut found);
    let told: Vec<[f32; 3]> = points.iter().map(|p| p.to_array()).collect();
    let whole = measure(&program, &told);
    let (mut below, mut beyond) = (0, 0);
    for ((p, found), whole) in points.iter().zip(&found).zip(&whole) {
        let is_in = around.contains(*p);
        if is_in && *whole >= near.far_length() {
            assert_eq!(*found, near.far_length(), "at {p}: {whole}");
            beyond += 1;
        } else {
            assert_eq!(found.to_bits(), whole.to_bits(), "at {p}: {found}, {whole}");
            below += 1;
        }
    }
    assert!(below > 10_000 && beyond > 20, "{below}, {beyond}");
    // The truth, by another evaluator of another arithmetic.
    for (p, found) in told
        .iter()
        .zip(&found)
        .take(200)
        .filter(|(_, d)| **d < 0.25)
    {
        let exact = naive::distance(&scene, Vec3::from(*p));
        let off = (f64::from(*found) - exact).abs();
        let most = f64::from(rounding(*p) * program.lipschitz());
        assert!(off < most, "at {p:?}: {found}, {exact}");
    }
}

/// A ray at the height where a curve begins level meets it as often as the rule of its ends says.
#[test]
fn points_at_the_height_of_a_level_start_are_outside() {
    let outline = Path2::new([0.5, 0.0])
        .curve([0.5, -0.5], [0.0, -0.5])
        .curve([-0.5, -0.5], [-0.5, 0.0])
        .curve([-0.5, 0.5], [0.0, 0.5])
        .curve([0.5, 0.5], [0.5, 0.0]);
    let mut scene = Scene::new();
    let half_depth = 0.2;
    let shape = Shape::Extrusion {
        outline,
        half_depth,
    };
    scene.push(shape).expect("a valid shape");
    let program = Program::lower(&scene).expect("a program");
    let points = [[-0.8, -0.5, 0.0], [-0.8, 0.5, 0.0], [-0.8, 0.0, 0.0]];
    for (point, d) in points.iter().zip(measure(&program, &points)) {
        assert!(d > 0.2, "{point:?}: {d}");
    }
}
