//! WGSL for one fixed program: its instructions written out, instead of the interpreter.
//!
//! The numbers stay in the table of parameters, so a brush can move without a new shader. The loop over
//! instructions, the selection by opcode and the stacks disappear.

use crate::dispatch::{wgsl_dispatch, wgsl_function};
use crate::interpreter_wgsl::{MATERIAL_SHIFT, PLAIN_MATERIALS, TEXTURES};
use crate::{OpcodeSet, Program, WGSL_COMMON};
use argil_abi::{self as abi, Instruction};
use std::fmt::Write;

/// Maximum length of a program to write out, because shader compilers take more than linear time.
const MAX_INSTRUCTIONS: usize = 4096;

impl Program {
    /// Returns the twin of [`crate::Interpreter::wgsl`] for this program alone, or `None` if it is too long.
    pub fn specialized_wgsl(&self) -> Option<String> {
        (self.instructions.len() <= MAX_INSTRUCTIONS).then(|| {
            WGSL_COMMON.to_owned() + MATERIAL_SHIFT + &self.material_wgsl() + &write_field(self)
        })
    }
}

impl Program {
    /// Returns the functions that a brush's material needs.
    fn material_wgsl(&self) -> String {
        if !self.has_textures() {
            return PLAIN_MATERIALS.to_owned();
        }
        let used = OpcodeSet::of(self);
        wgsl_dispatch(|op| used.contains(op)) + TEXTURES
    }
}

/// Depths of the stacks while writing. Where the interpreter would index a stack, the text has a variable of that
/// number.
#[derive(Default)]
struct Depth {
    value: usize,
    point: usize,
    loops: usize,
}

fn write_field(program: &Program) -> String {
    let mut body = String::new();
    let mut depth = Depth::default();
    for instr in &program.instructions {
        // Writing to a string does not fail.
        let _ = write_instr(program, instr, &mut depth, &mut body);
    }
    let mut text = String::from(
        "var<private> field_material: GpuMaterial;\n\nfn field(at: vec3<f32>, with_material: bool) -> f32 {\n",
    );
    for i in 0..=program.value_slots {
        text += &format!("    var a{i} = FAR;\n    var m{i} = first_material();\n");
    }
    for i in 0..=program.point_slots {
        text += &format!("    var p{i} = at;\n");
    }
    text += "    field_material = first_material();\n";
    text += "    if !(is_in_world(at.x) && is_in_world(at.y) && is_in_world(at.z)) {\n        return FAR;\n    }\n";
    text += &body;
    text += "    return a0;\n}\n\n";
    text + include_str!("field_calls.wgsl")
}

fn write_instr(
    program: &Program,
    instr: &Instruction,
    depth: &mut Depth,
    out: &mut String,
) -> std::fmt::Result {
    let Instruction {
        op,
        params: w,
        operand,
        ..
    } = *instr;
    let (v, q) = (depth.value, depth.point);
    if op < abi::OP_SHAPES_END {
        return write_brush(instr, v, q, out);
    }
    match op {
        abi::OP_PUSH_VALUE => {
            writeln!(out, "    m{v} = field_material;\n    a{} = FAR;", v + 1)?;
            depth.value += 1;
        }
        abi::OP_COMBINE => {
            depth.value -= 1;
            write_combine(instr, v, out)?;
        }
        abi::OP_REPEAT | abi::OP_RADIAL => {
            write_loop(instr, depth, out)?;
            depth.value += 1;
            depth.point += 1;
            depth.loops += 1;
        }
        abi::OP_NEXT => {
            depth.value -= 1;
            depth.point -= 1;
            depth.loops -= 1;
            let least = v - 1;
            writeln!(
                out,
                "    if a{v} < a{least} {{ a{least} = a{v}; m{least} = field_material; }} }}"
            )?;
            writeln!(out, "    field_material = m{least};")?;
        }
        op if abi::saves_point(op) || abi::restores_point(op) || abi::moves_point(op) => {
            write_domain(instr, depth, out)?;
        }
        abi::OP_RAMP => writeln!(out, "    ramp_share = ramp_value(p{q}, {w}u);")?,
        abi::OP_ROUND => writeln!(out, "    a{v} -= params[{w}u];")?,
        abi::OP_SHELL => writeln!(out, "    a{v} = abs(a{v}) - params[{w}u];")?,
        abi::OP_DISPLACE => {
            writeln!(out, "    a{v} = displace(a{v}, p{q}, {operand}u, {w}u);")?;
        }
        _ => {}
    }
    debug_assert!(depth.value <= program.value_slots && depth.point <= program.point_slots);
    Ok(())
}

