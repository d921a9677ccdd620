//! Reading a volume file: whatever the bytes are, there is a volume or an error.
//!
//! Checksums are made right first, else nothing behind them would ever be reached.

#![no_main]

use argil_volume::{Volume, VolumeFile};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
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
            assert!(!bricks.distance(center).is_nan() || bricks.len() > 0);
        }
        // They have no file.
        Volume::Levels(_) => unreachable!("levels are not stored"),
        Volume::Octree(octree) => {
            assert!(octree.tree().check(octree.layout()).is_none());
            for (i, cell) in octree.cells().enumerate() {
                assert_eq!(octree.tree().find(cell).brick, Some(i as u32));
            }
        }
    }
});

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
