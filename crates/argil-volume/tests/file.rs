//! Tests volume files: round trips, and every way in which a file can be wrong.

use argil_field::Program;
use argil_math::Aabb;
use argil_scene::{Brush, Scene, Shape};
use argil_volume::{
    Band, BrickLayout, BrickSettings, Bricks, Dense, Encoding, Octree, OctreeLayout,
    OctreeSettings, SampleFormat, Section, StoredMesh, Volume, VolumeError, VolumeFile, VoxelGrid,
};
use glam::Vec3;

/// Builds a volume file's other sections: a path whose length is not a multiple of 4, and one without words.
fn meshes() -> Vec<StoredMesh<'static>> {
    let mesh = |path: &'static str, words: Vec<f32>| StoredMesh {
        path: path.into(),
        resolution: 7,
        solid: Aabb::centered(Vec3::splat(0.5)),
        words: words.into(),
    };
    vec![mesh("a/tée.obj", vec![1.0, -2.5]), mesh("b.ply", vec![])]
}

const SCENE: &str = "{\"argil\": 1, \"brushes\": []}";

fn program() -> Program {
    let mut scene = Scene::new();
    for (x, r) in [(0.0, 0.4), (0.5, 0.2)] {
        let ball = Brush::new(Shape::sphere(r)).at([x, 0.1, 0.0]).smooth(0.1);
        scene.push(ball).expect("a valid brush");
    }
    Program::lower(&scene).expect("a program")
}

fn volumes() -> Vec<Volume> {
    let program = program();
    let voxel_grid = VoxelGrid::fitting(program.aabb(), None, 21).expect("a voxel grid");
    let sixteen = Encoding {
        format: SampleFormat::Snorm16,
        band: Band::Voxels(6.0),
    };
    let layout = OctreeLayout::new(
        voxel_grid,
        &OctreeSettings {
            brick_size_voxels: 8,
            ..OctreeSettings::default()
        },
    )
    .expect("a layout");
    let bricks = |bits| {
        let encoding = Encoding {
            format: bits,
            ..sixteen
        };
        let settings = BrickSettings {
            encoding,
            brick_size_voxels: 4,
        };
        let layout = BrickLayout::new(voxel_grid, &settings).expect("a layout");
        Bricks::bake(&program, layout, None).expect("bricks").0
    };
    vec![
        Dense::bake(&program, voxel_grid, Encoding::default(), true).into(),
        Dense::bake(&program, voxel_grid, sixteen, false).into(),
        Octree::bake(&program, layout, OctreeSettings::default().brick_test)
            .0
            .into(),
        bricks(SampleFormat::Snorm16).into(),
        bricks(SampleFormat::Snorm8).into(),
    ]
}

fn bytes_of(volume: &Volume) -> Vec<u8> {
    let mut bytes = Vec::new();
    volume
        .write(SCENE, &meshes(), &mut bytes)
        .expect("a vector takes all");
    bytes
}

#[test]
fn volumes_survive_a_round_trip_bit_for_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    for (i, volume) in volumes().into_iter().enumerate() {
        let bytes = bytes_of(&volume);
        let path = folder.path().join(format!("{i}.argil"));
        std::fs::write(&path, &bytes).expect("a file");
        assert!(VolumeFile::is_volume_file(&path));
        let mapped = VolumeFile::open(&path).expect("a volume");
        let copied = VolumeFile::from_bytes(&bytes, "copy").expect("a volume");
        for stored in [mapped, copied] {
            assert!(stored.volume == volume);
            assert_eq!(stored.scene_json, SCENE);
            assert_eq!(stored.meshes, meshes());
            // What is read can be written again, and is the same file.
            assert!(bytes_of(&stored.volume) == bytes);
        }
    }
}

/// Another program may cut a file short or write over it, once it was read.
#[test]
fn volumes_survive_their_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cut.argil");
    for volume in volumes() {
        std::fs::write(&path, bytes_of(&volume)).expect("a file");
        let stored = VolumeFile::open(&path).expect("a volume");
        let file = std::fs::File::options().write(true).open(&path);
        file.and_then(|file| file.set_len(0)).expect("no bytes");
        assert!(stored.volume == volume);
    }
}

