//! Grids that are written come back, and damaged files give errors.

use argil_vdb::nvdb::{self, NanoType};
use argil_vdb::vdb::{self, VdbFile, VdbWriter, WriteOptions};
use argil_vdb::{
    AnyGrid, Codec, Grid, GridClass, GridHeader, Leaf, MetaValue, RootTile, Transform, Tree, Voxel,
};
use proptest::prelude::*;
use std::io::Cursor;

/// A level set of a sphere around the origin, which eight upper nodes share, and a second part far away.
fn sphere() -> Grid<f32> {
    let (radius, band) = (20.5f32, 3.0f32);
    let mut leaves = Vec::new();
    for center in [[0, 0, 0], [5000, -9000, 40]] {
        for at in 0..6 * 6 * 6 {
            let origin = [0, 1, 2].map(|axis| {
                let across = [at / 36, at / 6 % 6, at % 6][axis];
                center[axis] + 8 * (across - 3)
            });
            let mut leaf = Leaf::new(origin, band);
            for i in 0..512 {
                let inner = [i / 64, i / 8 % 8, i % 8];
                let index = [0, 1, 2].map(|axis| leaf.origin[axis] + inner[axis]);
                let square: i32 = (0..3).map(|axis| (index[axis] - center[axis]).pow(2)).sum();
                let distance = (square as f32).sqrt() - radius;
                if distance.abs() < band {
                    leaf.set(index, distance);
                }
            }
            if !leaf.active.is_empty() {
                leaves.push(leaf);
            }
        }
    }
    let mut tree = Tree::from_leaves(band, leaves);
    tree.flood_signs();
    let transform = Transform::uniform(0.25, [0.5, -1.0, 2.0]);
    let mut header = GridHeader::new("surface", GridClass::LevelSet, transform);
    header.metadata = vec![("author".into(), MetaValue::String("nobody".into()))];
    Grid::new(header, tree)
}

fn colors() -> Grid<[f32; 3]> {
    let mut tree = Tree::new([0.0; 3]);
    let mut leaf = Leaf::new([8, 8, 8], [0.0; 3]);
    leaf.set([9, 10, 11], [1.0, 0.5, 0.25]);
    leaf.set([15, 15, 15], [0.0, 1.0, 0.0]);
    tree.uppers = Tree::from_leaves([0.0; 3], vec![leaf]).uppers;
    tree.uppers[0].active.set(77, true);
    tree.uppers[0].tiles[77] = [0.25; 3];
    tree.tiles.push(RootTile {
        origin: [8192, 0, 0],
        value: [0.5; 3],
        is_active: true,
    });
    let header = GridHeader::new("Cd", GridClass::Unknown, Transform::uniform(1.0, [0.0; 3]));
    Grid::new(header, tree)
}

fn written(grids: &[AnyGrid], codec: Codec, is_half: bool) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let options = WriteOptions {
        codec,
        is_half,
        ..WriteOptions::default()
    };
    vdb::write(&mut out, grids, &options).expect("bytes");
    out.into_inner()
}

#[test]
fn the_inside_has_its_sign() {
    let tree = sphere().tree;
    // In a leaf, in tiles of both kinds of nodes, outside, and between the two spheres.
    assert_eq!(tree.value([17, 0, 0]), -3.0);
    assert_eq!(tree.value([0, 0, 0]), -3.0);
    assert_eq!(tree.value([5000, -9000, 40]), -3.0);
    for outside in [
        [30, 0, 0],
        [100, 100, 100],
        [2000, -3000, 20],
        [5000, -9000, 400],
    ] {
        assert_eq!(tree.value(outside), 3.0, "{outside:?}");
    }
    let far = tree.value_and_state([20, 0, 0]);
    assert_eq!(far, (-0.5, true));
}

/// Between two upper nodes of one column, the inside continues in tiles of the root.
#[test]
fn the_inside_of_a_long_solid_has_its_sign() {
    let leaf = |z: i32, value: f32| {
        let mut leaf = Leaf::new([0, 0, z], 3.0);
        leaf.values.fill(value);
        leaf.active = argil_vdb::Mask([u64::MAX; 8]);
        leaf
    };
    for (value, inside) in [(-1.0, -3.0), (1.0, 3.0)] {
        let mut tree = Tree::from_leaves(3.0, vec![leaf(0, value), leaf(12_288, value)]);
        tree.flood_signs();
        for z in [4096, 5000, 12_000] {
            assert_eq!(tree.value([0, 0, z]), inside, "{z}");
        }
    }
}

#[test]
fn grids_come_back_bit_for_bit() {
    let all: [AnyGrid; 3] = [sphere().into(), colors().into(), sphere().into()];
    for codec in [Codec::None, Codec::Zip, Codec::Blosc] {
        let bytes = written(&all, codec, false);
        let file = VdbFile::parse(&bytes).expect("a file");
        assert_eq!(file.grids.len(), 3);
        for (i, grid) in all.iter().enumerate() {
            assert_eq!(&file.grid(i).expect("a grid"), grid, "{codec:?}");
        }
        // Half as many bits: rounded once, and then the same.
        let bytes = written(&all, codec, true);
        let halved = VdbFile::parse(&bytes)
            .expect("a file")
            .grid(0)
            .expect("a grid");
        let again = written(std::slice::from_ref(&halved), codec, true);
        let again = VdbFile::parse(&again)
            .expect("a file")
            .grid(0)
            .expect("a grid");
        assert_eq!(again, halved, "{codec:?}");
        let tree = &halved.as_float().expect("floats").tree;
        for (a, b) in tree.leaves().zip(sphere().tree.leaves()) {
            assert!(
                a.active == b.active
                    && a.values
                        .iter()
                        .zip(b.values.iter())
                        .all(|(a, b)| *a == b.rounded())
            );
        }
    }
}

