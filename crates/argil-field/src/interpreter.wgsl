// GPU version of interpreter.rs, for one point.
//
// *Length.* One loop over instructions, whose stacks have module scope. interpreter_wgsl.rs removes unused cases line by line.

var<private> field_material: GpuMaterial;
// The point in the scene, for textures that are fixed to it.
var<private> texture_place: vec3<f32>;

// The stacks. Module scope clears them once per thread instead of once per call.
var<private> values: array<f32, STACK_SLOTS>;
var<private> points: array<vec3<f32>, STACK_SLOTS>;
var<private> kept: array<GpuMaterial, STACK_SLOTS>;

// Combines a brush with the accumulated distance. `shape_distance` is generated from the shape table (dispatch.rs).
// `listed`, `list_length` and `mark` come from unpruned.wgsl, which runs the whole program, or from prune.wgsl.
fn brush(acc: f32, point: vec3<f32>, instr: Instruction, with_material: bool) -> f32 {
    let w = instr.params;
    let j = read_joint(w + 13u);
    let scale = params[w + 12u];
    let own = w + BRUSH_HEADER_WORDS;
    var p: vec3<f32>;
    if (instr.flags & FLAG_TRANSLATION) != 0u && instr.op < OP_FIRST_ITERATIVE {
        p = translated(point, w);
    } else {
        p = mapped(point, w);
    }
    // Skip a search along curves where it cannot matter.
    if !MARKING && instr.op >= OP_FIRST_ITERATIVE && !matters(acc, box_distance(p, own) * scale, j) {
        return acc;
    }
    let d = shape_distance(instr.op, p, own) * scale;
    mark(acc, d, j, instr.flags, false);
    if with_material {
        let share = weight(acc, d, j, instr.flags);
        if share != 0.0 {
            field_material = mix_material(field_material, brush_material(instr, texture_place, p, own), share);
        }
    }
    return combine_smooth(acc, d, j);
}

// Returns the signed distance at a point. On request it also sets `field_material`.
fn field(at: vec3<f32>, with_material: bool) -> f32 {
    // In the function, so that a compiler sees that all threads are at the same instruction.
    var loops: array<u32, STACK_SLOTS>;
    var value_top = 0u;
    var point_top = 0u;
    var loop_top = 0u;
    if !(is_in_world(at.x) && is_in_world(at.y) && is_in_world(at.z)) {
        return FAR;
    }
    var point = at;
    var acc = FAR;
    if with_material {
        texture_place = at;
        field_material = first_material();
    }
    var pc = 0u;
    while pc < list_length() {
        let own = listed(pc);
        let instr = instructions[own];
        let w = instr.params;
        mark_at(pc, loop_top);
        pc++;
        if instr.op < OP_SHAPES_END {
            acc = brush(acc, point, instr, with_material);
            continue;
        }
        switch instr.op {
            case OP_PUSH_VALUE: {
                values[value_top] = acc;
                if with_material {
                    kept[value_top] = field_material;
                }
                value_top++;
                acc = FAR;
            }
            case OP_COMBINE: {
                value_top--;
                let j = read_group_joint(w, instr.flags);
                let swapped = (instr.flags & FLAG_SWAPPED) != 0u;
                let saved = values[value_top];
                let a = select(saved, acc, swapped);
                let b = select(acc, saved, swapped);
                mark(a, b, j, instr.flags, true);
                if with_material {
                    let share = weight(a, b, j, instr.flags);
                    if swapped {
                        field_material = mix_material(field_material, kept[value_top], share);
                    } else {
                        field_material = mix_material(kept[value_top], field_material, share);
                    }
                }
                acc = combine(a, b, j, instr.flags);
            }
            case OP_PUSH_POINT: {
                points[point_top] = point;
                point_top++;
            }
            case OP_POP_POINT: {
                point_top--;
                point = points[point_top];
            }
            case OP_AFFINE: { point = mapped(point, w); }
            case OP_MIRROR: { point = mirrored(point, w); }
            case OP_ELONGATE: { point = elongated(point, w); }
            case OP_REPEAT, OP_RADIAL: {
                points[point_top] = point;
                point_top++;
                values[value_top] = acc;
                if with_material {
                    kept[value_top] = field_material;
                }
                value_top++;
                loops[loop_top] = 0u;
                loop_top++;
                acc = FAR;
                point = candidate(instr, point, 0u);
            }
            case OP_NEXT: {
                let begin = instructions[instr.operand];
                var done = loops[loop_top - 1u] + 1u;
                // Keep the nearer of this copy and the nearest before it.
                if acc < values[value_top - 1u] {
                    values[value_top - 1u] = acc;
                    if with_material {
                        kept[value_top - 1u] = field_material;
                    }
                }
                let count = candidates(begin);
                while done < count {
                    point = candidate(begin, points[point_top - 1u], done);
                    if !holds_in_subgroup(is_too_far(begin, point, values[value_top - 1u])) {
                        break;
                    }
                    done++;
                }
                if done < count {
                    loops[loop_top - 1u] = done;
                    acc = FAR;
                    // A loop is listed as a whole.
                    pc -= own - instr.operand;
                } else {
                    loop_top--;
                    value_top--;
                    point_top--;
                    acc = values[value_top];
                    if with_material {
                        field_material = kept[value_top];
                    }
                    point = points[point_top];
                }
            }
            case OP_TWIST: {
                points[point_top] = point;
                point_top++;
                point = twist(point, w);
            }
            case OP_BEND: {
                points[point_top] = point;
                point_top++;
                point = bend(point, w);
            }
            case OP_UNCLAMP: {
                point_top--;
                point = points[point_top];
                acc = unclamp(acc, point, w);
            }
            case OP_FLATTEN: {
                points[point_top] = point;
                point_top++;
                point = flatten(point);
            }
            case OP_EXTRUDE: {
                point_top--;
                point = points[point_top];
                acc = extrude(acc, point, w);
            }
            case OP_REVOLVE: { point = revolve(point, w); }
            case OP_SHIFT: { point = shift(point, w); }
            case OP_WRAP: {
                points[point_top] = point;
                point_top++;
                point = wrap(point, w);
            }
            case OP_UNWRAP: {
                point_top--;
                point = points[point_top];
                acc = unwrap(acc, point, w);
            }
            case OP_RAMP: { ramp_share = ramp_value(point, w); }
            case OP_ROUND: { acc -= params[w]; }
            case OP_SHELL: { acc = abs(acc) - params[w]; }
            case OP_DISPLACE: { acc = displace(acc, point, instr.operand, w); }
            default: {}
        }
    }
    return acc;
}