/// Builds the longest possible volume, which is thin and has the maximum number of levels.
#[test]
fn a_volume_with_the_most_levels_survives_too() {
    let mut scene = Scene::new();
    let rod = Brush::new(Shape::cuboid([1.0, 1e-3, 1e-3]));
    scene.push(rod).expect("a valid brush");
    let program = Program::lower(&scene).expect("a program");
    let voxel_grid = VoxelGrid::fitting(program.aabb(), None, 4096).expect("a voxel grid");
    let volume: Volume = Dense::bake(&program, voxel_grid, Encoding::default(), true).into();
    let Volume::Dense(dense) = &volume else {
        panic!("it is dense");
    };
    assert_eq!(dense.levels().len(), 11);
    let stored = VolumeFile::from_bytes(&bytes_of(&volume), "long").expect("a volume");
    assert!(stored.volume == volume);
}

#[test]
fn a_truncated_file_is_refused_at_every_length_with_the_section_at_fault() {
    for volume in volumes() {
        let bytes = bytes_of(&volume);
        let mut sections = Vec::new();
        for length in 0..bytes.len() {
            let error = VolumeFile::from_bytes(&bytes[..length], "cut").err();
            match error {
                Some(VolumeError::Truncated {
                    section, end, size, ..
                }) => {
                    assert!(end > size && size == length as u64);
                    if sections.last() != Some(&section) {
                        sections.push(section);
                    }
                }
                Some(VolumeError::NotAVolumeFile(_)) => assert!(length < 8),
                other => panic!("{length} bytes: {:?}", other.map(|e| e.to_string())),
            }
        }
        // From the header on, each section was the one at fault once.
        assert!(sections.len() >= 4, "{sections:?}");
        assert_eq!(sections[0], Section::Header);
        assert!(VolumeFile::from_bytes(&[&bytes[..], &[0]].concat(), "long").is_err());
    }
}

#[test]
fn every_changed_byte_is_detected_except_in_gaps() {
    for volume in volumes() {
        let bytes = bytes_of(&volume);
        let mut unnoticed = 0;
        for i in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[i] ^= 0x10;
            match VolumeFile::from_bytes(&damaged, "damaged") {
                // Nothing is stored between sections.
                Ok(stored) => {
                    assert!(stored.volume == volume);
                    unnoticed += 1;
                }
                Err(error) => assert!(error.to_string().starts_with("damaged: ")),
            }
        }
        assert!(unnoticed < 64 * 12, "{unnoticed}");
    }
}

#[test]
fn newer_files_and_others_say_so() {
    let mut bytes = bytes_of(&volumes()[0]);
    bytes[8] = 3;
    let error = VolumeFile::from_bytes(&bytes, "new").expect_err("an error");
    assert_eq!(
        error.to_string(),
        "new: format version 3 is newer than this program reads (2): update argil"
    );
    let error = VolumeFile::from_bytes(b"PNG, or something else", "other").err();
    assert_eq!(
        error.expect("an error").to_string(),
        "other: not a volume file"
    );
    assert!(VolumeFile::open("/nowhere/at/all.argil").is_err());
    assert!(VolumeFile::open(".").is_err());
}

/// Builds a file with correct checksums and wrong contents, as a fuzzer that repairs checksums would.
#[test]
fn inconsistent_contents_are_refused() {
    let mut refused = 0;
    let mut state = 12345u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8
    };
    for volume in volumes() {
        let bytes = bytes_of(&volume);
        for _ in 0..3000 {
            let mut changed = bytes.clone();
            // Descriptions, codes and nodes are small; hit them often.
            for _ in 0..1 + next() % 4 {
                let at = if next() % 2 == 0 {
                    32 + next() as usize % 1200
                } else {
                    next() as usize % changed.len()
                };
                let at = at.min(changed.len() - 1);
                changed[at] = [0, 1, 0x7f, 0x80, 0xff, next() as u8][next() as usize % 6];
            }
            repair(&mut changed);
            match VolumeFile::from_bytes(&changed, "fuzz") {
                Ok(stored) => {
                    // What is accepted can be used.
                    let p = stored.volume.voxel_grid().aabb().center();
                    if let Volume::Dense(dense) = &stored.volume {
                        assert!(dense.distance(0, p).is_some());
                    }
                    let _ = bytes_of(&stored.volume);
                }
                Err(_) => refused += 1,
            }
        }
    }
    assert!(refused > 1000, "{refused}");
}

/// Numbers that are as large as they can be must not overflow.
#[test]
fn largest_numbers_are_refused_or_safe() {
    let mut refused = 0;
    for volume in volumes() {
        let bytes = bytes_of(&volume);
        for at in (32..bytes.len().min(800) - 4).step_by(4) {
            for number in [i32::MAX as u32, u32::MAX] {
                let mut changed = bytes.clone();
                changed[at..at + 4].copy_from_slice(&number.to_le_bytes());
                repair(&mut changed);
                refused += usize::from(VolumeFile::from_bytes(&changed, "large").is_err());
            }
        }
    }
    assert!(refused > 50, "{refused}");
}

