//! Tests `argil world` with processes that are killed, and worlds that are read back.

use crate::common::{argil, fails, json, scene};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// A folder with the plan of a scene.
struct Bench {
    folder: tempfile::TempDir,
    plan: String,
    hash: String,
}

fn bench(name: &str, voxel_size: &str) -> Bench {
    let folder = tempfile::tempdir().expect("a folder");
    let plan = folder.path().join("plan.json").display().to_string();
    let made = json(&argil(&[
        "world",
        "plan",
        &scene(name),
        "--voxel-size",
        voxel_size,
        "-o",
        &plan,
        "--json",
    ]));
    assert!(made["tiles"].as_u64() > Some(0), "{made}");
    let hash = made["hash"].as_str().expect("a hash").to_owned();
    Bench { folder, plan, hash }
}

impl Bench {
    fn store(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }

    /// Returns the folder of the world in a store.
    fn world(&self, store: &str) -> PathBuf {
        Path::new(store).join(&self.hash)
    }

    fn bake(&self, store: &str) -> serde_json::Value {
        json(&argil(&[
            "world", "bake", &self.plan, "--store", store, "--json",
        ]))
    }

    fn finish(&self, store: &str) -> serde_json::Value {
        let verify = [
            "world", "finish", &self.plan, "--store", store, "--verify", "--json",
        ];
        json(&argil(&verify))
    }

    fn worker(&self, store: &str, shard: &str) -> Child {
        Command::new(env!("CARGO_BIN_EXE_argil"))
            .args([
                "world", "bake", &self.plan, "--store", store, "--shard", shard,
            ])
            .args(["--threads", "1"])
            .stdout(Stdio::null())
            .spawn()
            .expect("the command starts")
    }
}

/// Returns all objects of a store. Names of unfinished files are not objects.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let (mut all, mut open) = (BTreeMap::new(), vec![folder.to_path_buf()]);
    while let Some(at) = open.pop() {
        // Nobody may have put anything yet.
        for entry in std::fs::read_dir(at).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else if !path.to_string_lossy().contains('#') {
                let bytes = std::fs::read(&path).expect("an object");
                let name = path.strip_prefix(folder).expect("within").to_path_buf();
                all.insert(name, bytes);
            }
        }
    }
    all
}

/// Four workers are killed twenty times at any moment, two of them at the same tiles: the world is that of one process.
#[test]
fn killed_workers_come_back_and_make_the_same_world() {
    let rig = bench("csg20", "0.002");
    let (one, many) = (rig.store("one"), rig.store("many"));
    let done = rig.bake(&one);
    assert!(done["baked"].as_u64() > Some(3) && done["present"] == 0);
    let shards = ["0/3", "1/3", "2/3", "2/3"];
    let mut seed = 5u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        seed >> 33
    };
    let mut workers: Vec<Child> = shards.map(|shard| rig.worker(&many, shard)).into();
    for _ in 0..20 {
        std::thread::sleep(Duration::from_millis(random() % 60));
        let index = random() as usize % workers.len();
        // It may be done already.
        let _ = workers[index].kill();
        let _ = workers[index].wait();
        // What is there was never half written.
        for (name, bytes) in contents(&rig.world(&many)) {
            let whole = std::fs::read(rig.world(&one).join(&name)).expect("the same object");
            assert!(whole == bytes, "{name:?}");
        }
        workers[index] = rig.worker(&many, shards[index]);
    }
    for mut worker in workers {
        assert!(worker.wait().expect("an end").success());
    }
    let again = rig.bake(&many);
    assert_eq!(
        (&again["baked"], &again["present"]),
        (&0.into(), &done["baked"])
    );
    assert_eq!(rig.finish(&one)["tiles"], rig.finish(&many)["tiles"]);
    assert_eq!(rig.finish(&many)["tiles"], done["baked"]);
    assert!(contents(Path::new(&one)) == contents(Path::new(&many)));
    // The jobs of an array find their shards by themselves.
    let array = rig.store("array");
    for task in ["3", "4"] {
        let job = Command::new(env!("CARGO_BIN_EXE_argil"))
            .args(["world", "bake", &rig.plan, "--store", &array])
            .envs([("SLURM_ARRAY_TASK_ID", task), ("SLURM_ARRAY_TASK_MIN", "3")])
            .env("SLURM_ARRAY_TASK_COUNT", "2")
            .output();
        assert!(job.expect("the command starts").status.success());
    }
    rig.finish(&array);
    assert!(contents(Path::new(&one)) == contents(Path::new(&array)));
}

