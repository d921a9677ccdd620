// GPU version of prune.rs, one cell per thread. The pruned program of a cell is a range of `lists`, which contains
// indices into `instructions`.
//
// Marks of a joint take two bits. A backward walk over the list turns them into one bit per instruction that stays:
// backward, the replacement of an operand is known before the operand is reached.
//
// *Length.* Marking and walking share their stack in module scope.

// Whether joints are marked during evaluation.
override MARKING: bool = false;

const NOWHERE: u32 = 0xffffffffu;
const DROP_A: u32 = 1u;
const DROP_B: u32 = 2u;
const STAYS: u32 = 1u;

// Start of the marks, sixteen per word; the current joint; the bound on how fast distances can change relative to
// each other.
var<private> marks_first: u32;
var<private> joint_place: u32;
var<private> joint_margin: f32;

fn mark_at(place: u32, loops: u32) {
    // A loop has one distance per copy: it stays whole.
    joint_place = select(NOWHERE, place, loops == 0u);
}

fn read_mark(place: u32) -> u32 {
    return (lists[marks_first + place / 16u] >> (2u * (place % 16u))) & 3u;
}

fn write_mark(place: u32, mark: u32) {
    let shift = 2u * (place % 16u);
    let at = marks_first + place / 16u;
    lists[at] = (lists[at] & ~(3u << shift)) | (mark << shift);
}

// Returns the operands that can be removed. GPU version of `dominated`.
fn dominated(a0: f32, b0: f32, j: Joint, flags: u32, is_group: bool) -> u32 {
    let a = a0 * j.sa;
    let b = b0 * j.sb;
    let clear = joint_margin + j.k;
    let is_union = j.sa > 0.0 && j.sb > 0.0;
    let mode = select(COMBINE_SMOOTH, flags & COMBINE_MASK, is_group);
    if mode == COMBINE_MORPH || mode == COMBINE_RAMPED {
        return 0u;
    }
    var drops_a = is_union && a - b > clear;
    var drops_b = b - a > clear;
    if mode == COMBINE_PAINT {
        drops_a = false;
        drops_b = b > 0.5 * joint_margin + j.k;
    } else if mode == COMBINE_CHAMFER && j.k > 0.0 {
        let face = (a + b - j.k) * 0.70710677;
        let steeper = 1.25 * joint_margin;
        drops_a = drops_a && face - b > steeper;
        drops_b = drops_b && face - a > steeper;
    }
    return select(0u, DROP_A, drops_a) | select(0u, DROP_B, drops_b);
}

fn mark(a: f32, b: f32, j: Joint, flags: u32, is_group: bool) {
    if MARKING && joint_place != NOWHERE {
        write_mark(joint_place, dominated(a, b, j, flags, is_group));
    }
}

// Reserves words of `lists`; returns NOWHERE if there is no room.
fn reserve(words: u32) -> u32 {
    // Checked first, so that the counter cannot overflow.
    if words > prune.arena_words || atomicLoad(&counters[COUNTER_LISTS]) > prune.arena_words - words {
        return NOWHERE;
    }
    let at = atomicAdd(&counters[COUNTER_LISTS], words);
    return select(NOWHERE, prune.arena_first + at, at <= prune.arena_words - words);
}

// Open groups: whether the list stays in place of the saved value, and whether what precedes is removed.
const GROUP_STAYS: u32 = 1u;
const GROUP_WIPES: u32 = 2u;
// Open frames: where they end, whether something after them stays, and whether all of them is removed.
const FRAME_BEFORE: u32 = 1u;
const FRAME_GOES: u32 = 2u;

