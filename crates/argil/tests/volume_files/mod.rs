//! Volumes for and of other programs.

mod refusals;

use argil::prelude::*;
use argil::vdb::vdb::VdbFile;
use argil::vdb::{AnyGrid, GridClass, nvdb};
use argil::{
    ExportClass, ExportCodec, ExportFormat, ExportOptions, RawLayout, VolumeReadOptions,
    read_volume,
};
use std::path::Path;

/// A box with a hole, and a sphere that is blended with it.
fn solid() -> Scene {
    let mut scene = Scene::new();
    let red = Material::colored([0.8, 0.1, 0.1]);
    scene.set_material("red", red).expect("a material");
    let mut push = |brush: Brush| {
        scene.push(brush).expect("a brush");
    };
    push(Brush::new(Shape::cuboid([0.5, 0.4, 0.3])).with_material("red"));
    push(
        Brush::new(Shape::sphere(0.3))
            .at([0.5, 0.2, 0.1])
            .smooth(0.1),
    );
    push(Brush::new(Shape::cylinder(0.15, 1.0)).subtract());
    scene
}

fn world(scene: &Scene) -> World {
    Engine::cpu().build(scene).expect("a world").field()
}

fn options() -> ExportOptions {
    ExportOptions {
        resolution: 64,
        ..ExportOptions::default()
    }
}

fn read(path: &Path) -> Vec<AnyGrid> {
    let bytes = std::fs::read(path).expect("a file");
    let file = VdbFile::parse(&bytes).expect("a .vdb file");
    (0..file.grids.len())
        .map(|i| file.grid(i).expect("a grid"))
        .collect()
}

/// Returns the indices of a box around the scene, every other of each axis.
fn indices() -> impl Iterator<Item = [i32; 3]> {
    let along = || (-50..50).step_by(2);
    along().flat_map(move |x| along().flat_map(move |y| along().map(move |z| [x, y, z + 1])))
}

/// Independent: the field itself, point by point, without pruned programs and leaves.
#[test]
fn a_level_set_has_the_fields_distances() {
    let folder = tempfile::tempdir().expect("a folder");
    let world = world(&solid());
    for band in [3.0, 7.5] {
        let path = folder.path().join("a.vdb");
        let how = ExportOptions {
            half_width_voxels: band,
            keep_bounds: true,
            ..options()
        };
        let report = world.export(&path, &how).expect("a file");
        let grids = read(&path);
        let grid = grids[0].as_float().expect("floats");
        assert_eq!(grids.len(), 1);
        assert_eq!(
            (grid.header.name.as_str(), grid.header.class),
            ("surface", GridClass::LevelSet)
        );
        let voxel = report.voxel_size;
        let width = grid.tree.background;
        assert!(
            (width - band * voxel).abs() <= 1e-6 * width
                && f64::from(width) >= f64::from(band) * f64::from(voxel)
        );
        assert_eq!(
            grid.header.transform.uniform_voxel_size(),
            Some(f64::from(voxel))
        );
        let mut active = 0;
        for index in indices() {
            let exact = world.distance(index.map(|c| voxel * c as f32));
            let (value, is_active) = grid.tree.value_and_state(index);
            assert_eq!(
                is_active,
                exact.abs() < width,
                "{index:?}: {value} for {exact}"
            );
            active += u32::from(is_active);
            let expected = if is_active {
                exact
            } else {
                width.copysign(exact)
            };
            assert_eq!(value, expected, "{index:?}");
        }
        assert!(active > 2000, "{active}");
        assert_eq!(report.voxels, grid.tree.active_voxels());
    }
}

