//! Tests the tree import: an imported scene has the distances that the format defines.

use argil_conformance::points;
use argil_field::Program;
use argil_scene::Scene;
use glam::{DVec2, DVec3, Vec3};
use serde_json::{Value, json};

/// A rotation about an axis, a scale and a translation, as the map from the parent's space to the node's.
fn matrix(degrees: f64, scale: f64, at: [f64; 3]) -> Value {
    let m = glam::DAffine3::from_scale_rotation_translation(
        DVec3::splat(scale),
        glam::DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), degrees.to_radians()),
        at.into(),
    )
    .inverse();
    let row = |i: usize| {
        [
            m.matrix3.x_axis[i],
            m.matrix3.y_axis[i],
            m.matrix3.z_axis[i],
            m.translation[i],
        ]
    };
    json!([row(0), row(1), row(2)].concat())
}

fn leaf(kind: &str, sizes: Value, place: Value) -> Value {
    let mut node = json!({ "nodeType": "primitive", "primitiveType": kind, "round_x": 0.05, "round_y": 0.1,
        "color": [0.5, 0.4, 0.3], "matrix": place });
    let fields = node.as_object_mut().expect("an object");
    fields.extend(sizes.as_object().expect("an object").clone());
    node
}

fn join(mode: &str, k: f64, left: Value, right: Value, place: Value) -> Value {
    json!({ "nodeType": "binaryOperator", "blendMode": mode, "blendRadius": k,
        "leftChild": left, "rightChild": right, "matrix": place })
}

fn tree() -> Value {
    let here = || matrix(0.0, 1.0, [0.0; 3]);
    let ball = leaf(
        "sphere",
        json!({ "radius": 0.5 }),
        matrix(0.0, 1.0, [0.1, 0.0, 0.0]),
    );
    let bar = leaf(
        "cylinder",
        json!({ "radius": 0.2, "height": 1.2 }),
        matrix(50.0, 1.0, [0.0, 0.2, 0.1]),
    );
    let cone = leaf(
        "cone",
        json!({ "radius": 0.3, "height": 0.7 }),
        matrix(-30.0, 0.8, [0.4, 0.1, 0.2]),
    );
    let sides = json!({ "sides": [0.9, 0.6, 0.8], "bevel": [0.3, 0.2, 0.25, 0.4] });
    let block = leaf("box", sides, matrix(25.0, 1.0, [-0.2, 0.0, 0.1]));
    let pair = join(
        "inter",
        0.1,
        block,
        ball.clone(),
        matrix(40.0, 1.3, [0.3, -0.1, 0.2]),
    );
    let left = join(
        "sub",
        0.07,
        join("union", 0.05, ball, bar, here()),
        cone,
        matrix(15.0, 1.0, [0.0, 0.1, 0.0]),
    );
    join("union", 0.12, left, pair, here())
}

