// Lists for three points at once: words of a list whose instructions are all common. See column.wgsl.

// The list's instructions that stay, if all of them are common: how many values are saved, or NOWHERE.
var<private> column_depth: u32;
var<private> column_most: u32;

// Whether three points at once can run an instruction.
fn is_common(instr: Instruction) -> bool {
    let is_shape = instr.op < 32u && ((COLUMN_SHAPES >> (instr.op & 31u)) & 1u) != 0u;
    let is_joint = instr.op == OP_COMBINE && (instr.flags & COMBINE_MASK) == COMBINE_SMOOTH;
    let is_other = instr.op == OP_PUSH_VALUE || instr.op == OP_ROUND || instr.op == OP_SHELL;
    return (is_shape || is_joint || is_other) && instr.params / PARAMS_ALIGNMENT < (1u << (32u - COLUMN_RECORD_SHIFT));
}

fn begin_column() {
    column_depth = 0u;
    column_most = 0u;
}

// Notes an instruction that stays. They come from the last to the first.
fn note_column(instr: Instruction) {
    if !is_common(instr) {
        column_most = NOWHERE;
    } else if instr.op == OP_COMBINE {
        column_depth++;
        column_most = max(column_most, column_depth);
    } else if instr.op == OP_PUSH_VALUE {
        column_depth--;
    }
}

// Returns an instruction as a word of such a list.
fn column_word(instr: Instruction) -> u32 {
    var word = instr.op | ((instr.params / PARAMS_ALIGNMENT) << COLUMN_RECORD_SHIFT);
    if instr.op == OP_COMBINE {
        return word | select(0u, COLUMN_SWAPPED, (instr.flags & FLAG_SWAPPED) != 0u);
    }
    if instr.op < OP_SHAPES_END {
        let j = read_joint(instr.params + 13u);
        word |= select(0u, COLUMN_UNION, j.sa > 0.0 && j.sb > 0.0);
        if (instr.flags & FLAG_TRANSLATION) != 0u {
            let is_quick = ((QUICK_SHAPES >> instr.op) & 1u) != 0u;
            word |= COLUMN_TRANSLATION | select(0u, COLUMN_QUICK, is_quick);
        }
    }
    return word;
}

// Returns where a list's words for three points begin, or NOWHERE.
fn column_of(own_list: vec2<u32>) -> u32 {
    if column_most > COLUMN_SLOTS {
        return NOWHERE;
    }
    let first = reserve(own_list.y);
    if first == NOWHERE {
        return NOWHERE;
    }
    for (var place = 0u; place < own_list.y; place++) {
        lists[first + place] = column_word(instructions[lists[own_list.x + place]]);
    }
    return first;
}
