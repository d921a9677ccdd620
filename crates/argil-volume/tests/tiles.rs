//! Tiles: what they hold is what is baked without them.

use argil_field::Program;
use argil_math::Control;
use argil_scene::{Brush, Material, Modifier, Scene, Shape};
use argil_volume::{
    BrickSettings, Encoding, Levels, LevelsLayout, SampleFormat, TIER_LEVELS, Tile, TileAddress,
    TileBaker, TileError, TileHead, TileSource, TileState, VoxelGrid,
};
use glam::Vec3;
use rustc_hash::FxHashMap;
use std::sync::Arc;

const WORLD: [u8; 32] = [7; 32];

/// Ground with noise, a polished sphere that blends into it, and a ring of posts.
fn scene() -> Scene {
    let mut scene = Scene::new();
    let mut material = |name: &str, color| {
        let own = Material {
            base_color: color,
            ..Material::default()
        };
        scene.set_material(name, own).expect("a valid material");
    };
    material("soil", [0.3, 0.2, 0.1]);
    material("gold", [0.9, 0.7, 0.2]);
    let rough = Modifier::Displace {
        amplitude: 0.08,
        frequency: 3.0,
        seed: 4,
        octaves: 3,
    };
    let ground = Brush::new(Shape::cuboid([2.0, 0.2, 2.0])).with_material("soil");
    scene.push(ground.with_modifier(rough)).expect("ground");
    let sphere = Brush::new(Shape::sphere(0.5)).at([0.3, 0.4, 0.2]);
    scene
        .push(sphere.smooth(0.2).with_material("gold"))
        .expect("a sphere");
    let post = Brush::new(Shape::cylinder(0.05, 0.5)).at([1.2, 0.5, 0.0]);
    let ring = post.with_modifier(Modifier::RadialRepeat { count: 9 });
    scene.push(ring).expect("posts");
    scene
}

fn layout(program: &Program, resolution: u32, format: SampleFormat) -> LevelsLayout {
    let grid = VoxelGrid::fitting(program.aabb(), None, resolution).expect("a grid");
    let encoding = Encoding {
        format,
        ..Encoding::default()
    };
    let settings = BrickSettings {
        encoding,
        ..BrickSettings::default()
    };
    LevelsLayout::new(grid, &settings).expect("levels")
}

fn all_tiles(baker: &TileBaker<'_>) -> FxHashMap<TileAddress, Arc<Tile>> {
    let candidates = baker.candidates(&Control::default());
    let baked = candidates.iter().map(|&address| {
        let bytes = baker.bake(address).to_bytes(&WORLD);
        let tile = Tile::from_bytes(&bytes, &WORLD, address, baker.layout());
        (address, Arc::new(tile.expect("what was written")))
    });
    baked.collect()
}

#[test]
fn levels_from_tiles_are_those_from_the_field() {
    let program = Program::lower(&scene()).expect("a program");
    for (resolution, format) in [
        (600, SampleFormat::Snorm16),
        (300, SampleFormat::Snorm8),
        (100, SampleFormat::Snorm16),
    ] {
        let layout = layout(&program, resolution, format);
        let baker = TileBaker::new(&program, layout);
        let tiles = all_tiles(&baker);
        // All tiles that exist are candidates, and each names those below it.
        for tile in tiles.values() {
            for finer in tile.finer_tiles() {
                assert_eq!(finer.coarser(), Some(tile.address()));
                assert!(tiles[&finer].page_count() > 0, "{finer}");
            }
        }
        let bake = |source: Option<Arc<dyn TileSource>>| {
            let mut levels = Levels::bake(&program, layout, 1 << 30).expect("levels");
            let is_strict = source.is_some();
            if let Some(source) = source {
                levels.set_source(source, &program, !is_strict);
            }
            let done = levels.refine_around(&program, Vec3::new(0.5, 1.0, 2.0), 1e-6);
            assert!(!done.is_full && done.missing == 0, "{done:?}");
            levels
        };
        let (own, stored) = (bake(None), bake(Some(Arc::new(tiles.clone()))));
        assert!(own.brick_count() > 100 && own == stored, "{resolution}");
        let bricks: usize = tiles.values().map(|tile| tile.brick_count()).sum();
        assert_eq!(bricks as u64, own.brick_count(), "{resolution}");
    }
}

