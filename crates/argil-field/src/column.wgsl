// GPU version of interpreter.rs for three points of a column at once, and for lists of common instructions only.
//
// *Theory.* To read an instruction costs as much as to measure a simple shape. Three points share it, and two of their
// coordinates. A few shapes need a short chain of comparisons, and few registers.
//
// *Practice.* A word of such a list holds the opcode, flags, and the record at which the parameters begin. `records` are the
// parameters, four at a time, which a device loads at once. `measure_column` and `measure_quickly`, for the few shapes
// whose points share most if they are only translated, are generated (column_wgsl.rs).

// Three points, which differ in z.
struct Column {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
}

fn is_column_in_world(p: Column) -> vec3<bool> {
    let xy = is_in_world(p.a.x) && is_in_world(p.a.y);
    return vec3(xy && is_in_world(p.a.z), xy && is_in_world(p.b.z), xy && is_in_world(p.c.z));
}

fn translated_column(p: Column, w: u32) -> Column {
    let t = vec3(records[w].w, records[w + 1u].w, records[w + 2u].w);
    let x = p.a.x + t.x;
    let y = p.a.y + t.y;
    return Column(vec3(x, y, p.a.z + t.z), vec3(x, y, p.b.z + t.z), vec3(x, y, p.c.z + t.z));
}

fn mapped_column(p: Column, w: u32) -> Column {
    return Column(mapped(p.a, w), mapped(p.b, w), mapped(p.c, w));
}

// combine_smooth, three times. `signs` has sa, sb and sr.
fn combine_column(a0: vec3<f32>, b0: vec3<f32>, k: f32, quarter: f32, signs: vec3<f32>) -> vec3<f32> {
    let a = a0 * signs.x;
    let b = b0 * signs.y;
    let h = max(-abs(a - b) + k, vec3(0.0));
    return (min(a, b) - h * h * quarter) * signs.z;
}

// The same for a union, whose signs are 1.
fn join_column(a: vec3<f32>, b: vec3<f32>, k: f32, quarter: f32) -> vec3<f32> {
    let h = max(-abs(a - b) + k, vec3(0.0));
    return min(a, b) - h * h * quarter;
}

// Returns the distances of three points, by a list: its first index, and its length.
fn column_distances(own_list: vec2<u32>, p: Column) -> vec3<f32> {
    var values: array<vec3<f32>, COLUMN_SLOTS>;
    var value_top = 0u;
    var acc = vec3(FAR);
    var word = lists[own_list.x];
    for (var place = 1u; place <= own_list.y; place++) {
        // Loaded early. After the last word, any other.
        let next = lists[own_list.x + place];
        let op = word & COLUMN_OPCODE_MASK;
        let flags = word;
        let w = word >> COLUMN_RECORD_SHIFT;
        word = next;
        if op < OP_SHAPES_END {
            let joint = records[w + 3u];
            var d: vec3<f32>;
            if (flags & COLUMN_QUICK) != 0u {
                d = measure_quickly(op, translated_column(p, w), w);
            } else {
                var q: Column;
                if (flags & COLUMN_TRANSLATION) != 0u {
                    q = translated_column(p, w);
                } else {
                    q = mapped_column(p, w);
                }
                d = measure_column(op, q, w) * joint.x;
            }
            if (flags & COLUMN_UNION) != 0u {
                acc = join_column(acc, d, joint.y, joint.z);
            } else {
                acc = combine_column(acc, d, joint.y, joint.z, vec3(joint.w, records[w + 4u].xy));
            }
        } else if op == OP_PUSH_VALUE {
            values[value_top] = acc;
            value_top++;
            acc = vec3(FAR);
        } else if op == OP_COMBINE {
            value_top--;
            let swapped = (flags & COLUMN_SWAPPED) != 0u;
            let saved = values[value_top];
            let a = select(saved, acc, swapped);
            let b = select(acc, saved, swapped);
            let joint = records[w];
            acc = combine_column(a, b, joint.x, joint.y, vec3(joint.zw, records[w + 1u].x));
        } else if op == OP_ROUND {
            acc -= vec3(records[w].x);
        } else {
            acc = abs(acc) - vec3(records[w].x);
        }
    }
    return select(vec3(FAR), acc, is_column_in_world(p));
}