// Converts marks to the instructions that stay, and returns their number.
fn choose() -> u32 {
    // Here and not in the module, so that they take no registers while the list runs. Groups take two bits each.
    var open_groups = vec2(0u);
    var open_frames: array<u32, STACK_SLOTS>;
    var frames = 0u;
    // Whether a later operand replaces what is evaluated here.
    var cleared = false;
    // Whether anything in the open frame stays.
    var is_used = false;
    var count = 0u;
    // The open loops, which stay or go as one.
    var loops = 0u;
    var place = list.y;
    begin_column();
    while place > 0u {
        place--;
        let instr = instructions[listed(place)];
        let own = read_mark(place);
        var stays = false;
        if loops > 0u || instr.op == OP_NEXT {
            stays = !cleared;
            is_used = is_used || stays;
            if instr.op == OP_NEXT {
                loops++;
            } else if instr.op == OP_REPEAT || instr.op == OP_RADIAL {
                loops--;
            }
        } else if instr.op < OP_SHAPES_END {
            stays = !cleared && (own & DROP_B) == 0u;
            is_used = is_used || stays;
            cleared = cleared || (stays && (own & DROP_A) != 0u);
        } else {
            switch instr.op {
                case OP_COMBINE: {
                    let swapped = (instr.flags & FLAG_SWAPPED) != 0u;
                    let drops_saved = (own & select(DROP_A, DROP_B, swapped)) != 0u;
                    let drops_current = (own & select(DROP_B, DROP_A, swapped)) != 0u;
                    var group = 0u;
                    if cleared || (drops_saved && !drops_current) {
                        group = GROUP_WIPES;
                    } else if !drops_current {
                        group = GROUP_STAYS;
                        stays = true;
                    }
                    cleared = cleared || drops_current;
                    open_groups = vec2((open_groups.x << 2u) | group, (open_groups.y << 2u) | (open_groups.x >> 30u));
                }
                case OP_PUSH_VALUE: {
                    stays = (open_groups.x & GROUP_STAYS) != 0u;
                    cleared = (open_groups.x & GROUP_WIPES) != 0u;
                    open_groups = vec2((open_groups.x >> 2u) | (open_groups.y << 30u), open_groups.y >> 2u);
                }
                case OP_POP_POINT, OP_UNCLAMP, OP_EXTRUDE, OP_UNWRAP: {
                    open_frames[frames] = (place << 2u) | select(0u, FRAME_BEFORE, is_used) | select(0u, FRAME_GOES, cleared);
                    frames++;
                    stays = !cleared;
                    is_used = false;
                }
                case OP_PUSH_POINT, OP_TWIST, OP_BEND, OP_FLATTEN, OP_WRAP: {
                    frames--;
                    let frame = open_frames[frames];
                    stays = is_used;
                    if !is_used {
                        // Nothing was evaluated in it.
                        for (var inner = place + 1u; inner <= frame >> 2u; inner++) {
                            count -= read_mark(inner);
                            write_mark(inner, 0u);
                        }
                    }
                    is_used = is_used || (frame & FRAME_BEFORE) != 0u;
                }
                // These also move the point for later instructions in the frame.
                case OP_AFFINE, OP_MIRROR, OP_ELONGATE, OP_REVOLVE, OP_SHIFT: {
                    stays = frames == 0u || (open_frames[max(frames, 1u) - 1u] & FRAME_GOES) == 0u;
                }
                default: { stays = !cleared; }
            }
        }
        write_mark(place, select(0u, STAYS, stays));
        count += select(0u, 1u, stays);
        if stays {
            note_column(instr);
        }
    }
    return count;
}

// Returns the pruned list of a cell around a point, or the list itself if there is no room for another.
fn pruned(center: vec3<f32>, whole: vec2<u32>, margin: f32) -> vec2<u32> {
    list = whole;
    joint_margin = margin;
    let words = (whole.y + 15u) / 16u;
    marks_first = reserve(words);
    if marks_first == NOWHERE {
        return whole;
    }
    for (var i = 0u; i < words; i++) {
        lists[marks_first + i] = 0u;
    }
    _ = field_distance(center);
    let count = choose();
    let first = reserve(count);
    if first == NOWHERE {
        return whole;
    }
    var to = first;
    for (var place = 0u; place < whole.y; place++) {
        if read_mark(place) == STAYS {
            lists[to] = listed(place);
            to++;
        }
    }
    return vec2(first, count);
}