/// Returns a file of sparse bricks in a wide box, with other cubes far inside the solid.
fn with_cubes(cubes: &[[i32; 4]]) -> Vec<u8> {
    let volume = &volumes()[4];
    let mut bytes = bytes_of(volume);
    let sections = (0..8).map(|i| 32 + 32 * i);
    let entry_of = |name: &[u8]| sections.clone().find(|&at| bytes[at..at + 4] == *name);
    let [about, cubes_entry] = [b"DESC", b"FARS"].map(|name| entry_of(name).expect("a section"));
    let description =
        u32::from_le_bytes(bytes[about + 8..about + 12].try_into().expect("four")) as usize;
    for axis in 0..3 {
        let at = description + 4 * (7 + axis);
        bytes[at..at + 4].copy_from_slice(&(1u32 << 22).to_le_bytes());
    }
    bytes.resize(bytes.len().next_multiple_of(64), 0);
    let offset = bytes.len() as u64;
    for word in cubes.as_flattened() {
        bytes.extend(word.to_le_bytes());
    }
    let length = 16 * cubes.len() as u64;
    bytes[cubes_entry + 8..cubes_entry + 16].copy_from_slice(&offset.to_le_bytes());
    bytes[cubes_entry + 16..cubes_entry + 24].copy_from_slice(&length.to_le_bytes());
    let size = bytes.len() as u64;
    bytes[16..24].copy_from_slice(&size.to_le_bytes());
    repair(&mut bytes);
    bytes
}

/// Cubes of 16 bytes each, far from one another, cannot make a table of gigabytes.
#[test]
fn tables_are_limited_by_the_size_of_the_file() {
    let few: Vec<[i32; 4]> = (0..40).map(|i| [512 * i + 64, 4096, 4096, 1]).collect();
    let stored = VolumeFile::from_bytes(&with_cubes(&few), "few").expect("a volume");
    let Volume::Bricks(bricks) = stored.volume else {
        panic!("bricks");
    };
    let mut found = Vec::new();
    bricks
        .table()
        .for_each_far_inside(|low, high| found.push([low.x, high.x - low.x]));
    found.sort_unstable();
    assert!(
        few.iter().all(|&[x, .., side]| found.contains(&[x, side])),
        "{found:?}"
    );
    let many: Vec<[i32; 4]> = (0..40_000)
        .map(|i| [512 * (i % 200) + 64, 512 * (i / 200), 4096, 1])
        .collect();
    let reason = |cubes: &[[i32; 4]]| {
        let read = VolumeFile::from_bytes(&with_cubes(cubes), "many");
        read.err()
            .map_or_else(String::new, |error| error.to_string())
    };
    // At the first cube that is too much, before the others are in memory.
    let refused = reason(&many);
    assert!(
        refused.contains("FARS") && refused.contains("too large for the file"),
        "{refused}"
    );
    // Neither twice, nor one in another, in any order.
    for (a, b) in [(1, 1), (8, 1), (1, 8), (512, 1), (1 << 18, 1 << 18)] {
        let overlap = [[0, 0, 0, a], [0, 0, 0, b]];
        assert!(reason(&overlap).contains("overlap"), "{a} {b}");
    }
    assert_eq!(reason(&[[0, 0, 0, 8], [8, 0, 0, 8], [16, 0, 0, 1]]), "");
}

/// Corrects all checksums.
fn repair(bytes: &mut [u8]) {
    let word = |b: &[u8], at: usize| u32::from_le_bytes([b[at], b[at + 1], b[at + 2], b[at + 3]]);
    let count = (word(bytes, 12) as usize).min(32);
    for entry in (0..count).map(|i| 32 + 32 * i) {
        if entry + 32 > bytes.len() {
            return;
        }
        let (offset, size) = (
            word(bytes, entry + 8) as usize,
            word(bytes, entry + 16) as usize,
        );
        if let Some(part) = bytes.get(offset..offset.saturating_add(size)) {
            let crc = crc32fast::hash(part).to_le_bytes();
            bytes[entry + 4..entry + 8].copy_from_slice(&crc);
        }
    }
    let mut crc = crc32fast::Hasher::new();
    crc.update(&bytes[..24]);
    crc.update(&bytes[32..32 + 32 * count]);
    bytes[24..28].copy_from_slice(&crc.finalize().to_le_bytes());
}
