//! Volumes of files know distances beyond their band. The truth is the formula of what was written.

use argil::scene::{Brush, Scene, Shape};
use argil::{Engine, ExportOptions, World, read_volume};
use glam::Vec3;

fn world(shape: Shape) -> World {
    let mut scene = Scene::new();
    scene.push(Brush::new(shape)).expect("a brush");
    Engine::cpu().build(&scene).expect("a world").field()
}

#[test]
fn volumes_know_distances_beyond_their_band() {
    let here = tempfile::tempdir().expect("a folder");
    // Exact inside and outside.
    let shapes = [Shape::sphere(0.5), Shape::cuboid([0.5, 0.4, 0.3])];
    for (shape, ending) in shapes
        .iter()
        .flat_map(|shape| ["vdb", "nvdb"].map(|e| (shape, e)))
    {
        let written = world(shape.clone());
        let file = here.path().join(format!("solid.{ending}"));
        let options = ExportOptions {
            resolution: 48,
            ..ExportOptions::default()
        };
        written.export(&file, &options).expect("a file");
        let read = read_volume(&file, &argil::VolumeReadOptions::default()).expect("a volume");
        let voxel = read.voxel_size;
        let copy = world(Shape::sampled("solid", read.grid));
        let ways = [
            Vec3::X,
            Vec3::new(0.6, 0.7, 0.3),
            Vec3::new(-0.3, 0.2, 0.9),
            -Vec3::Y,
        ];
        for way in ways.map(Vec3::normalize) {
            for away in [0.0, 0.2, 0.45, 0.6, 0.9, 1.5, 2.3] {
                let p = away * way;
                let right = written.distance(p.to_array());
                let d = copy.distance(p.to_array());
                let most = 0.6 * voxel * (1.0 + right.abs());
                assert!(
                    (d - right).abs() < most,
                    "{ending} {shape:?}: {d} and {right} at {p}"
                );
            }
        }
    }
}