/// Conservative: without a tile, rays see what is coarser, and the report counts it.
#[test]
fn missing_tiles_leave_what_is_coarser() {
    let program = Program::lower(&scene()).expect("a program");
    let layout = layout(&program, 512, SampleFormat::Snorm16);
    let baker = TileBaker::new(&program, layout);
    let mut tiles = all_tiles(&baker);
    let finest: Vec<TileAddress> = tiles.keys().copied().filter(|own| own.tier == 0).collect();
    tiles.retain(|own, _| own.tier > 0);
    let mut levels = Levels::bake(&program, layout, 1 << 30).expect("levels");
    levels.set_source(Arc::new(tiles.clone()), &program, false);
    let point = Vec3::new(0.3, 0.9, 0.2);
    let mut missing = 0;
    for _ in 0..20 {
        levels.request(0, point);
        missing += levels.fill(&program, None).missing;
    }
    assert!(missing > 0 && !finest.is_empty());
    assert!(
        levels.resident_bricks()[..5]
            .iter()
            .all(|&bricks| bricks == 0)
    );
    // From the field where the store has nothing.
    levels.set_source(Arc::new(tiles), &program, true);
    while levels.request(0, point) {
        assert_eq!(levels.fill(&program, None).missing, 0);
    }
    assert!(levels.resident_bricks()[0] > 0);
}

#[derive(Debug)]
struct Never;

impl TileSource for Never {
    fn tile(&self, _: TileAddress, _: u32) -> TileState {
        TileState::Pending
    }
}

#[test]
fn pending_tiles_are_asked_for_again() {
    let program = Program::lower(&scene()).expect("a program");
    let layout = layout(&program, 512, SampleFormat::Snorm16);
    let mut levels = Levels::bake(&program, layout, 1 << 30).expect("levels");
    levels.set_source(Arc::new(Never), &program, true);
    assert!(levels.request(0, Vec3::new(0.3, 0.9, 0.2)));
    let done = levels.fill(&program, None);
    assert_eq!((done.pending, done.bricks, done.missing), (1, 0, 0));
}

/// Negative control: nothing that was damaged or exchanged is read, and nothing panics.
#[test]
fn damaged_tiles_are_refused() {
    let program = Program::lower(&scene()).expect("a program");
    let layout = layout(&program, 512, SampleFormat::Snorm16);
    let baker = TileBaker::new(&program, layout);
    let candidates = baker.candidates(&Control::default());
    let full = candidates
        .iter()
        .find(|&&own| own.tier == 0 && baker.bake(own).brick_count() > 0);
    let address = *full.expect("a tile with bricks");
    let bytes = baker.bake(address).to_bytes(&WORLD);
    let read = |bytes: &[u8]| Tile::from_bytes(bytes, &WORLD, address, &layout);
    assert!(read(&bytes).is_ok());
    let other = TileAddress { tier: 1, ..address };
    let found = Tile::from_bytes(&bytes, &WORLD, other, &layout);
    assert!(matches!(found, Err(TileError::Other(_))), "{found:?}");
    let found = Tile::from_bytes(&bytes, &[8; 32], address, &layout);
    assert!(matches!(found, Err(TileError::Other(_))), "{found:?}");
    for cut in [0, 1, 50, TileHead::BYTES, bytes.len() / 2, bytes.len() - 1] {
        assert!(
            matches!(read(&bytes[..cut]), Err(TileError::Length { .. })),
            "{cut}"
        );
    }
    let longer = [&bytes[..], &[0]].concat();
    assert!(matches!(read(&longer), Err(TileError::Length { .. })));
    for at in (0..bytes.len()).step_by(bytes.len() / 100 + 1) {
        let mut wrong = bytes.clone();
        wrong[at] ^= 1 << (at % 8);
        assert!(read(&wrong).is_err(), "byte {at}");
    }
    // With checksums that are right, contents that are wrong are refused, or at least read without a panic.
    let head = TileHead::from_bytes(&bytes, &WORLD, address, &layout).expect("a head");
    let mut refused = 0;
    for at in (64..bytes.len()).step_by(bytes.len() / 300 + 1) {
        let mut wrong = bytes.clone();
        wrong[at] ^= 0x5a;
        repair(&mut wrong, &head);
        refused += u32::from(read(&wrong).is_err());
    }
    assert!(refused > 20, "{refused}");
}

/// Corrects all checksums of a tile.
fn repair(bytes: &mut [u8], head: &TileHead) {
    for level in 0..TIER_LEVELS {
        let [begin, end] = [level + 1, level].map(|level| head.bytes_to(level) as usize);
        let own = blake3::hash(&bytes[begin..end]);
        let index = (TIER_LEVELS - 1 - level) as usize;
        bytes[64 + 32 * index + 16..][..16].copy_from_slice(&own.as_bytes()[..16]);
    }
    let end = TileHead::BYTES;
    let own = blake3::hash(&bytes[..end - 32]);
    bytes[end - 32..end].copy_from_slice(own.as_bytes());
}

