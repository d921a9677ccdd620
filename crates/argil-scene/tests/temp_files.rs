//! Tests temporary files, and folders of exports.

use argil_scene::Scene;

/// What killed programs left is removed by the next one that writes there. What living ones make stays, and so does all else.
#[test]
fn abandoned_files_are_removed() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let long_ago = std::time::SystemTime::now() - std::time::Duration::from_secs(3600);
    let age = |file: &std::fs::File| file.set_modified(long_ago).unwrap();
    for name in [
        ".argil-unfinished-dead01",
        ".argil-unfinished-live01",
        ".argil-unfinished-notes",
        ".argil-unfinished-a.b.c1",
        ".argil-backup",
        "mine",
    ] {
        std::fs::write(at(name), "x").unwrap();
        age(&std::fs::File::options()
            .append(true)
            .open(at(name))
            .unwrap());
    }
    std::fs::write(at(".argil-unfinished-young1"), "x").unwrap();
    std::fs::create_dir(at(".argil-unfinished-dead02")).unwrap();
    std::fs::write(at(".argil-unfinished-dead02/part"), "x").unwrap();
    age(&std::fs::File::open(at(".argil-unfinished-dead02")).unwrap());
    let lock = std::fs::File::open(at(".argil-unfinished-live01")).unwrap();
    lock.lock().unwrap();
    let living = argil_scene::TempFolder::beside(&at("export")).unwrap();
    age(&std::fs::File::open(living.path()).unwrap());
    Scene::new().save(at("scene.json")).unwrap();
    for name in [".argil-unfinished-dead01", ".argil-unfinished-dead02"] {
        assert!(!at(name).exists(), "{name}");
    }
    for name in [
        ".argil-unfinished-live01",
        ".argil-unfinished-young1",
        ".argil-unfinished-notes",
        ".argil-unfinished-a.b.c1",
        ".argil-backup",
        "mine",
    ] {
        assert!(at(name).exists(), "{name}");
    }
    assert!(living.path().exists());
    living.persist(&at("export")).unwrap();
    assert!(at("export").is_dir());
}

/// An export replaces an empty folder and its own, and refuses anything else with the remedy.
#[test]
fn exports_replace_no_foreign_folder() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("export");
    let mark = place.join("zarr.json");
    let export = || {
        let temp_folder = argil_scene::TempFolder::for_export(&place, "zarr.json")?;
        std::fs::write(
            temp_folder.path().join("zarr.json"),
            r#"{"generator": "argil 1.0"}"#,
        )?;
        temp_folder.persist(&place)
    };
    for foreign in [None, Some("{}"), Some(r#"{"generator": "other 1.0"}"#)] {
        std::fs::create_dir(&place).unwrap();
        std::fs::write(place.join("data"), "precious").unwrap();
        if let Some(text) = foreign {
            std::fs::write(&mark, text).unwrap();
        }
        let error = export().unwrap_err().to_string();
        assert!(
            error.contains("no zarr.json of Argil in it: choose another name"),
            "{error}"
        );
        assert_eq!(std::fs::read(place.join("data")).unwrap(), b"precious");
        std::fs::remove_dir_all(&place).unwrap();
    }
    std::fs::write(&place, "a file").unwrap();
    assert!(export().is_err());
    std::fs::remove_file(&place).unwrap();
    std::fs::create_dir(&place).unwrap();
    // Into the empty folder, and again in place of the first export.
    for _ in 0..2 {
        export().unwrap();
        assert!(mark.is_file());
    }
    // What a user keeps in an export stays.
    std::fs::create_dir_all(place.join("0/c")).unwrap();
    std::fs::write(place.join("0/c/1"), "a chunk").unwrap();
    for foreign in ["notes.txt", "0/c/2024.txt", "0/.hidden"] {
        std::fs::write(place.join(foreign), "precious").unwrap();
        let error = export().unwrap_err().to_string();
        assert!(error.contains("no part of an export"), "{error}");
        assert_eq!(std::fs::read(place.join(foreign)).unwrap(), b"precious");
        std::fs::remove_file(place.join(foreign)).unwrap();
    }
    export().unwrap();
    assert!(!place.join("0").exists());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
