//! Random scenes of the whole tables: distances against the oracle, their Lipschitz constant, and edits.

use crate::field::measure;
use argil_conformance::{RandomTables, random_session, rounding};
use argil_field::{FAR, Program, naive};
use argil_scene::{Extents, Scene};
use glam::Vec3;
use rayon::prelude::*;

/// Bounded: distances of any shape of the tables agree with the oracle within rounding.
#[test]
fn shapes_of_any_parameters_are_the_oracles() {
    let worst = (0..600u64).into_par_iter().filter_map(|seed| {
        let mut tables = RandomTables::new(seed);
        let mut scene = Scene::new();
        let shape = tables.shape();
        scene.push(shape.clone()).expect("a valid shape");
        let program = Program::lower(&scene).expect("a program");
        let points: Vec<[f32; 3]> = (0..48).map(|_| tables.point(1.2)).collect();
        let errors = points.iter().zip(measure(&program, &points)).map(|(p, d)| {
            let expected = naive::distance(&scene, Vec3::from(*p));
            (f64::from(d) - expected).abs() / f64::from(rounding(*p) * program.lipschitz())
        });
        let error = errors.fold(0.0, f64::max);
        (error > 1.0).then(|| format!("{seed}: {error} times the bound: {shape:?}"))
    });
    let worst: Vec<String> = worst.collect();
    assert!(worst.is_empty(), "{} fail: {worst:#?}", worst.len());
}

/// Conservative: distances change by at most the program's Lipschitz constant, wherever two points are, or jump where
/// the program says so.
#[test]
fn random_scenes_keep_their_lipschitz_constant() {
    let failures: Vec<String> = (0..2000u64)
        .into_par_iter()
        .filter_map(|seed| {
            let mut tables = RandomTables::new(seed);
            let nodes = 1 + tables.pick(6);
            let scene = tables.scene(nodes);
            let program = Program::lower(&scene).ok()?;
            let starts: Vec<[f32; 3]> = (0..128).map(|_| tables.point(1.5)).collect();
            let ends: Vec<[f32; 3]> = starts
                .iter()
                .map(|start| {
                    let reach = [0.003, 0.03, 0.3][tables.pick(3)];
                    (Vec3::from(*start) + Vec3::from(tables.point(reach))).to_array()
                })
                .collect();
            let (from, to) = (measure(&program, &starts), measure(&program, &ends));
            let mut worst = (0.0f32, String::new());
            for i in 0..starts.len() {
                let (a, b) = (Vec3::from(starts[i]), Vec3::from(ends[i]));
                let jump = program.jumps_near(argil_math::Aabb::around([a, b]), f32::MAX);
                let bound = program.lipschitz() * a.distance(b)
                    + jump.slack
                    + jump.hidden
                    + rounding(starts[i]) * program.lipschitz();
                let change = (from[i] - to[i]).abs();
                if from[i].max(to[i]) < 0.1 * FAR && change / bound > worst.0 {
                    worst = (change / bound, format!("{a} {} {b} {}", from[i], to[i]));
                }
            }
            (worst.0 > 1.0).then(|| {
                let json = scene.to_json();
                format!("{seed}: {} times the bound at {}: {json}", worst.0, worst.1)
            })
        })
        .collect();
    assert!(
        failures.is_empty(),
        "{} fail: {:#?}",
        failures.len(),
        &failures[..failures.len().min(8)]
    );
}

/// Conservative: the distance to the solid's box, divided by what its distances may fall short of, is a lower bound.
#[test]
fn boxes_of_random_scenes_bound_their_distances() {
    let failures: Vec<String> = (0..4000u64)
        .into_par_iter()
        .filter_map(|seed| {
            let mut tables = RandomTables::new(seed);
            let nodes = 1 + tables.pick(3);
            let scene = tables.scene(nodes);
            let program = Program::lower(&scene).ok()?;
            let extent = Extents::of(&scene).node_bounds(Scene::ROOT);
            if extent.aabb.is_empty() {
                return None;
            }
            let points: Vec<[f32; 3]> = (0..96)
                .map(|i| tables.point([1.5, 4.0, 40.0][i % 3]))
                .collect();
            points
                .iter()
                .zip(measure(&program, &points))
                .find_map(|(p, d)| {
                    let p = Vec3::from(*p);
                    let gap = (extent.aabb.min - p)
                        .max(p - extent.aabb.max)
                        .max(Vec3::ZERO);
                    let least = gap.length() / extent.lipschitz_inverse;
                    let is_short =
                        d < 0.9999 * least - rounding(p.to_array()) * program.lipschitz();
                    (gap != Vec3::ZERO && is_short).then(|| {
                        let json = scene.to_json();
                        format!("{seed}: {d} at {p}, at least {least}, {extent:?}: {json}")
                    })
                })
        })
        .collect();
    assert!(
        failures.is_empty(),
        "{} fail: {:#?}",
        failures.len(),
        &failures[..failures.len().min(6)]
    );
}

/// Exact: after any edit of any row, bricks equal a fresh bake. The example `random_edits` runs as many as one wants.
#[test]
fn random_edits_of_all_rows_equal_a_fresh_bake() {
    let sessions = (0..200)
        .into_par_iter()
        .map(|seed| random_session(seed, 20));
    let sessions: Vec<_> = sessions.collect();
    let failures: Vec<&String> = sessions.iter().filter_map(|s| s.as_ref().err()).collect();
    assert!(
        failures.is_empty(),
        "{} sessions fail, as {}",
        failures.len(),
        failures[0]
    );
}
