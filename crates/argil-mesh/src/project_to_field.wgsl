// GPU version of project_to_field.rs, one vertex per thread. Vertices move to where the exact field is 0, by one step of false
// position along their edges. Normals are the field's gradient, by central differences.

// Returns how far along its edge a vertex with distance `d` moves.
fn correction(a: f32, b: f32, d: f32) -> f32 {
    let t = clamp(a / (a - b), MIN_EDGE_FRACTION, 1.0 - MIN_EDGE_FRACTION);
    // The part of the edge on which the sign changes.
    let to = select(t * a / (a - d), t + (1.0 - t) * d / (d - b), (d < 0.0) == (a < 0.0));
    return select(0.0, clamp(to, MIN_EDGE_FRACTION, 1.0 - MIN_EDGE_FRACTION) - t, abs(to) < 1e30);
}

fn position_of(at: u32) -> vec3<f32> {
    return vec3(vertices[6u * at], vertices[6u * at + 1u], vertices[6u * at + 2u]);
}

@compute @workgroup_size(64)
fn project_to_field(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>) {
    let at = marching.first_vertex + id.x + 64u * count.x * id.y;
    if at >= marching.vertices {
        return;
    }
    let p = position_of(at);
    let h = marching.bias;
    var d = 0.0;
    var n = vec3(0.0);
    // One call in a loop, because each call copies the code of the whole field.
    let first = select(6u, 0u, marching.normals == MARCH_FIELD);
    let end = select(6u, 7u, marching.is_moved != 0u);
    for (var i = first; i < end; i++) {
        let axis = vec3(f32(i / 2u == 0u), f32(i / 2u == 1u), f32(i / 2u == 2u));
        let sign = 1.0 - 2.0 * f32(i & 1u);
        let found = field_distance(p + axis * (h * sign));
        if i < 6u {
            n += axis * (found * sign);
        } else {
            d = found;
        }
    }
    if per_thread(marching.is_moved, at) != 0u {
        let span = spans[at];
        // GPU version of outward.
        let along = abs(n[u32(span.z)]);
        n[u32(span.z)] = select(along, -along, span.y < span.x);
        let k = 6u * at + u32(span.z);
        vertices[k] += marching.first_voxel.w * correction(span.x, span.y, d);
    }
    if per_thread(marching.normals, at) != MARCH_FIELD {
        return;
    }
    let length = sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    n *= select(0.0, 1.0 / max(length, 1e-37), length > 0.0);
    vertices[6u * at + 3u] = n.x;
    vertices[6u * at + 4u] = n.y;
    vertices[6u * at + 5u] = n.z;
}
