// How far brushes moved, in the place of their materials: what operators mix of these, they mix of ways, too.
//
// `moved` has the number of boxes and of brushes, then two corners of each box, then four rows of each brush, by the place of its
// parameters: that place, and the rows of the matrix that gives the way from a point.

fn first_material() -> GpuMaterial {
    return GpuMaterial(vec4(0.0), vec4(0.0));
}

// What is cut moves with what cuts.
fn keeps_material(flags: u32) -> bool {
    return false;
}

// Paint that moves takes nothing along.
fn weight_paint(b: f32, j: Joint) -> f32 {
    return 0.0;
}

fn way_along(at: u32, p: vec4<f32>) -> f32 {
    return dot(bitcast<vec4<f32>>(moved[at]), p);
}

// Returns the way to where a brush's point was before, as the first three numbers.
fn brush_material(instr: Instruction, at: vec3<f32>, p: vec3<f32>, own: u32) -> GpuMaterial {
    let begin = 1u + 2u * moved[0].x;
    var low = 0u;
    var high = moved[0].y;
    while low < high {
        let middle = (low + high) / 2u;
        if moved[begin + 4u * middle].x < instr.params {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    var way = vec3(0.0);
    let row = begin + 4u * low;
    if low < moved[0].y && moved[row].x == instr.params {
        let point = vec4(at, 1.0);
        way = vec3(way_along(row + 1u, point), way_along(row + 2u, point), way_along(row + 3u, point));
    }
    return GpuMaterial(vec4(way, 0.0), vec4(0.0));
}

// Whether a point is in a box that holds what moved.
fn is_near_moved(p: vec3<f32>) -> bool {
    for (var index = 0u; index < moved[0].x; index++) {
        let low = bitcast<vec4<f32>>(moved[1u + 2u * index]).xyz;
        let high = bitcast<vec4<f32>>(moved[2u + 2u * index]).xyz;
        if all(p >= low) && all(p <= high) {
            return true;
        }
    }
    return false;
}
