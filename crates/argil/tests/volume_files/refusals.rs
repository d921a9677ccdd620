//! Volumes that cannot be written or read are refused, with a reason.

use super::{options, solid, world};
use argil::prelude::*;
use argil::{ExportError, ExportOptions, RawLayout, RawType, VolumeReadOptions, read_volume};

#[test]
fn what_a_format_cannot_hold_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let world = world(&solid());
    let refused = |name: &str, how: ExportOptions| {
        let path = folder.path().join(name);
        let error = world.export(&path, &how).expect_err("refused").to_string();
        assert!(!path.exists(), "{name}");
        error
    };
    assert!(refused("a.txt", options()).contains(".nrrd, .raw or .png"));
    let of = |bits| ExportOptions { bits, ..options() };
    assert!(refused("a.vdb", of(8)).contains("8 bits"));
    assert!(refused("a.npy", of(16)).contains("16 bits"));
    for band in [0.0, f32::NAN, 1e9] {
        let how = ExportOptions {
            half_width_voxels: band,
            ..options()
        };
        assert!(refused("a.vdb", how).contains("band"), "{band}");
    }
    let colors = ExportOptions {
        colors: true,
        ..options()
    };
    assert!(refused("a.nvdb", colors).contains("colors"));
    let huge = ExportOptions {
        resolution: 1 << 20,
        ..options()
    };
    assert!(refused("a.vdb", huge).contains("resolution"));
    let empty = argil::Engine::cpu()
        .build(&Scene::new())
        .expect("a world")
        .field();
    for name in ["empty.vdb", "empty.npy", "empty.png"] {
        let error = empty.export(folder.path().join(name), &options());
        assert!(error.expect_err("refused").to_string().contains("empty"));
    }
    let control = Control::new();
    control.cancel();
    let scene = solid();
    let canceled = Engine::cpu().with_control(&control).build(&scene);
    let canceled = canceled.expect("a world").field();
    let error = canceled.export(folder.path().join("b.vdb"), &options());
    assert!(matches!(error, Err(ExportError::Build(error)) if error.is_cancelled()));
}

#[test]
fn files_without_a_solid_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let refused = |name: &str, bytes: &[u8], how: &VolumeReadOptions| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("a file");
        let error = read_volume(&path, how).expect_err("refused");
        let mut text = error.to_string();
        let mut source = std::error::Error::source(&error);
        while let Some(cause) = source {
            text += &format!(": {cause}");
            source = cause.source();
        }
        assert!(text.contains(name), "{text}");
        text
    };
    let plain = VolumeReadOptions::default();
    for name in ["a.vdb", "a.nvdb", "a.npy", "a.nrrd"] {
        assert!(refused(name, b"garbage", &plain).contains("another format") || name == "a.nvdb");
        assert!(!refused(name, b"", &plain).is_empty());
    }
    assert!(refused("a.raw", &[0; 64], &plain).contains("--shape"));
    let raw = |shape| VolumeReadOptions {
        raw: RawLayout {
            shape: Some(shape),
            number: RawType::F32,
            ..RawLayout::default()
        },
        ..VolumeReadOptions::default()
    };
    assert!(refused("a.raw", &[0; 64], &raw([4, 4, 4])).contains("256 bytes"));
    assert!(refused("a.raw", &[0; 64], &raw([u32::MAX; 3])).contains("bytes"));
    assert!(refused("a.raw", &[0; 64], &raw([0, 4, 4])).contains("has none"));
    assert!(refused("a.raw", &[0; 256], &raw([4, 4, 4])).contains("no value is inside"));
    assert!(refused("a.raw", &[0xff; 256], &raw([4, 4, 4])).contains("not a number"));
    // Densities without a surface.
    let fog = VolumeReadOptions {
        is_fog: Some(true),
        ..raw([4, 4, 4])
    };
    assert!(refused("a.raw", &[0; 256], &fog).contains("no density"));
    // A name that the file does not have.
    let path = folder.path().join("b.vdb");
    world(&solid()).export(&path, &options()).expect("a file");
    let named = VolumeReadOptions {
        grid: Some("smoke".into()),
        ..VolumeReadOptions::default()
    };
    let bytes = std::fs::read(&path).expect("bytes");
    let text = refused("c.vdb", &bytes, &named);
    assert!(text.contains("smoke") && text.contains("surface"), "{text}");
    assert!(refused("c.vdb", &bytes[..bytes.len() / 2], &plain).contains("truncated"));
}

/// Reads an array of values as a mesh of the solid: its box, and whether it is closed.
fn closed_box(values: &[f32], side: u32, is_fog: bool) -> ([f32; 3], [f32; 3]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.raw");
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(&path, bytes).expect("a file");
    let how = VolumeReadOptions {
        is_fog: Some(is_fog),
        raw: RawLayout {
            shape: Some([side; 3]),
            voxel_size: Some(1.0),
            origin: Some([0.0; 3]),
            ..RawLayout::default()
        },
        ..VolumeReadOptions::default()
    };
    let read = read_volume(&path, &how).expect("a volume");
    let mut scene = Scene::new();
    scene.push(Shape::sampled("a", read.grid)).expect("a brush");
    let options = MeshOptions {
        resolution: 64,
        ..MeshOptions::default()
    };
    let output = world(&scene).mesh(&options).expect("a mesh");
    assert!(output.report.is_watertight(), "{:?}", output.report);
    let found = output.mesh.aabb();
    (found.min.to_array(), found.max.to_array())
}

