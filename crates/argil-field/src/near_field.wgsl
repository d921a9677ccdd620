// GPU version of near_field.rs: each point runs the list of its part of a grid. Lists are exact in their parts.
//
// Parts come in blocks of 4x4x4. Their ranges come first in `lists`; the range after them is that of the whole program.

fn parts() -> u32 {
    return 64u * near.blocks_x * near.blocks_y * near.blocks_z;
}

// Returns the number of a point's range.
fn part_of(p: vec3<f32>) -> u32 {
    let blocks = vec3(near.blocks_x, near.blocks_y, near.blocks_z);
    let place = floor((p - near.corner) * near.inv_edge);
    let is_inside = all(place >= vec3(0.0)) && all(place < 4.0 * vec3<f32>(blocks));
    let part = vec3<u32>(max(place, vec3(0.0)));
    let block = part >> vec3(2u);
    let inner = part & vec3(3u);
    let index = block.x + blocks.x * (block.y + blocks.y * block.z);
    return select(parts(), 64u * index + inner.x + 4u * inner.y + 16u * inner.z, is_inside);
}

// Threads whose points are in one part evaluate together, so that all of them are at the same instruction.
fn near_field(p: vec3<f32>, with_material: bool) -> f32 {
    let own = part_of(p);
    var d = FAR;
    loop {
        let part = first_in_subgroup(own);
        if part == own {
            list = vec2(lists[2u * part], lists[2u * part + 1u]);
            d = field(p, with_material);
            break;
        }
    }
    return d;
}

fn field_distance(p: vec3<f32>) -> f32 {
    return near_field(p, false);
}

// Returns the distance, and sets `field_material`.
fn field_surface(p: vec3<f32>) -> f32 {
    return near_field(p, true);
}
