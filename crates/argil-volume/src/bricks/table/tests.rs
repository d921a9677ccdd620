use super::*;
use std::collections::HashMap;

/// Compares the table with a map: blocks and empty cubes are inserted and removed, from next to each other to a
/// million apart.
#[test]
fn a_table_is_a_map_of_blocks() {
    let mut seed = 7u64;
    let mut next = |n: i32| {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((seed >> 33) % (2 * n as u64 + 1)) as i32 - n
    };
    for spread in [3, 20, 300, 500_000] {
        let mut table = BlockTable::new(IVec3::ZERO, IVec3::splat(4));
        let mut known: HashMap<[i32; 3], Option<u32>> = HashMap::new();
        let mut inside: Vec<(IVec3, IVec3, bool)> = Vec::new();
        for turn in 0..600 {
            let block = IVec3::new(next(spread), next(spread), next(spread));
            match turn % 4 {
                0 | 1 => {
                    let slot = table.insert(block);
                    assert!(slot >= FAR_SLOTS);
                    let others = known.values().flatten().filter(|s| **s == slot).count();
                    let own = known.insert(block.to_array(), Some(slot)).flatten();
                    assert_eq!(others, usize::from(own.is_some()));
                }
                2 => {
                    let old = *known.keys().nth(turn % known.len()).expect("a block");
                    table.remove(old.into(), turn % 8 == 2);
                    known.insert(old, None);
                }
                _ => {
                    let high = block + IVec3::new(1, 2, 3);
                    table.set_far(block, high, turn % 8 == 3);
                    inside.push((block, high, turn % 8 == 3));
                    for (at, slot) in &mut known {
                        let at = IVec3::from_array(*at);
                        if at.cmpge(block).all() && at.cmplt(high).all() {
                            *slot = None;
                        }
                    }
                }
            }
            for (at, slot) in &known {
                assert_eq!(table.find((*at).into()), *slot, "{at:?} of {spread}");
            }
        }
        assert_eq!(table.len(), known.values().flatten().count());
        let there = table.blocks().count();
        assert_eq!(there, table.len());
        assert!(table.entries().len() < 1 << 22);
    }
}

#[test]
fn what_is_far_inside_stays_so_as_the_table_grows() {
    let mut table = BlockTable::new(IVec3::ZERO, IVec3::splat(30));
    table.set_far(IVec3::splat(4), IVec3::splat(20), true);
    let one = table.insert(IVec3::splat(7));
    for far in [40, 500, 100_000] {
        table.insert(IVec3::new(-far, far, far));
        assert_eq!(table.find(IVec3::splat(7)), Some(one));
        assert_eq!(table.slot(IVec3::new(4, 4, 4)) & 1, 1);
        assert_eq!(table.slot(IVec3::new(19, 7, 7)) & 1, 1);
        assert_eq!(table.slot(IVec3::new(20, 7, 7)) & 1, 0);
        assert_eq!(table.slot(IVec3::new(-far, far, far + 9)) & 1, 0);
    }
    assert!(table.levels() > 1);
    assert!(table.entries().len() < 1 << 17);
}
