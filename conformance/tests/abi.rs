//! Tests the shared structs: the committed text, and every layout against naga's.

use naga::TypeInner;

#[test]
fn the_committed_wgsl_is_up_to_date() {
    let committed = include_str!("../../crates/argil-abi/src/abi.wgsl");
    assert!(committed == argil_abi::wgsl(), "run `cargo xtask generate`");
}

#[test]
fn naga_agrees_on_every_offset() {
    let module = naga::front::wgsl::parse_str(&argil_abi::wgsl()).expect("valid WGSL");
    let mut compared = 0;
    for layout in argil_abi::layouts() {
        let (_, found) = module
            .types
            .iter()
            .find(|(_, t)| t.name.as_deref() == Some(layout.name))
            .unwrap_or_else(|| panic!("{} is not in the WGSL", layout.name));
        let TypeInner::Struct { members, span } = &found.inner else {
            panic!("{} is no struct", layout.name)
        };
        assert_eq!(*span as usize, layout.size, "{}", layout.name);
        let offsets: Vec<_> = members
            .iter()
            .map(|m| (m.name.as_deref().unwrap_or(""), m.offset as usize))
            .collect();
        assert_eq!(offsets, layout.fields, "{}", layout.name);
        compared += offsets.len();
    }
    assert!(compared > 20);
    // Negative control: two fields swapped would not pass.
    let swapped: Vec<_> = argil_abi::Instruction::LAYOUT.fields.iter().rev().collect();
    assert_ne!(swapped[0].1, argil_abi::Instruction::LAYOUT.fields[0].1);
}