/// Writes a change of the point, or the return from it.
fn write_domain(instr: &Instruction, depth: &mut Depth, out: &mut String) -> std::fmt::Result {
    let Instruction { op, params: w, .. } = *instr;
    let (v, q) = (depth.value, depth.point);
    match op {
        abi::OP_PUSH_POINT => {
            writeln!(out, "    p{} = p{q};", q + 1)?;
            depth.point += 1;
        }
        abi::OP_POP_POINT => depth.point -= 1,
        abi::OP_AFFINE => writeln!(out, "    p{q} = mapped(p{q}, {w}u);")?,
        abi::OP_MIRROR => writeln!(out, "    p{q} = mirrored(p{q}, {w}u);")?,
        abi::OP_ELONGATE => writeln!(out, "    p{q} = elongated(p{q}, {w}u);")?,
        abi::OP_TWIST | abi::OP_BEND => {
            let name = if op == abi::OP_TWIST { "twist" } else { "bend" };
            writeln!(out, "    p{} = {name}(p{q}, {w}u);", q + 1)?;
            depth.point += 1;
        }
        abi::OP_UNCLAMP => {
            depth.point -= 1;
            writeln!(out, "    a{v} = unclamp(a{v}, p{}, {w}u);", q - 1)?;
        }
        abi::OP_FLATTEN | abi::OP_WRAP => {
            let call = if op == abi::OP_WRAP {
                format!("wrap(p{q}, {w}u)")
            } else {
                format!("flatten(p{q})")
            };
            writeln!(out, "    p{} = {call};", q + 1)?;
            depth.point += 1;
        }
        abi::OP_EXTRUDE | abi::OP_UNWRAP => {
            depth.point -= 1;
            let name = if op == abi::OP_EXTRUDE {
                "extrude"
            } else {
                "unwrap"
            };
            writeln!(out, "    a{v} = {name}(a{v}, p{}, {w}u);", q - 1)?;
        }
        abi::OP_REVOLVE => writeln!(out, "    p{q} = revolve(p{q}, {w}u);")?,
        abi::OP_SHIFT => writeln!(out, "    p{q} = shift(p{q}, {w}u);")?,
        _ => {}
    }
    Ok(())
}

fn write_combine(instr: &Instruction, v: usize, out: &mut String) -> std::fmt::Result {
    let Instruction {
        flags, params: w, ..
    } = *instr;
    let saved = v - 1;
    let swapped = flags & abi::FLAG_SWAPPED != 0;
    let (a, b) = if swapped { (v, saved) } else { (saved, v) };
    let (ma, mb) = if swapped {
        ("field_material".into(), format!("m{saved}"))
    } else {
        (format!("m{saved}"), "field_material".into())
    };
    writeln!(out, "    {{ let j = read_group_joint({w}u, {flags}u);")?;
    writeln!(
        out,
        "    field_material = mix_material({ma}, {mb}, weight(a{a}, a{b}, j, {flags}u));"
    )?;
    writeln!(out, "    a{saved} = combine(a{a}, a{b}, j, {flags}u); }}")
}

fn write_loop(instr: &Instruction, depth: &Depth, out: &mut String) -> std::fmt::Result {
    let (v, q, n) = (depth.value, depth.point, depth.loops);
    let begin = format!("Instruction({}u, 0u, {}u, 0u)", instr.op, instr.params);
    writeln!(
        out,
        "    a{v} = FAR;\n    for (var i{n} = 0u; i{n} < candidates({begin}); i{n}++) {{"
    )?;
    writeln!(
        out,
        "    a{} = FAR;\n    p{} = candidate({begin}, p{q}, i{n});",
        v + 1,
        q + 1
    )
}

fn write_brush(instr: &Instruction, v: usize, q: usize, out: &mut String) -> std::fmt::Result {
    let Instruction {
        op,
        flags,
        params: w,
        operand,
        ..
    } = *instr;
    let shape_words = w + abi::BRUSH_HEADER_WORDS;
    let searched = op >= abi::OP_FIRST_ITERATIVE;
    let map = if flags & abi::FLAG_TRANSLATION != 0 && !searched {
        "translated"
    } else {
        "mapped"
    };
    writeln!(
        out,
        "    {{ let p = {map}(p{q}, {w}u); let j = read_joint({}u);",
        w + 13
    )?;
    let words = if searched {
        writeln!(
            out,
            "    if matters(a{v}, box_distance(p, {shape_words}u) * params[{}u], j) {{",
            w + 12
        )?;
        shape_words + 6
    } else {
        shape_words
    };
    writeln!(
        out,
        "    let d = {}(p, {words}u) * params[{}u];",
        wgsl_function(op),
        w + 12
    )?;
    writeln!(
        out,
        "    if with_material {{ field_material = mix_material(field_material, brush_material(Instruction({op}u, {flags}u, {w}u, {operand}u), at, p, {shape_words}u), weight(a{v}, d, j, {flags}u)); }}"
    )?;
    writeln!(
        out,
        "    a{v} = combine_smooth(a{v}, d, j); }}{}",
        if searched { " }" } else { "" }
    )
}
