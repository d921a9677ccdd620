//! OpenVDB's and NanoVDB's own programs read what Argil writes, and Argil reads what OpenVDB writes.

use argil::prelude::*;
use argil::{ExportClass, ExportCodec, ExportOptions, VolumeReadOptions, read_volume};
use std::path::Path;
use std::process::Command;

const INSTALL: &str = "python3-openvdb, libopenvdb-tools, libnanovdb-tools and python3-numpy are needed: `cargo xtask test` installs them on Debian and Ubuntu";

/// Runs a program, and returns what it printed.
fn run(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).output();
    let output = output.unwrap_or_else(|error| panic!("{program}: {error}: {INSTALL}"));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "{program}: {text}{errors}: {INSTALL}"
    );
    text
}

/// Debian's module belongs to Debian's Python.
const PYTHON: &str = "/usr/bin/python3";

fn world(name: &str) -> World {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
    let scene = Scene::open(format!("{folder}/{name}.json")).expect("a scene that ships");
    Engine::cpu().build(&scene).expect("a world").field()
}

/// Numbers from 0 to 1 in a fixed order (Steele et al., "Fast splittable pseudorandom number generators", 2014).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Writes a volume, and next to it what OpenVDB should find.
fn write(world: &World, folder: &Path, name: &str, how: &ExportOptions, off: f32, count: u32) {
    let report = world
        .export(folder.join(format!("{name}.vdb")), how)
        .expect("a file");
    let [low, high] = report.bounds.expect("active voxels");
    let width = how.half_width_voxels * report.voxel_size;
    let mut numbers = Numbers(1);
    let mut bytes = Vec::new();
    for _ in 0..count {
        let index = [0, 1, 2].map(|axis| {
            let span = f64::from(high[axis] - low[axis] + 21);
            low[axis] - 10 + (numbers.next() * span) as i32
        });
        let exact = world.distance(index.map(|c| report.voxel_size * c as f32));
        let value = match how.class {
            ExportClass::LevelSet => exact.clamp(-width, width),
            ExportClass::Fog => (-exact / width).clamp(0.0, 1.0),
        };
        bytes.extend(index.iter().flat_map(|c| c.to_le_bytes()));
        bytes.extend(value.to_le_bytes());
    }
    let (class, grid, background) = match how.class {
        ExportClass::LevelSet => ("level set", "surface", width),
        ExportClass::Fog => ("fog volume", "density", 0.0),
    };
    let head = format!("{} {background} {} {off}", report.voxel_size, report.voxels);
    let save = |ending: &str, bytes: &[u8]| {
        std::fs::write(folder.join(format!("{name}.{ending}")), bytes).expect("a file");
    };
    save("points", &bytes);
    save("txt", format!("{head}\n{class}\n{grid}").as_bytes());
}