/// Independent: distances to a fine mesh. In the blend, the field's values are too short.
#[test]
fn bounds_become_distances() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut scene = Scene::new();
    for x in [-0.3, 0.3] {
        let brush = Brush::new(Shape::sphere(0.4)).at([x, 0.0, 0.0]);
        scene.push(brush.smooth(0.3)).expect("a brush");
    }
    let world = world(&scene);
    let mesh = world.mesh(&MeshOptions::default()).expect("a mesh").mesh;
    let solid = argil::mesh::MeshSdf::new(&mesh).expect("a solid");
    let errors = |keep_bounds: bool| {
        let how = ExportOptions {
            keep_bounds,
            ..options()
        };
        let path = folder.path().join("a.vdb");
        let voxel = world.export(&path, &how).expect("a file").voxel_size;
        let grids = read(&path);
        let mut errors = Vec::new();
        for leaf in grids[0].as_float().expect("floats").tree.leaves() {
            for place in leaf.active.places() {
                let inner = [place / 64, place / 8 % 8, place % 8];
                let point =
                    [0, 1, 2].map(|axis| voxel * (leaf.origin[axis] + inner[axis] as i32) as f32);
                errors.push((leaf.values[place] - solid.distance(point.into())).abs() / voxel);
            }
        }
        errors.sort_by(f32::total_cmp);
        (errors[errors.len() * 99 / 100], errors[errors.len() - 1])
    };
    let (kept, corrected) = (errors(true), errors(false));
    println!("voxels, 99 of 100 and at most: {kept:?} kept, {corrected:?} corrected");
    assert!(corrected.0 < 0.15 && corrected.1 < 0.5, "{corrected:?}");
    assert!(kept.0 > 3.0 * corrected.0, "{kept:?}, {corrected:?}");
}

#[test]
fn densities_end_at_the_surface() {
    let folder = tempfile::tempdir().expect("a folder");
    let world = world(&solid());
    let path = folder.path().join("a.vdb");
    let how = ExportOptions {
        class: ExportClass::Fog,
        keep_bounds: true,
        ..options()
    };
    let voxel = world.export(&path, &how).expect("a file").voxel_size;
    let grids = read(&path);
    let grid = grids[0].as_float().expect("floats");
    assert_eq!(
        (grid.header.name.as_str(), grid.header.class),
        ("density", GridClass::FogVolume)
    );
    let mut inside = 0;
    for index in indices() {
        let exact = world.distance(index.map(|c| voxel * c as f32));
        let (value, is_active) = grid.tree.value_and_state(index);
        let expected = (-exact / (3.0 * voxel)).clamp(0.0, 1.0);
        assert!(
            (value - expected).abs() < 1e-6,
            "{index:?}: {value} for {expected}"
        );
        assert_eq!(is_active, exact < 0.0, "{index:?}");
        inside += u32::from(value == 1.0);
    }
    assert!(inside > 200, "{inside}");
}

#[test]
fn colors_are_a_second_grid() {
    let folder = tempfile::tempdir().expect("a folder");
    let world = world(&solid());
    let path = folder.path().join("a.vdb");
    let how = ExportOptions {
        colors: true,
        codec: ExportCodec::Blosc,
        ..options()
    };
    let voxel = world.export(&path, &how).expect("a file").voxel_size;
    let grids = read(&path);
    let AnyGrid::Vec3(colors) = &grids[1] else {
        panic!("vectors");
    };
    assert_eq!(colors.header.name, "Cd");
    let surface = grids[0].as_float().expect("floats");
    let pairs = surface.tree.leaves().zip(colors.tree.leaves());
    assert!(surface.tree.leaves().count() > 10);
    for (a, b) in pairs {
        assert_eq!((a.origin, &a.active), (b.origin, &b.active));
    }
    // A side of the box is red.
    let [r, g, b] = colors
        .tree
        .value([-0.5, 0.2, 0.0].map(|c| (c / voxel) as i32));
    assert!(r > 0.5 && g < 0.11 && b < 0.11, "{r} {g} {b}");
}

