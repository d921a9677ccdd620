//! OME-Zarr folders. Needs the feature `zarr`.
#![cfg(feature = "zarr")]

use argil::prelude::*;
use argil::{ExportClass, ExportError, ExportOptions};
use std::sync::Arc;
use zarrs::array::Array;
use zarrs::filesystem::FilesystemStore;
use zarrs::group::Group;

fn world() -> World {
    let mut scene = Scene::new();
    let shape = Brush::new(Shape::cuboid([0.5, 0.3, 0.2])).at([0.1, 0.0, 0.0]);
    scene.push(shape).expect("a brush");
    Engine::cpu().build(&scene).expect("a world").field()
}

/// Independent: the field, point by point, at the places that the metadata tell.
#[test]
fn a_pyramid_has_the_fields_distances() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.zarr");
    let world = world();
    let options = ExportOptions {
        resolution: 200,
        ..ExportOptions::default()
    };
    let report = world.export_zarr(&path, &options).expect("a folder");
    let store = Arc::new(FilesystemStore::new(&path).expect("a store"));
    let group = Group::open(store.clone(), "/").expect("a group");
    let image = &group.attributes()["ome"]["multiscales"][0];
    let datasets = image["datasets"].as_array().expect("a list");
    assert_eq!(datasets.len(), 3);
    let mut count = 0;
    for (level, dataset) in datasets.iter().enumerate() {
        let array = Array::open(store.clone(), &format!("/{level}")).expect("an array");
        let shape = array.shape().to_vec();
        count += shape.iter().product::<u64>();
        let numbers = |index: usize, key: &str| -> Vec<f32> {
            let values = &dataset["coordinateTransformations"][index][key];
            let values = values.as_array().expect("numbers").iter();
            values
                .map(|n| n.as_f64().expect("a number") as f32)
                .collect()
        };
        let (scale, translation) = (numbers(0, "scale"), numbers(1, "translation"));
        let values: Vec<f32> = array
            .retrieve_array_subset(&array.subset_all())
            .expect("values");
        let mut inside = 0;
        for (i, value) in values.iter().enumerate().step_by(37) {
            let i = i as u64;
            let place = [
                i / (shape[1] * shape[2]),
                i / shape[2] % shape[1],
                i % shape[2],
            ];
            let [z, y, x] =
                [0, 1, 2].map(|axis| translation[axis] + scale[axis] * place[axis] as f32);
            let exact = world.distance([x, y, z]);
            assert!(
                (value - exact).abs() < 1e-5,
                "level {level}, {place:?}: {value} for {exact}"
            );
            inside += u32::from(exact < 0.0);
        }
        assert!(inside > 20, "level {level}: {inside}");
    }
    assert_eq!(report.voxels, count);
    // Shards are files, and chunks are not.
    let files = std::fs::read_dir(path.join("0/c/0/0"))
        .expect("shards")
        .count();
    assert_eq!(files, 2);

    // It replaces its own, and nothing else.
    let fog = ExportOptions {
        class: ExportClass::Fog,
        ..options
    };
    world.export_zarr(&path, &fog).expect("a folder");
    let other = folder.path().join("other");
    std::fs::create_dir(&other).expect("a folder");
    // A folder of another program.
    std::fs::write(other.join("zarr.json"), "{\"zarr_format\": 3}").expect("a file");
    let error = world.export_zarr(&other, &fog).expect_err("foreign");
    assert!(matches!(error, ExportError::Write { .. }), "{error}");
    let text = std::fs::read_to_string(other.join("zarr.json")).expect("the file");
    assert_eq!(text, "{\"zarr_format\": 3}");
    let left = std::fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(left, 2, "no parts are left");
}