/// Returns the distance by the format's definition.
fn distance(node: &Value, parent: DVec3) -> f64 {
    let number = |key: &str| node[key].as_f64().expect("a number");
    let numbers = |key: &str| -> Vec<f64> {
        node[key]
            .as_array()
            .expect("a list")
            .iter()
            .map(|v| v.as_f64().expect("a number"))
            .collect()
    };
    let m = numbers("matrix");
    let p = DVec3::from_array(
        [0, 4, 8].map(|r| m[r] * parent.x + m[r + 1] * parent.y + m[r + 2] * parent.z + m[r + 3]),
    );
    // Own distances are in the node's unit: its maps scale alike along all axes.
    let unit = (m[0] * m[0] + m[1] * m[1] + m[2] * m[2]).sqrt();
    let rect = |d: DVec2| d.max(DVec2::ZERO).length() + d.max_element().min(0.0);
    let q = DVec2::new(p.x.hypot(p.z), p.y);
    let in_meters = match node["primitiveType"].as_str() {
        Some("sphere") => p.length() - number("radius"),
        Some("cylinder") => rect(q.abs() - DVec2::new(number("radius"), 0.5 * number("height"))),
        Some("cone") => {
            // A triangle in the half plane; the point's distance to its sides, negative inside.
            let (r, h) = (number("radius"), 0.5 * number("height"));
            let segment = |a: DVec2, b: DVec2| {
                let t = ((q - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
                q.distance(a + (b - a) * t)
            };
            let (tip, rim) = (DVec2::new(0.0, h), DVec2::new(r, -h));
            let d = segment(tip, rim).min(segment(DVec2::new(0.0, -h), rim));
            let inside = q.y > -h && (q - rim).perp_dot(tip - rim) < 0.0;
            if inside { -d } else { d }
        }
        Some("box") => {
            let (half, bevel) = (numbers("sides"), numbers("bevel"));
            let corner = usize::from(p.x <= 0.0) * 2 + usize::from(p.z <= 0.0);
            let r = 0.5 * bevel[corner];
            let flat = rect(DVec2::new(
                p.x.abs() - 0.5 * half[0] + r,
                p.z.abs() - 0.5 * half[2] + r,
            )) - r;
            let rim = if p.y > 0.0 {
                number("round_x")
            } else {
                number("round_y")
            };
            rect(DVec2::new(flat + rim, p.y.abs() - 0.5 * half[1] + rim)) - rim
        }
        _ => {
            let (a, b, k) = (
                distance(&node["leftChild"], p),
                distance(&node["rightChild"], p),
                number("blendRadius"),
            );
            let g = |x: f64| (k - x).max(0.0).powi(2) / (4.0 * k);
            match node["blendMode"].as_str() {
                Some("union") => a.min(b) - g((a - b).abs()),
                Some("inter") => a.max(b) + g((a - b).abs()),
                _ => a.max(-b) + g((a + b).abs()),
            }
        }
    };
    in_meters / unit
}

#[test]
fn imported_distances_are_the_formats() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("tree.json");
    std::fs::write(&path, tree().to_string()).expect("a file");
    let program = Program::lower(&Scene::import_tree(&path).expect("a tree")).expect("a program");
    let mut inside = 0;
    for p in points(3000, 41) {
        let (found, expected) = (
            program.distance(p.into()),
            distance(&tree(), Vec3::from(p).as_dvec3()),
        );
        assert!(
            (f64::from(found) - expected).abs() < 1e-5 * (2.0 + expected.abs()),
            "{p:?}: {found}, not {expected}"
        );
        inside += usize::from(expected < 0.0);
    }
    assert!(inside > 50, "{inside}");
}

#[test]
fn wrong_trees_are_refused_with_their_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("tree.json");
    let refused = |change: &dyn Fn(&mut Value), message: &str| {
        let mut tree = tree();
        change(&mut tree);
        // Lines are counted below.
        tree.sort_all_objects();
        std::fs::write(&path, serde_json::to_string_pretty(&tree).expect("text")).expect("a file");
        let error = Scene::import_tree(&path).expect_err(message).to_string();
        assert!(error.contains(message), "{error} does not say {message}");
    };
    refused(
        &|t| t["leftChild"]["blendMode"] = json!("xor"),
        "/L: blendMode: \"xor\" is not union, sub or inter",
    );
    refused(
        &|t| t["rightChild"]["rightChild"]["radius"] = json!(-1),
        "/RR: shape.radius: -1 is not positive",
    );
    refused(
        &|t| t["rightChild"]["matrix"][0] = json!(9.0),
        "/R: matrix: does more than rotate",
    );
    refused(
        &|t| t["rightChild"]["matrix"] = json!([1, 2]),
        "/R: matrix: is not a list of 12 numbers",
    );
    refused(
        &|t| drop(t.as_object_mut().expect("an object").remove("rightChild")),
        "/: rightChild: is missing",
    );
    refused(
        &|t| t["leftChild"] = json!(7),
        "json:4:16: not a tree file: expected object, found number",
    );
}