/// What comes back is the same within two voxels, but for the rounding of positions, and its sign elsewhere.
#[test]
fn a_level_set_comes_back_as_a_shape() {
    let folder = tempfile::tempdir().expect("a folder");
    let original = world(&solid());
    for (name, bits) in [("a.vdb", 32), ("b.nvdb", 32), ("c.vdb", 16), ("d.nvdb", 8)] {
        let path = folder.path().join(name);
        let how = ExportOptions {
            bits,
            keep_bounds: true,
            ..options()
        };
        let voxel = original.export(&path, &how).expect("a file").voxel_size;
        let back = read_volume(&path, &VolumeReadOptions::default()).expect("a volume");
        assert!(!back.is_fog && back.name == "surface" && back.voxel_size == voxel);
        assert!(back.grid.lipschitz() < 4.0, "{}", back.grid.lipschitz());
        let mut scene = Scene::new();
        scene
            .push(Shape::sampled("back", back.grid))
            .expect("a brush");
        let copy = world(&scene);
        // A step of 16-bit floats, or of 8 bits between six voxels.
        let most = match bits {
            32 => 1e-4,
            16 => 0.002,
            _ => 6.0 / 255.0,
        };
        let mut near = 0;
        for index in indices() {
            let point = index.map(|c| voxel * c as f32);
            let (exact, found) = (original.distance(point), copy.distance(point));
            if exact.abs() < 1.9 * voxel {
                near += 1;
                assert!(
                    (exact - found).abs() <= most * voxel,
                    "{name} {index:?}: {found} for {exact}"
                );
            } else {
                assert!(
                    found * exact > 0.0 && found.abs() > voxel,
                    "{name} {index:?}: {found} for {exact}"
                );
            }
        }
        assert!(near > 1000, "{near}");
    }
}

#[test]
fn densities_come_back_as_a_shape() {
    let folder = tempfile::tempdir().expect("a folder");
    let original = world(&solid());
    let path = folder.path().join("fog.vdb");
    let how = ExportOptions {
        class: ExportClass::Fog,
        ..options()
    };
    let voxel = original.export(&path, &how).expect("a file").voxel_size;
    // Half of the density lies a voxel and a half inside.
    let back = read_volume(&path, &VolumeReadOptions::default()).expect("a volume");
    assert!(back.is_fog);
    let mut scene = Scene::new();
    scene
        .push(Shape::sampled("back", back.grid))
        .expect("a brush");
    let copy = world(&scene);
    for point in [[-0.5, 0.2, 0.0], [-0.2, 0.4, 0.2], [0.8, 0.2, 0.1]] {
        let found = copy.distance(point);
        assert!(
            (found - 1.5 * voxel).abs() < 0.5 * voxel,
            "{point:?}: {found}"
        );
    }
}

#[test]
fn dense_files_come_back_as_shapes() {
    let folder = tempfile::tempdir().expect("a folder");
    let original = world(&solid());
    for name in ["a.npy", "a.nrrd", "a.raw"] {
        let path = folder.path().join(name);
        let report = original.export(&path, &options()).expect("a file");
        let [low, high] = report.bounds.expect("a box");
        let origin = low.map(|c| report.voxel_size * c as f32);
        let mut how = VolumeReadOptions::default();
        if name != "a.nrrd" {
            how.raw = RawLayout {
                shape: Some([0, 1, 2].map(|axis| (high[axis] - low[axis] + 1) as u32)),
                voxel_size: Some(report.voxel_size),
                origin: Some(origin),
                ..RawLayout::default()
            };
        }
        let back = read_volume(&path, &how).expect("a volume");
        let mut scene = Scene::new();
        scene
            .push(Shape::sampled("back", back.grid))
            .expect("a brush");
        let copy = world(&scene);
        for point in [[-0.5, 0.1, 0.1], [0.3, -0.4, 0.2], [-0.3, 0.1, 0.3]] {
            let (exact, found) = (original.distance(point), copy.distance(point));
            assert!(
                (exact - found).abs() < 0.1 * report.voxel_size,
                "{name} {point:?}: {found} for {exact}"
            );
        }
    }
    // The sidecar says how to read the raw file.
    let text = std::fs::read_to_string(folder.path().join("a.raw.json")).expect("text");
    assert!(
        text.contains("\"shape\"") && text.contains("x fastest"),
        "{text}"
    );
}