#[test]
fn nodes_that_come_one_by_one_make_the_same_file() {
    let grid = sphere();
    let whole = written(&[grid.clone().into()], Codec::None, false);
    let mut out = Cursor::new(Vec::new());
    let mut file = VdbWriter::new(&mut out, 1, &WriteOptions::default()).expect("a file");
    let scratch = Cursor::new(Vec::new());
    let mut stream = file
        .stream(&grid.header, grid.tree.background, &[], scratch)
        .expect("a grid");
    for upper in &grid.tree.uppers {
        stream.upper(upper).expect("a node");
    }
    stream.finish().expect("a grid");
    file.finish().expect("a file");
    assert!(out.into_inner() == whole);
}

#[test]
fn announced_and_written_grids_are_compared() {
    let mut out = Cursor::new(Vec::new());
    let mut file = VdbWriter::new(&mut out, 1, &WriteOptions::default()).expect("a file");
    file.grid(&sphere()).expect("a grid");
    assert!(file.grid(&sphere()).is_err());
    let file =
        VdbWriter::new(Cursor::new(Vec::new()), 1, &WriteOptions::default()).expect("a file");
    assert!(file.finish().is_err());
}

fn nano(kind: NanoType) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    nvdb::write(&mut out, &sphere(), kind).expect("bytes");
    out.into_inner()
}

#[test]
fn nano_grids_come_back() {
    let grid = sphere();
    let back = nvdb::read(&nano(NanoType::Float))
        .expect("a grid")
        .remove(0);
    assert_eq!(back.tree, grid.tree);
    assert_eq!(
        (back.header.name.as_str(), back.header.class),
        ("surface", GridClass::LevelSet)
    );
    assert_eq!(back.header.transform, grid.header.transform);
    for (kind, most) in [
        (NanoType::Fp16, 6.0 / 65_535.0),
        (NanoType::Fp8, 6.0 / 255.0),
    ] {
        let back = nvdb::read(&nano(kind)).expect("a grid").remove(0);
        for (a, b) in back.tree.leaves().zip(grid.tree.leaves()) {
            assert_eq!((a.origin, &a.active), (b.origin, &b.active));
            for (a, b) in a.values.iter().zip(b.values.iter()) {
                assert!((a - b).abs() <= 0.501 * most, "{kind:?}: {a} for {b}");
            }
        }
    }
}

#[test]
fn other_files_are_refused() {
    let text = |error: argil_vdb::VdbError| error.to_string();
    for bytes in [&b""[..], b"PNG", &[0; 100]] {
        assert!(text(VdbFile::parse(bytes).expect_err("no file")).contains("not a VDB file"));
        assert!(text(nvdb::read(bytes).expect_err("no file")).contains("not a NanoVDB file"));
    }
    let mut old = written(&[sphere().into()], Codec::None, false);
    old[8] = 200;
    assert!(text(VdbFile::parse(&old).expect_err("an old file")).contains("version 200"));
    let bytes = written(&[colors().into()], Codec::None, false);
    let file = VdbFile::parse(&bytes).expect("a file");
    assert!(text(file.float_grid(None).expect_err("no floats")).contains("Cd"));
    // A bit of the head changes its checksum.
    let mut bytes = nano(NanoType::Float);
    bytes[16 + 176 + 8 + 45] ^= 1;
    assert!(text(nvdb::read(&bytes).expect_err("damaged")).contains("checksum"));
}

#[test]
fn files_that_end_early_are_refused() {
    let bytes = written(&[sphere().into()], Codec::Blosc, false);
    let nano = nano(NanoType::Fp8);
    for part in 0..200 {
        let cut = |bytes: &[u8]| bytes[..bytes.len() * part / 200].to_vec();
        let truncated = cut(&bytes);
        assert!(
            VdbFile::parse(&truncated)
                .and_then(|file| file.grid(0))
                .is_err(),
            "{part}"
        );
        assert!(nvdb::read(&cut(&nano)).is_err(), "{part}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// No change of bytes makes a reader panic.
    #[test]
    fn damaged_files_do_not_panic(
        places in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        codec in 0..3usize,
        head in any::<bool>(),
    ) {
        let codec = [Codec::None, Codec::Zip, Codec::Blosc][codec];
        let mut bytes = written(&[colors().into(), sphere().into()], codec, false);
        let mut nano = nano(NanoType::Fp16);
        // Without a checksum, so that more is read.
        nano[16 + 176 + 8 + 8..][..8].fill(0xff);
        for (place, value) in &places {
            for all in [&mut bytes, &mut nano] {
                let most = if head { all.len().min(2000) } else { all.len() };
                let at = place.index(most);
                all[at] = *value;
            }
        }
        if let Ok(file) = VdbFile::parse(&bytes) {
            for i in 0..file.grids.len() {
                let _ = file.grid(i);
            }
        }
        let _ = nvdb::read(&nano);
    }
}
