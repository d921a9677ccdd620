//! The WGSL that evaluates three points of a column at once: column.wgsl, with shapes that read four parameters at a time.

use crate::OpcodeSet;
use crate::dispatch::{op, wgsl_function};
use argil_abi::BRUSH_HEADER_WORDS;
use std::fmt::Write;

/// The most slots of the stack of values: three numbers each, in registers.
pub(crate) const MAX_SLOTS: u32 = 4;

/// The shapes that are measured for three points at once, the most common first. More would need more registers.
pub(crate) const SHAPES: [u32; 7] = [
    op::Sphere,
    op::Box,
    op::Cylinder,
    op::Capsule,
    op::Torus,
    op::RoundCone,
    op::Plane,
];

/// Those of them whose points share most of their work where they are only translated.
pub(crate) const QUICK: [u32; 2] = [op::Sphere, op::Box];

/// Returns the constants of lists for three points: the shapes among some opcodes, and the slots of a stack that is no longer
/// than another.
pub(crate) fn list_constants(opcodes: OpcodeSet, stack_slots: u32) -> String {
    let bits = |shapes: &[u32]| {
        let used = shapes.iter().filter(|&&op| opcodes.contains(op));
        used.fold(0u32, |bits, op| bits | 1 << op)
    };
    let (all, quick) = (bits(&SHAPES), bits(&QUICK));
    let slots = stack_slots.min(MAX_SLOTS);
    format!(
        "const COLUMN_SHAPES: u32 = {all}u;\nconst QUICK_SHAPES: u32 = {quick}u;\nconst COLUMN_SLOTS: u32 = {slots}u;\n"
    )
}

/// Returns the WGSL, for some opcodes, or `None` if they have none of the shapes.
pub(crate) fn column_wgsl(opcodes: OpcodeSet, stack_slots: u32) -> Option<String> {
    let mut text = list_constants(opcodes, stack_slots);
    text += include_str!("scalar.wgsl");
    text += &with_records(include_str!("shapes.wgsl"), BRUSH_HEADER_WORDS as usize);
    text += &with_records(function(include_str!("domain_ops.wgsl"), "mapped"), 0);
    text += &chain("measure_column", &SHAPES, opcodes)?;
    text += &chain("measure_quickly", &QUICK, opcodes).unwrap_or_else(|| NO_QUICK.to_owned());
    text += include_str!("column.wgsl");
    Some(text)
}

/// What stands for the function where none of its shapes is used.
const NO_QUICK: &str =
    "fn measure_quickly(op: u32, p: Column, w: u32) -> vec3<f32> { return vec3(FAR); }\n";

/// Returns a function that compares an opcode with those of shapes, in their order, or `None` if none of them is used.
fn chain(name: &str, shapes: &[u32], opcodes: OpcodeSet) -> Option<String> {
    let used: Vec<u32> = shapes
        .iter()
        .copied()
        .filter(|&op| opcodes.contains(op))
        .collect();
    let (&last, first) = used.split_last()?;
    let each = |op: u32| {
        let name = wgsl_function(op);
        format!("{{ d = vec3({name}(p.a, w), {name}(p.b, w), {name}(p.c, w)); }}")
    };
    let tests = first
        .iter()
        .map(|&op| format!("if op == {op}u {} else ", each(op)));
    let tests: String = tests.collect();
    Some(format!(
        "fn {name}(op: u32, p: Column, w: u32) -> vec3<f32> {{\n    var d: vec3<f32>;\n    {tests}{}\n    return d;\n}}\n",
        each(last)
    ))
}

/// Returns a function of a module, from its name to its end.
fn function<'a>(module: &'a str, name: &str) -> &'a str {
    let begin = module.find(&format!("fn {name}(")).unwrap_or(0);
    let length = module[begin..].find("\n}\n").map(|end| end + 3);
    &module[begin..][..length.unwrap_or(0)]
}

/// Lets functions read records instead of parameters, which begin at a word of the first record: `params[w + 6u]` becomes
/// `records[w + 1u].z` if they begin at word 0.
fn with_records(text: &str, begin: usize) -> String {
    let mut parts = text.split("params[w");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (offset, rest) = part.split_once(']').unwrap_or((part, ""));
        let word = offset.trim_start_matches(" + ").trim_end_matches('u');
        let word = begin + word.parse::<usize>().unwrap_or(0);
        let _ = match word / 4 {
            0 => write!(out, "records[w]"),
            record => write!(out, "records[w + {record}u]"),
        };
        let _ = write!(out, ".{}{rest}", ["x", "y", "z", "w"][word % 4]);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_become_parts_of_records() {
        let text = "fn f(w: u32) -> f32 { return params[w] + params[w + 3u] * params[w + 10u]; }";
        let expected =
            "fn f(w: u32) -> f32 { return records[w].x + records[w].w * records[w + 2u].z; }";
        assert_eq!(with_records(text, 0), expected);
        let later = with_records("params[w + 1u]", 18);
        assert_eq!(later, "records[w + 4u].w");
        let all = column_wgsl(OpcodeSet::ALL, 32).expect("common shapes");
        assert!(!all.contains("params["), "{all}");
        assert!(all.contains("fn mapped(p: vec3<f32>, w: u32)"));
        assert!(column_wgsl(OpcodeSet::default(), 2).is_none());
    }
}