/// A solid that reaches the sides of an array ends there, and is closed.
#[test]
fn solids_that_an_array_cuts_are_closed() {
    let side = 24u32;
    let at = |i: u32| [i % side, i / side % side, i / side / side].map(|c| c as f32);
    // The lower half, as distances, and a sphere at the last layer, as densities.
    let half: Vec<f32> = (0..side.pow(3)).map(|i| at(i)[2] - 11.5).collect();
    let (low, high) = closed_box(&half, side, false);
    for axis in 0..3 {
        let top = if axis == 2 { 11.5 } else { 23.0 };
        assert!(low[axis].abs() < 0.6, "{low:?}");
        assert!((high[axis] - top).abs() < 0.6, "{high:?}");
    }
    let sphere = |i: u32| {
        let [x, y, z] = at(i);
        let square = (x - 12.0).powi(2) + (y - 12.0).powi(2) + (z - 23.0).powi(2);
        (8.5 - square.sqrt()).clamp(0.0, 1.0)
    };
    let sphere: Vec<f32> = (0..side.pow(3)).map(sphere).collect();
    let (low, high) = closed_box(&sphere, side, true);
    assert!(
        (low[0] - 4.0).abs() < 1.0 && (high[0] - 20.0).abs() < 1.0,
        "{low:?} {high:?}"
    );
    assert!((high[2] - 23.5).abs() < 1.0, "{high:?}");
}

/// Active tiles are solid too, as those that other programs fill.
#[test]
fn active_tiles_count() {
    use argil::vdb::{Grid, GridClass, GridHeader, Leaf, Transform, Tree, vdb};
    let mut tree = Tree::from_leaves(0.0f32, vec![Leaf::new([0, 0, 0], 0.0)]);
    let lower = &mut tree.uppers[0].lowers[0];
    // 4³ tiles of 8³ voxels, the first of which is the empty leaf.
    for place in 0..4096usize {
        let at = [place / 256, place / 16 % 16, place % 16];
        let is_in = at.iter().all(|&c| (4..8).contains(&c));
        lower.active.set(place, is_in);
        lower.tiles[place] = f32::from(u8::from(is_in));
    }
    let header = GridHeader::new(
        "density",
        GridClass::FogVolume,
        Transform::uniform(1.0, [0.0; 3]),
    );
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.vdb");
    let mut file = std::fs::File::create(&path).expect("a file");
    vdb::write(
        &mut file,
        &[Grid::new(header, tree).into()],
        &vdb::WriteOptions::default(),
    )
    .expect("bytes");
    let read = read_volume(&path, &VolumeReadOptions::default()).expect("a volume");
    let mut scene = Scene::new();
    scene.push(Shape::sampled("a", read.grid)).expect("a brush");
    let world = world(&scene);
    assert!(world.distance([48.0, 48.0, 48.0]) < -2.0);
    for side in [[31.5, 48.0, 48.0], [48.0, 63.5, 48.0]] {
        assert!(world.distance(side).abs() < 0.6, "{}", world.distance(side));
    }
}

/// A small file whose active tiles or whose box would take gigabytes is refused.
#[test]
fn small_files_take_little() {
    use argil::vdb::{Codec, Grid, GridClass, GridHeader, Leaf, Transform, Tree, vdb};
    let refused = |tree: Tree<f32>, part: &str| {
        let header = GridHeader::new(
            "all",
            GridClass::LevelSet,
            Transform::uniform(0.1, [0.0; 3]),
        );
        let grid = Grid::new(header, tree).into();
        let mut bytes = std::io::Cursor::new(Vec::new());
        let how = vdb::WriteOptions {
            codec: Codec::Zip,
            ..Default::default()
        };
        vdb::write(&mut bytes, &[grid], &how).expect("a file");
        let bytes = bytes.into_inner();
        assert!(bytes.len() < 100_000, "{}", bytes.len());
        let read = argil::read_volume_bytes(&bytes, "a.vdb".as_ref(), &Default::default());
        let reason = read.expect_err(part).to_string();
        assert!(reason.contains(part), "{reason}");
    };
    let leaf = |at: i32| {
        let mut leaf = Leaf::new([at; 3], 3.0);
        leaf.set([at; 3], -0.5);
        leaf
    };
    refused(
        Tree::from_leaves(3.0, vec![leaf(0), leaf(1144)]),
        "cells of 8³ are read of a file of",
    );
    refused(
        Tree::from_leaves(3.0, vec![leaf(0), leaf(-(1 << 30))]),
        "voxels from the origin",
    );
    let mut tiled = Tree::from_leaves(3.0, vec![leaf(0)]);
    for place in 1..200 {
        tiled.uppers[0].active.set(place, true);
        tiled.uppers[0].tiles[place] = -1.0;
    }
    refused(tiled, "active tiles");
}
