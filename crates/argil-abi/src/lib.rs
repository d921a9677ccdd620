#![doc = include_str!("crate.md")]

mod bindings;
mod declare;
mod hit;
mod layout;
mod op;
mod paths;
mod tables;
mod tuning;
mod volumes;

pub use bindings::*;
pub use hit::*;
pub use layout::StructLayout;
pub use op::*;
pub use paths::*;
pub use tables::*;
pub use tuning::*;
pub use volumes::*;

/// Returns the WGSL declarations of everything in this crate.
pub fn wgsl() -> String {
    let mut text = "// Made from argil-abi by `cargo xtask generate`. Do not edit.\n".to_owned();
    text += &declare::constants_text(op::OPCODES);
    text += &declare::constants_text(op::FLAGS);
    text += &declare::constants_text(bindings::BINDINGS);
    text += &declare::constants_text(paths::PATHS);
    text.extend(
        tuning::NUMBERS
            .iter()
            .map(|(name, number)| number.line(name)),
    );
    for (layout, types) in tables::STRUCTS {
        text += &declare::struct_text(layout, types);
    }
    text += PER_THREAD;
    text
}

/// What branches read uniforms by.
const PER_THREAD: &str = "\
// Whether branches hide that they depend on uniforms. Mesa's software device compiles a shader again for each dispatch, with
// the values of the uniforms that alone decide its branches.
override HIDES_UNIFORMS: bool = false;
// Returns a uniform's value for a branch. No thread has the index 0xffffffff, which the compiler does not know.
fn per_thread(value: u32, index: u32) -> u32 {
    return select(value, 0u, HIDES_UNIFORMS && index == 0xffffffffu);
}
";

/// Returns the opcode of a name, such as `OP_COMBINE`.
pub fn opcode(name: &str) -> Option<u32> {
    op::OPCODES
        .iter()
        .find(|(known, _)| *known == name)
        .map(|&(_, op)| op)
}

/// Whether an instruction saves the point, besides the beginnings of loops.
pub const fn saves_point(op: u32) -> bool {
    matches!(
        op,
        OP_PUSH_POINT | OP_TWIST | OP_BEND | OP_FLATTEN | OP_WRAP
    )
}

/// Whether an instruction restores the point, besides the ends of loops.
pub const fn restores_point(op: u32) -> bool {
    matches!(op, OP_POP_POINT | OP_UNCLAMP | OP_EXTRUDE | OP_UNWRAP)
}

/// Whether an instruction changes the point without saving it.
pub const fn moves_point(op: u32) -> bool {
    matches!(
        op,
        OP_AFFINE | OP_MIRROR | OP_ELONGATE | OP_REVOLVE | OP_SHIFT
    )
}

/// Iterates over the layouts of all shared structs.
pub fn layouts() -> impl Iterator<Item = &'static StructLayout> {
    tables::STRUCTS.iter().map(|(layout, _)| layout)
}