/// Independent: OpenVDB reads the files, and the field gives the values at random voxels, one by one.
#[test]
fn openvdb_reads_what_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let csg = world("csg20");
    let plain = ExportOptions {
        keep_bounds: true,
        ..ExportOptions::default()
    };
    // Distances of 16 bits are off by half of their last place.
    write(&csg, folder.path(), "plain", &plain, 1e-7, 1_000_000);
    let codec = |codec| ExportOptions {
        resolution: 128,
        codec,
        ..plain
    };
    write(
        &csg,
        folder.path(),
        "zip",
        &codec(ExportCodec::Zip),
        1e-7,
        50_000,
    );
    write(
        &csg,
        folder.path(),
        "blosc",
        &codec(ExportCodec::Blosc),
        1e-7,
        50_000,
    );
    let half = ExportOptions {
        bits: 16,
        colors: true,
        ..codec(ExportCodec::Blosc)
    };
    write(&csg, folder.path(), "half", &half, 3e-5, 50_000);
    let wide = ExportOptions {
        half_width_voxels: 10.0,
        ..codec(ExportCodec::None)
    };
    write(&world("teapot"), folder.path(), "wide", &wide, 1e-6, 50_000);
    let fog = ExportOptions {
        class: ExportClass::Fog,
        ..codec(ExportCodec::None)
    };
    write(&csg, folder.path(), "fog", &fog, 1e-6, 50_000);
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/openvdb.py");
    let path = folder.path().to_string_lossy();
    print!("{}", run(PYTHON, &[script, &path]));

    let file = folder.path().join("half.vdb");
    let text = run("vdb_print", &["-l", &file.to_string_lossy()]);
    for part in [
        "Tree_vec3s_5_4_3",
        "Tree_float_5_4_3",
        "level set",
        "blosc + active values",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn nanovdb_reads_what_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let csg = world("csg20");
    for (bits, class) in [
        (32, ExportClass::LevelSet),
        (16, ExportClass::LevelSet),
        (8, ExportClass::LevelSet),
        (32, ExportClass::Fog),
    ] {
        let how = ExportOptions {
            resolution: 128,
            bits,
            class,
            ..ExportOptions::default()
        };
        let file = folder.path().join(format!("a-{bits}.nvdb"));
        let report = csg.export(&file, &how).expect("a file");
        let file = file.to_string_lossy().into_owned();
        let text = run("nanovdb_validate", &["-v", &file]);
        assert!(
            text.contains("passed") && !text.contains("failed"),
            "{text}"
        );
        let text = run("nanovdb_print", &[&file]);
        assert!(text.contains(&report.voxels.to_string()), "{text}");
        // A changed byte of a leaf is seen, so the checksum is compared.
        let mut bytes = std::fs::read(&file).expect("bytes");
        let last = bytes.len() - 1;
        bytes[last] ^= 1;
        std::fs::write(&file, bytes).expect("a file");
        let text = Command::new("nanovdb_validate")
            .args(["-v", &file])
            .output();
        let text = String::from_utf8_lossy(&text.expect("a program").stdout).into_owned();
        assert!(!text.contains("passed"), "{text}");
    }
}

/// OpenVDB writes a sphere with each of its compressions, which comes back as a shape.
#[test]
fn what_openvdb_writes_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let script = "
import sys, pyopenvdb as vdb
sphere = vdb.createLevelSetSphere(radius=1.0, center=(3.0, -2.0, 0.5), voxelSize=0.05, halfWidth=4.0)
sphere.name = 'sphere'
for half in (False, True):
    sphere.saveFloatAsHalf = half
    vdb.write(f'{sys.argv[1]}/sphere-{half}.vdb', grids=[sphere])
other = vdb.createLevelSetSphere(radius=0.5, voxelSize=0.05)
other.name = 'other'
sphere.saveFloatAsHalf = False
vdb.write(f'{sys.argv[1]}/two.vdb', grids=[other, sphere])
";
    let path = folder.path().to_string_lossy().into_owned();
    run(PYTHON, &["-c", script, &path]);
    for (name, grid) in [
        ("sphere-False", None),
        ("sphere-True", None),
        ("two", Some("sphere")),
    ] {
        let how = VolumeReadOptions {
            grid: grid.map(str::to_owned),
            ..VolumeReadOptions::default()
        };
        let read = read_volume(folder.path().join(format!("{name}.vdb")), &how).expect("a shape");
        assert_eq!(read.name, "sphere");
        let mut scene = Scene::new();
        scene
            .push(Shape::sampled("sphere", read.grid))
            .expect("a brush");
        let world = Engine::cpu().build(&scene).expect("a world").field();
        let mut numbers = Numbers(7);
        for _ in 0..2000 {
            let way = [(); 3].map(|()| 2.0 * numbers.next() - 1.0);
            let length = way.iter().map(|c| c * c).sum::<f64>().sqrt();
            let radius = 0.92 + 0.16 * numbers.next();
            let point = [0, 1, 2].map(|axis| {
                let center = [3.0, -2.0, 0.5][axis];
                (center + way[axis] / length * radius) as f32
            });
            let (exact, found) = ((radius - 1.0) as f32, world.distance(point));
            assert!(
                (exact - found).abs() < 0.002,
                "{name} {point:?}: {found} for {exact}"
            );
        }
    }
}