/// Numbers that would name what is not there are refused, although all checksums are right.
#[test]
fn tiles_name_nothing_that_is_not_theirs() {
    let program = Program::lower(&scene()).expect("a program");
    let layout = layout(&program, 512, SampleFormat::Snorm8);
    let baker = TileBaker::new(&program, layout);
    let candidates = baker.candidates(&Control::default());
    let full = candidates.iter().find(|&&own| own.tier == 0);
    let address = *full.expect("a tile");
    let bytes = baker.bake(address).to_bytes(&WORLD);
    let head = TileHead::from_bytes(&bytes, &WORLD, address, &layout).expect("a head");
    let word = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|i| bytes[at + i]));
    let reason = |at: usize, value: u32| {
        let mut wrong = bytes.clone();
        wrong[at..at + 4].copy_from_slice(&value.to_le_bytes());
        repair(&mut wrong, &head);
        let found = Tile::from_bytes(&wrong, &WORLD, address, &layout);
        found
            .err()
            .map_or_else(String::new, |error| error.to_string())
    };
    // The finest level: kinds of cells, words of those without a brick, and materials.
    let index = TIER_LEVELS as usize - 1;
    let [pages, bricks] = [0, 4].map(|at| word(64 + 32 * index + at) as usize);
    let begin = head.bytes_to(1) as usize;
    let words = begin + 8 * pages;
    let materials = words + 4 * (8 * pages - bricks);
    assert!(bricks > 0 && materials > words);
    for wrong in [0, 5, 0x7fff_ffff, 0x8000_0001, 0xbfff_fffe, 0xbfc0_0000] {
        assert!(
            reason(words, wrong).ends_with("the distance of a cell"),
            "{wrong:x}"
        );
    }
    for wrong in [0x8000_ffff, u32::MAX] {
        assert!(reason(materials, wrong).ends_with("the material of a brick"));
    }
    assert!(reason(64 + 32 * index + 12, u32::MAX).ends_with("the counts"));
    // A level without pages, although cells are refined to it.
    let mut wrong = bytes[..begin].to_vec();
    wrong[64 + 32 * index..][..16].fill(0);
    let end = TileHead::BYTES;
    let own = blake3::hash(&wrong[..end - 32]);
    wrong[end - 32..end].copy_from_slice(own.as_bytes());
    let found = Tile::from_bytes(&wrong, &WORLD, address, &layout);
    assert!(matches!(found, Err(TileError::Contents(_))));
}

/// A tile whose levels come one after another is the one that was read at once. What is damaged is seen at its level.
#[test]
fn tiles_are_read_level_by_level() {
    let program = Program::lower(&scene()).expect("a program");
    let layout = layout(&program, 600, SampleFormat::Snorm16);
    let baker = TileBaker::new(&program, layout);
    let mut bytes_to = [0; TIER_LEVELS as usize];
    for address in baker.candidates(&Control::default()) {
        let whole = baker.bake(address);
        let bytes = whole.to_bytes(&WORLD);
        let head = TileHead::from_bytes(&bytes, &WORLD, address, &layout).expect("a head");
        assert_eq!(head.total_bytes(), bytes.len() as u64);
        let mut tile = Tile::of_head(&head);
        let mut at = TileHead::BYTES;
        for level in (address.finest_level()..=address.top_level(&layout)).rev() {
            let end = head.bytes_to(level) as usize;
            bytes_to[(level - address.finest_level()) as usize] += end;
            let mut wrong = bytes[at..end].to_vec();
            if let Some(last) = wrong.last_mut() {
                assert!(!tile.holds(level));
                *last ^= 1;
                assert_eq!(tile.read_levels(&head, &wrong), Err(TileError::Checksum));
                // Too few bytes for a level.
                assert_eq!(tile.read_levels(&head, &bytes[at..end - 1]), Ok(()));
                assert!(!tile.holds(level));
            }
            assert_eq!(tile.read_levels(&head, &bytes[at..end]), Ok(()));
            assert!(tile.holds(level));
            at = end;
        }
        assert_eq!(tile, whole, "{address}");
    }
    // Coarse levels are a small part of all bytes.
    assert!(8 * bytes_to[2] < bytes_to[0], "{bytes_to:?}");
}

#[test]
fn addresses_are_text() {
    for address in [
        TileAddress {
            tier: 0,
            place: [0, -3, 12],
        },
        TileAddress {
            tier: 3,
            place: [i32::MIN, i32::MAX, 0],
        },
    ] {
        assert_eq!(address.to_string().parse(), Ok(address));
    }
    for text in [
        "",
        "0",
        "0/1_2",
        "0/1_2_3_4",
        "0/a_2_3",
        "-1/1_2_3",
        "0/1_2_99999999999",
    ] {
        assert!(text.parse::<TileAddress>().is_err(), "{text}");
    }
}
