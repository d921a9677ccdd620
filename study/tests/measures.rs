//! Compares measures of depths, stored distances and surfaces with NumPy, SciPy and trimesh, on output of Argil for
//! the teapot. `data/reference.py` and `examples/metrics_data.rs` describe how.

use argil::glam::Vec3;
use argil::mesh::{MeshSdf, read as read_mesh};
use argil_metrics::surface::{SurfaceDistance, sample_surface};
use argil_metrics::{ErrorStats, depth};
use serde_json::Value;
use std::path::PathBuf;

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(name)
}

fn numbers(name: &str) -> Vec<f32> {
    let bytes = std::fs::read(data(&format!("{name}.f32"))).expect("numbers");
    let (numbers, rest) = bytes.as_chunks();
    assert!(rest.is_empty() && !numbers.is_empty());
    numbers.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

fn reference() -> Value {
    let text = std::fs::read_to_string(data("reference.json")).expect("numbers");
    serde_json::from_str(&text).expect("JSON")
}

fn is_near(found: f64, expected: &Value, part: f64) {
    let expected = expected.as_f64().expect("a number");
    assert!(
        (found - expected).abs() <= part * expected,
        "{found} for {expected}"
    );
}

fn is_same(found: &ErrorStats, expected: &Value) {
    assert_eq!(expected["count"], found.count);
    is_near(found.mean, &expected["mean"], 1e-9);
    is_near(found.rms, &expected["rms"], 1e-9);
    is_near(found.max, &expected["max"], 1e-9);
}

#[test]
fn depths_and_silhouettes_agree() {
    let found = depth::compare(&numbers("exact-lengths"), &numbers("mesh-lengths"));
    let expected = &reference()["depths"];
    is_same(&found.both, &expected["both"]);
    assert_eq!(expected["missed"], found.missed);
    assert_eq!(expected["added"], found.added);
    assert!(found.missed > 0 && found.added > 0);
}

#[test]
fn errors_of_stored_distances_agree() {
    let expected = &reference()["stored"];
    let band = expected["band"].as_f64().expect("a number") as f32;
    let (stored, exact) = (numbers("stored-distances"), numbers("exact-distances"));
    is_same(&ErrorStats::within_band(&stored, &exact, band), expected);
}

/// The references use other sample points: two million nearest points in place of triangles.
#[test]
fn distances_between_surfaces_agree() {
    let surfaces = [24, 32].map(|n| {
        let mesh = read_mesh(&data(&format!("teapot-{n}.ply")))
            .expect("a mesh")
            .mesh;
        let corners: Vec<[Vec3; 3]> = (0..mesh.triangles.len())
            .map(|i| mesh.triangle_vertices(i))
            .collect();
        let mut points = sample_surface(&corners, 20_000);
        points.extend(corners.iter().flatten());
        let solid = MeshSdf::new(&mesh).expect("triangles");
        (points, move |p: Vec3| solid.distance(p))
    });
    let [(a, to_a), (b, to_b)] = &surfaces;
    let apart = SurfaceDistance::of((a, to_a), (b, to_b));
    let expected = &reference()["apart"];
    is_near(apart.hausdorff(), &expected["hausdorff"], 0.01);
    let [(a, to_a), (b, to_b)] = [(&a[..20_000], to_a), (&b[..20_000], to_b)];
    let apart = SurfaceDistance::of((a, to_a), (b, to_b));
    is_near(apart.chamfer(), &expected["chamfer"], 0.03);
}
