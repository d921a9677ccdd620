//! The table of targets.

use crate::{scenes, seeds, worlds};
use argil::{RawLayout, VolumeReadOptions, read_volume_bytes};
use argil_mesh::{MeshFormat, MeshSdf, from_bytes};
use argil_volume::{Volume, VolumeFile};
use std::io::{Cursor, Write};
use std::path::Path;

/// A reader of files.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name, as the command takes it.
    pub name: &'static str,
    /// Reads bytes. Whatever they are, there is a result or an error.
    pub run: fn(&[u8]),
    /// Makes files that can be read.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Bytes of memory that any input may take, besides 64 per byte.
    pub floor_bytes: usize,
}

/// What small files may take: tables of decoders, and stacks of threads.
const FLOOR: usize = 32 << 20;
/// What the largest image takes, whatever the size of its file: its pixels may be all one color.
const IMAGE_FLOOR: usize = 2 << 30;

const fn target(name: &'static str, run: fn(&[u8]), seeds: fn() -> Vec<Vec<u8>>) -> Target {
    Target {
        name,
        run,
        seeds,
        floor_bytes: FLOOR,
    }
}

/// All targets. A reader of files or of the network has a row.
pub const TARGETS: &[Target] = &[
    target(
        "glb",
        |bytes| mesh(bytes, MeshFormat::Glb),
        || seeds::meshes(MeshFormat::Glb),
    ),
    target("gltf", |bytes| mesh(bytes, MeshFormat::Gltf), seeds::gltf),
    target("obj", |bytes| mesh(bytes, MeshFormat::Obj), seeds::obj),
    target("ply", |bytes| mesh(bytes, MeshFormat::Ply), seeds::ply),
    target("stl", |bytes| mesh(bytes, MeshFormat::Stl), seeds::stl),
    target(
        "3mf",
        |bytes| mesh(bytes, MeshFormat::ThreeMf),
        || seeds::meshes(MeshFormat::ThreeMf),
    ),
    target("3mf_model", three_mf_model, seeds::three_mf_model),
    Target {
        floor_bytes: IMAGE_FLOOR,
        ..target("image", scenes::image, seeds::images)
    },
    Target {
        floor_bytes: IMAGE_FLOOR,
        ..target("heightmap", scenes::heightmap, seeds::images)
    },
    target("scene", scenes::scene, scenes::seeds),
    target("journal", scenes::journal, scenes::journals),
    target("volume_file", volume_file, seeds::volume_files),
    target(
        "vdb",
        |bytes| volume(bytes, "a.vdb"),
        || seeds::exports("vdb"),
    ),
    target(
        "nvdb",
        |bytes| volume(bytes, "a.nvdb"),
        || seeds::exports("nvdb"),
    ),
    target(
        "npy",
        |bytes| volume(bytes, "a.npy"),
        || seeds::exports("npy"),
    ),
    target(
        "nrrd",
        |bytes| volume(bytes, "a.nrrd"),
        || seeds::exports("nrrd"),
    ),
    target("raw", |bytes| volume(bytes, "a.raw"), || vec![vec![1; 480]]),
    target("tile", |bytes| ignore(worlds::tile(bytes)), worlds::tiles),
    target(
        "tile_levels",
        |bytes| ignore(worlds::tile_levels(bytes)),
        worlds::tiles,
    ),
    target(
        "manifest",
        |bytes| ignore(worlds::manifest(bytes)),
        worlds::manifests,
    ),
    target(
        "world_mesh",
        |bytes| ignore(worlds::mesh(bytes)),
        worlds::meshes,
    ),
    target(
        "delta",
        |bytes| ignore(worlds::delta(bytes)),
        worlds::deltas,
    ),
];

/// Targets that fail, to test the program that runs them.
pub const CONTROLS: &[Target] = &[
    target(
        "control-panic",
        |bytes| assert_ne!(bytes.len(), 3),
        || vec![vec![7; 8]],
    ),
    target(
        "control-memory",
        |bytes| drop(std::hint::black_box(vec![1u8; bytes.len() << 24])),
        || vec![vec![7; 8]],
    ),
    target(
        "control-slow",
        |_| std::thread::sleep(std::time::Duration::from_secs(60)),
        || vec![vec![7; 8]],
    ),
    target(
        "control-good",
        |bytes| drop(std::hint::black_box(bytes.to_vec())),
        || vec![vec![7; 8]],
    ),
];

/// Whether bytes are accepted does not matter.
fn ignore(_: bool) {}

fn mesh(bytes: &[u8], format: MeshFormat) {
    let Ok(file) = from_bytes(bytes, format, Path::new("a")) else {
        return;
    };
    // What is read must be safe to use. Few triangles, so that there are many inputs.
    if file.mesh.triangles.len() < 2000 {
        let _ = MeshSdf::new(&file.mesh);
    }
}

/// Reads XML as the model of a 3MF file: random bytes are no archive.
fn three_mf_model(bytes: &[u8]) {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let how =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    let written = archive
        .start_file("3D/3dmodel.model", how)
        .and_then(|()| Ok(archive.write_all(bytes)?));
    if let (Ok(()), Ok(file)) = (written, archive.finish()) {
        mesh(file.get_ref(), MeshFormat::ThreeMf);
    }
}

fn volume(bytes: &[u8], name: &str) {
    let options = VolumeReadOptions {
        is_fog: bytes
            .len()
            .is_multiple_of(2)
            .then_some(bytes.len().is_multiple_of(4)),
        raw: RawLayout {
            shape: Some([4, 5, 6]),
            ..RawLayout::default()
        },
        ..VolumeReadOptions::default()
    };
    let _ = read_volume_bytes(bytes, Path::new(name), &options);
}

/// Reads a volume file, whose checksums are made right first: nothing behind them would ever be reached.
fn volume_file(bytes: &[u8]) {
    let mut bytes = bytes.to_vec();
    repair(&mut bytes);
    let Ok(stored) = VolumeFile::from_bytes(&bytes, "fuzz") else {
        return;
    };
    let center = stored.volume.voxel_grid().aabb().center();
    match &stored.volume {
        Volume::Dense(dense) => {
            for level in 0..dense.levels().len() as u32 {
                assert!(dense.distance(level, center).is_some());
            }
        }
        Volume::Bricks(bricks) => {
            assert!(!bricks.distance(center).is_nan() || !bricks.is_empty());
        }
        Volume::Octree(octree) => {
            assert!(octree.tree().check(octree.layout()).is_none());
            for (i, cell) in octree.cells().enumerate() {
                assert_eq!(octree.tree().find(cell).brick, Some(i as u32));
            }
        }
        Volume::Levels(_) => panic!("levels have no file"),
    }
}

fn repair(bytes: &mut [u8]) {
    let word = |b: &[u8], at: usize| {
        let four = b.get(at..at + 4).and_then(|b| b.try_into().ok());
        u32::from_le_bytes(four.unwrap_or_default()) as usize
    };
    let count = word(bytes, 12).min(32);
    if bytes.len() < 32 + 32 * count {
        return;
    }
    for entry in (0..count).map(|i| 32 + 32 * i) {
        let (offset, size) = (word(bytes, entry + 8), word(bytes, entry + 16));
        if let Some(part) = bytes.get(offset..offset + size) {
            let crc = crc32fast::hash(part).to_le_bytes();
            bytes[entry + 4..entry + 8].copy_from_slice(&crc);
        }
    }
    let mut crc = crc32fast::Hasher::new();
    crc.update(&bytes[..24]);
    crc.update(&bytes[32..32 + 32 * count]);
    bytes[24..28].copy_from_slice(&crc.finalize().to_le_bytes());
}
