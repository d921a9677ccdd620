// Vertices: their indices, and how they are written.

// Returns the first vertex and triangle of a unit, and the index of its rows.
fn first_of(unit: u32) -> vec3<u32> {
    let own = units[unit];
    return vec3(own.vertices, own.triangles, own.place) + groups[unit / UNITS_PER_GROUP].xyz;
}

// Records, for each row of a unit with vertices, which edges along x, y and z have one, and how many vertices
// precede the row.
@compute @workgroup_size(GROUP)
fn assign_row_offsets(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let unit = min(group_index(id, count), marching.units - 1u);
    let exists = units[unit].spare != 0u;
    if exists {
        load(unit, local);
    }
    workgroupBarrier();
    let last = last_of(unit);
    let each = (row_count() + GROUP - 1u) / GROUP;
    let first = local * each;
    let end = min(first + each, row_count());
    var own = 0u;
    if exists {
        for (var row = first; row < end; row++) {
            for (var axis = 0u; axis < 3u; axis++) {
                own += countOneBits(owned(unit, axis, row, crossed(axis, row, last)));
            }
        }
    }
    var before = scanned(vec3(own, 0u, 0u), local).x;
    if exists {
        let begin = first_of(unit).z * row_count();
        for (var row = first; row < end; row++) {
            let x = owned(unit, 0u, row, crossed(0u, row, last));
            let y = owned(unit, 1u, row, crossed(1u, row, last));
            let z = owned(unit, 2u, row, crossed(2u, row, last));
            rows[begin + row] = vec4(x, y, z, before);
            before += countOneBits(x) + countOneBits(y) + countOneBits(z);
        }
    }
}

// Returns the gradient of the samples at a point of a unit, in quanta per voxel: central differences, one-sided
// where nothing is stored.
fn stored_gradient(unit: u32, place: vec3<u32>) -> vec3<f32> {
    var gradient = vec3(0.0);
    for (var axis = 0u; axis < 3u; axis++) {
        var way = vec3(0);
        way[axis] = 1;
        let high = stored_beyond(unit, vec3<i32>(place) + way);
        let low = stored_beyond(unit, vec3<i32>(place) - way);
        let here = stored_at(unit, place);
        let a = select(here, low.x, low.y > 0.0);
        let b = select(here, high.x, high.y > 0.0);
        gradient[axis] = (b - a) / max(low.y + high.y, 1.0);
    }
    return gradient;
}

fn unit_vector(v: vec3<f32>) -> vec3<f32> {
    let length = sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    return v * select(0.0, 1.0 / max(length, 1e-37), length > 0.0);
}

// Writes the vertex on an edge. If it will be moved, also writes the distances at the edge's ends, and its axis.
fn write_vertex(at: u32, unit: u32, place: vec3<u32>, axis: u32) {
    var after = place;
    after[axis] += 1u;
    let a = stored_at(unit, place);
    let b = stored_at(unit, after);
    let t = clamp((marching.iso - a) / (b - a), MIN_EDGE_FRACTION, 1.0 - MIN_EDGE_FRACTION);
    var voxels = origin_of(unit) + vec3<f32>(place);
    voxels[axis] += t;
    let position = marching.first_voxel.xyz + marching.first_voxel.w * voxels;
    var normal = vec3(0.0);
    if per_thread(marching.normals, at) == MARCH_GRADIENT {
        normal = unit_vector(mix(stored_gradient(unit, place), stored_gradient(unit, after), t));
    }
    if per_thread(marching.is_moved, at) != 0u {
        spans[at] = vec4(a * marching.quantum, b * marching.quantum, f32(axis), 0.0);
    }
    vertices[6u * at] = position.x;
    vertices[6u * at + 1u] = position.y;
    vertices[6u * at + 2u] = position.z;
    vertices[6u * at + 3u] = normal.x;
    vertices[6u * at + 4u] = normal.y;
    vertices[6u * at + 5u] = normal.z;
}

// Returns the vertex on an edge of a unit.
fn vertex_on(unit: u32, axis: u32, place: vec3<u32>) -> u32 {
    let x = u32(axis != 0u && place.x == marching.side);
    let gone = towards(unit, sides_of(axis, place.y + points() * place.z) | x);
    let owner = beside[gone];
    // A high side of this unit is the low side of the owner.
    let at = select(place, vec3(0u), vec3((gone & 1u) != 0u, (gone & 2u) != 0u, (gone & 4u) != 0u));
    let first = first_of(owner);
    let row = rows[first.z * row_count() + at.y + points() * at.z];
    var before = row.w + countOneBits(row[axis] & ((1u << at.x) - 1u));
    if axis > 0u {
        before += countOneBits(row.x);
    }
    if axis > 1u {
        before += countOneBits(row.y);
    }
    return first.x + before;
}