/// Independent: the field, at the place of each pixel that is looked at.
#[test]
fn a_flip_book_has_all_layers() {
    let folder = tempfile::tempdir().expect("a folder");
    let world = world(&solid());
    let path = folder.path().join("a.png");
    let report = world.export(&path, &options()).expect("a file");
    let [low, high] = report.bounds.expect("a box");
    let size = [0, 1, 2].map(|axis| (high[axis] - low[axis] + 1) as u32);
    let [columns, rows] = report.tiles.expect("tiles");
    assert!(columns * rows >= size[2] && columns * rows < size[2] + columns);
    let file = std::io::BufReader::new(std::fs::File::open(&path).expect("a file"));
    let mut reader = png::Decoder::new(file).read_info().expect("a picture");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut bytes).expect("pixels");
    assert_eq!(
        (info.width, info.height),
        (columns * size[0], rows * size[1])
    );
    assert_eq!(info.bit_depth, png::BitDepth::Sixteen);
    let band = 3.0 * report.voxel_size;
    let mut near = 0;
    for place in indices() {
        let at = [0, 1, 2].map(|axis| place[axis] - low[axis]);
        if (0..3).any(|axis| at[axis] < 0 || at[axis] >= size[axis] as i32) {
            continue;
        }
        let [x, y, z] = at.map(|c| c as u32);
        let pixel = [
            z % columns * size[0] + x,
            z / columns * size[1] + size[1] - 1 - y,
        ];
        let byte = 2 * (pixel[1] * info.width + pixel[0]) as usize;
        let found = f32::from(u16::from_be_bytes([bytes[byte], bytes[byte + 1]])) / 65_535.0;
        let exact = world.distance(place.map(|c| report.voxel_size * c as f32));
        let expected = (0.5 + 0.5 * exact / band).clamp(0.0, 1.0);
        assert!(
            (found - expected).abs() < 2e-5,
            "{place:?}: {found} for {expected}"
        );
        near += u32::from(expected > 0.0 && expected < 1.0);
    }
    assert!(near > 1000, "{near}");
}

/// Cutting off closes the solid: outside of the box, all is outside.
#[test]
fn an_infinite_scene_is_cut_off_and_closed() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut scene = Scene::new();
    let ground = Shape::Plane {
        normal: [0.0, 1.0, 0.0],
        offset: 0.0,
    };
    scene.push(ground).expect("a brush");
    scene.view.bounds = Some([[-1.0; 3], [1.0; 3]]);
    let path = folder.path().join("a.vdb");
    let report = world(&scene).export(&path, &options()).expect("a file");
    assert!(report.is_clipped);
    let grids = read(&path);
    let tree = &grids[0].as_float().expect("floats").tree;
    let at = |point: [f32; 3]| tree.value(point.map(|c| (c / report.voxel_size).round() as i32));
    assert!(at([0.0, -0.5, 0.0]) < 0.0 && at([0.9, -0.9, 0.9]) < 0.0);
    for outside in [
        [0.0, 0.5, 0.0],
        [1.5, -0.5, 0.0],
        [0.0, -1.2, 0.0],
        [0.0, -3.0, 9.0],
    ] {
        assert!(at(outside) > 0.0, "{outside:?}");
    }
}

#[test]
fn formats_are_told_by_their_names() {
    for format in ExportFormat::ALL {
        let name = format!("A.{}", format.extension().to_uppercase());
        assert_eq!(ExportFormat::from_path(Path::new(&name)), Some(format));
    }
    assert_eq!(ExportFormat::from_path(Path::new("vdb")), None);
    let world = world(&solid());
    let mut bytes = std::io::Cursor::new(Vec::new());
    world
        .export_to(&mut bytes, ExportFormat::Nvdb, &options())
        .expect("bytes");
    assert_eq!(nvdb::read(bytes.get_ref()).expect("a grid").len(), 1);
}