/// A finished world looks as the field does. Without a tile it is coarser there, and says so; from the scene, what is missing
/// is baked.
#[test]
fn stored_worlds_are_rendered() {
    let rig = bench("csg20", "0.004");
    let store = rig.store("store");
    rig.bake(&store);
    fails(
        &[
            "render",
            &rig.world(&store).display().to_string(),
            "-o",
            &rig.store("x.png"),
        ],
        1,
        "argil world finish",
    );
    rig.finish(&store);
    let picture = |name: &str, input: &[&str]| {
        let path = rig.store(name);
        let size = ["--size", "160x90", "--device", "cpu", "--json", "-o", &path];
        let output = argil(&[&["render"], input, &size].concat());
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        (
            json(&output),
            std::fs::read(path).expect("a picture"),
            errors,
        )
    };
    let manifest = rig
        .world(&store)
        .join("manifest.json")
        .display()
        .to_string();
    let levels = ["--via", "levels", "--voxel-size", "0.004"];
    let csg = scene("csg20");
    let field = [&[&csg[..]], &levels[..]].concat();
    let (found, stored, errors) = picture("a.png", &[&manifest]);
    let (_, baked, _) = picture("b.png", &field);
    assert!(stored == baked && errors.is_empty(), "{errors}");
    assert!(found["tile_requests"].as_u64() > Some(0) && found["tiles_missing"] == 0);

    let tiles = rig.world(&store).join("tiles/0");
    for (index, entry) in std::fs::read_dir(tiles)
        .expect("tiles")
        .flatten()
        .enumerate()
    {
        // Some are gone, and some are damaged.
        if index % 2 == 0 {
            std::fs::remove_file(entry.path()).expect("a tile");
        } else {
            let bytes = std::fs::read(entry.path()).expect("a tile");
            std::fs::write(entry.path(), &bytes[..bytes.len() - 7]).expect("a tile");
        }
    }
    let (found, coarse, errors) = picture("c.png", &[&manifest]);
    assert!(coarse != baked && found["tiles_missing"].as_u64() > Some(0));
    assert!(
        errors.contains("warning: tile 0/") && errors.contains("coarser"),
        "{errors}"
    );
    let (_, both, _) = picture("d.png", &[&field[..], &["--store", &store]].concat());
    assert!(both == baked);

    let status = [
        "world", "status", &rig.plan, "--store", &store, "--verify", "--json",
    ];
    let found = json(&argil(&status));
    let damaged = found["damaged"].as_array().map_or(0, Vec::len) as u64;
    assert!(
        damaged > 0 && found["missing"].as_u64() > Some(0),
        "{found}"
    );
    let verify = ["world", "finish", &rig.plan, "--store", &store, "--verify"];
    fails(&verify, 1, "were damaged, among them 0/");
    fails(&verify, 1, "are missing, among them 0/");
    rig.bake(&store);
    let (_, mended, errors) = picture("e.png", &[&manifest]);
    assert!(mended == baked && errors.is_empty());
}

#[test]
fn requests_at_fault_are_refused() {
    let rig = bench("csg20", "0.01");
    let (plan, store) = (&rig.plan[..], &rig.store("store")[..]);
    let bake = ["world", "bake", plan, "--store", store];
    for shard in ["2/2", "x", "0/0", "-1/2"] {
        fails(
            &[&bake[..], &[&format!("--shard={shard}")]].concat(),
            2,
            "--shard",
        );
    }
    fails(
        &["world", "bake", &scene("csg20"), "--store", store],
        1,
        "argil world plan",
    );
    fails(
        &["world", "bake", "none.json", "--store", store],
        1,
        "none.json",
    );
    fails(
        &["world", "bake", plan, "--store", "/proc/none/x"],
        1,
        "/proc/none/x",
    );
    fails(&["world", "bake", plan, "--store", "s3:///"], 1, "s3://");
    let finish = ["world", "finish", plan, "--store", store];
    fails(&finish, 1, "store: No such file");
    assert!(!Path::new(store).exists());
    std::fs::create_dir_all(store).expect("a folder");
    fails(&finish, 1, "tiles are missing");
    let voxels = |length: &str| {
        let size = format!("--voxel-size={length}");
        argil(&[
            "world",
            "plan",
            &scene("csg20"),
            &size,
            "-o",
            &rig.store("y.json"),
        ])
    };
    for length in ["0", "-1", "nan", "inf", "x"] {
        assert_eq!(voxels(length).status.code(), Some(2), "{length}");
    }
    for length in ["1e-9", "1e9"] {
        assert_eq!(voxels(length).status.code(), Some(1), "{length}");
    }
    let text = std::fs::read_to_string(plan).expect("a plan");
    let changed = rig.store("changed.json");
    std::fs::write(&changed, text.replacen("brass", "Brass", 1)).expect("a file");
    fails(
        &["world", "bake", &changed, "--store", store],
        1,
        "hash is another one",
    );
    let render = ["render", &scene("csg20"), "--store", store];
    fails(&render, 1, "--voxel-size");
    let manifest = Path::new(store).join("manifest.json");
    std::fs::create_dir_all(store).expect("a folder");
    std::fs::write(&manifest, "{").expect("a file");
    fails(
        &["render", &manifest.display().to_string()],
        1,
        "no manifest of a world",
    );
}
