//! Volumes of files know distances beyond their band. The truth is the formula of what was written.

use argil::scene::{Brush, Scene, Shape};
use argil::{
    Engine, ExportOptions, RawLayout, VolumeReadOptions, World, read_volume, read_volume_bytes,
};
use glam::Vec3;

fn world(shape: Shape) -> World {
    let mut scene = Scene::new();
    scene.push(Brush::new(shape)).expect("a brush");
    Engine::cpu().build(&scene).expect("a world").field()
}

/// Returns the errors of a shape's distances in voxels, after a trip through a file: at places whose distance lies between two
/// numbers of voxels, sorted.
fn errors(
    shape: &Shape,
    file: &std::path::Path,
    resolution: u32,
    [from, to]: [f32; 2],
) -> Vec<f32> {
    let written = world(shape.clone());
    let options = ExportOptions {
        resolution,
        ..ExportOptions::default()
    };
    written.export(file, &options).expect("a file");
    let read = read_volume(file, &argil::VolumeReadOptions::default()).expect("a volume");
    let voxel = read.voxel_size;
    let copy = world(Shape::sampled("solid", read.grid));
    let mut errors = Vec::new();
    // A spiral over the directions, and lengths up to twice the size of a solid.
    for i in 0..4000u16 {
        let i = f32::from(i);
        let z = (i + 0.5) / 2000.0 - 1.0;
        let (sin, cos) = (2.399_963 * i).sin_cos();
        let way = Vec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + Vec3::Z * z;
        let p = way * (0.618_034 * i).fract() * 1.8;
        let right = written.distance(p.to_array());
        if (from..to).contains(&(right.abs() / voxel)) {
            errors.push((copy.distance(p.to_array()) - right).abs() / voxel);
        }
    }
    errors.sort_by(f32::total_cmp);
    errors
}

#[test]
fn volumes_know_distances_beyond_their_band() {
    let here = tempfile::tempdir().expect("a folder");
    // Exact inside and outside, with edges, corners and a hole.
    let shapes = [
        Shape::sphere(0.5),
        Shape::cuboid([0.5, 0.4, 0.3]),
        Shape::cylinder(0.3, 0.4),
        Shape::torus(0.4, 0.15),
    ];
    for (shape, ending) in shapes
        .iter()
        .flat_map(|shape| ["vdb", "nvdb"].map(|e| (shape, e)))
    {
        let file = here.path().join(format!("solid.{ending}"));
        for (range, most) in [([0.0, 10.0], [0.06, 0.4]), ([10.0, 1000.0], [0.2, 0.6])] {
            let sorted = errors(shape, &file, 64, range);
            let tenth = sorted[sorted.len() * 9 / 10];
            let last = sorted[sorted.len() - 1];
            assert!(
                tenth < most[0] && last < most[1],
                "{ending} {shape:?} {range:?}: {tenth} and {last} voxels"
            );
        }
        let mean = |resolution: u32| {
            let all = errors(shape, &file, resolution, [0.0, f32::MAX]);
            all.iter().sum::<f32>() / all.len() as f32 / resolution as f32
        };
        let [coarse, fine] = [32, 64].map(mean);
        assert!(fine < 0.7 * coarse, "{ending} {shape:?}: {coarse} {fine}");
    }
}

/// Values in another unit, and other functions with the same surface, are no distances until they are scaled.
#[test]
fn values_of_any_slope_become_distances() {
    const SIDE: u32 = 32;
    let voxel = 0.05;
    let layout = RawLayout {
        shape: Some([SIDE; 3]),
        voxel_size: Some(voxel),
        origin: Some([-0.5 * voxel * (SIDE - 1) as f32; 3]),
        ..RawLayout::default()
    };
    let options = VolumeReadOptions {
        raw: layout,
        ..VolumeReadOptions::default()
    };
    let position = |i: u32| {
        let place = Vec3::from([i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE].map(|c| c as f32));
        voxel * (place - 0.5 * (SIDE - 1) as f32)
    };
    /// A function, and whether its values are scaled.
    type Case = (fn(f32) -> f32, bool);
    let functions: [Case; 11] = [
        (|d| d, false),
        (|d| 1e-30 * d, true),
        (|d| 0.1 * d, true),
        (|d| 0.55 * d, true),
        (|d| 1.9 * d, true),
        (|d| 20.0 * d, true),
        (|d| 1e30 * d, true),
        // The square of the radius.
        (|d| 8.0 * ((d + 0.5) * (d + 0.5) - 0.25), true),
        // Clamped at one, one and a half and two voxels.
        (|d| d.clamp(-0.05, 0.05), false),
        (|d| d.clamp(-0.075, 0.075), false),
        (|d| d.clamp(-0.1, 0.1), false),
    ];
    for (index, (function, is_scaled)) in functions.iter().enumerate() {
        let values = (0..SIDE.pow(3)).map(|i| function(position(i).length() - 0.5));
        let bytes: Vec<u8> = values.flat_map(f32::to_le_bytes).collect();
        let read = read_volume_bytes(&bytes, "a.raw".as_ref(), &options).expect("a volume");
        assert_eq!(read.scale != 1.0, *is_scaled, "{index}: {}", read.scale);
        let copy = world(Shape::sampled("a", read.grid));
        for away in [0.2, 0.45, 0.5, 0.55, 0.6, 0.9, 1.4] {
            for way in [Vec3::X, Vec3::new(0.6, 0.7, 0.3), -Vec3::ONE] {
                let d = copy.distance((away * way.normalize()).to_array());
                assert!(
                    (d - (away - 0.5)).abs() < 0.3 * voxel,
                    "{index}: {d} at {away} along {way}"
                );
            }
        }
    }
}
