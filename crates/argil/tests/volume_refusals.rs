//! Volumes that cannot be written or read are refused, with a reason.

use argil::prelude::*;
use argil::{ExportError, ExportOptions, RawLayout, RawType, VolumeReadOptions, read_volume};

fn solid() -> Scene {
    let mut scene = Scene::new();
    scene.push(Shape::sphere(0.5)).expect("a brush");
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
    let path = folder.path().join("empty.vdb");
    assert_eq!(empty.export(&path, &options()).expect("a file").voxels, 0);
    assert!(
        empty
            .export(folder.path().join("empty.npy"), &options())
            .is_err()
    );
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
        while let Some(own) = source {
            text += &format!(": {own}");
            source = own.source();
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
    assert!(refused("a.raw", &[0; 64], &raw([0, 4, 4])).contains("at least 1"));
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
