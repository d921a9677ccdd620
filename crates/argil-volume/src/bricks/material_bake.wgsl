// GPU version of material.rs: materials of bricks.

var<workgroup> first_packed: vec2<u32>;
var<workgroup> differing: atomic<u32>;
var<workgroup> first_place: atomic<u32>;
var<workgroup> look: u32;

const MATERIAL_PLACES: u32 = MATERIAL_SIDE * MATERIAL_SIDE * MATERIAL_SIDE;

// Evaluates a brick's materials: one brick per group, one sample per thread.
@compute @workgroup_size(MATERIAL_PLACES)
fn fill_materials(@builtin(workgroup_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let near = near_cell(fill.first_layer + id.x);
    let at = cell_index_of(near.x);
    list = list_range_of(fill.first_layer + id.x);
    let word = word_at(at);
    let cell = cell_at(at);
    let exists = is_brick(word);
    let place = vec3(local % MATERIAL_SIDE, local / MATERIAL_SIDE % MATERIAL_SIDE, local / MATERIAL_SIDE / MATERIAL_SIDE);
    let inner = vec3<f32>(place) * (f32(volume.brick_size_voxels) / f32(MATERIAL_SIDE - 1u));
    var mine = vec2(0u);
    var is_near = false;
    var is_resolved = true;
    if exists {
        let d = field_surface(volume.corner + volume.voxel_size * (vec3<f32>(cell * i32(volume.brick_size_voxels)) + inner));
        mine = pack_material(field_material);
        // Samples farther from the surface than the diagonal between samples do not count.
        let step = f32(volume.brick_size_voxels) / f32(MATERIAL_SIDE - 1u);
        let reach = 1.01 * bounds_of(near.x / 64u).lipschitz * 1.7320508 * step * volume.voxel_size;
        is_near = abs(d) <= reach;
        is_resolved = abs(d) <= MATERIAL_OWN_RATIO * reach;
    }
    if local == 0u {
        atomicStore(&first_place, 0xffffffffu);
        atomicStore(&differing, 0u);
    }
    workgroupBarrier();
    if is_near {
        atomicMin(&first_place, local);
    }
    workgroupBarrier();
    // If no sample is near the surface, all count.
    let has_near = atomicLoad(&first_place) != 0xffffffffu;
    workgroupBarrier();
    if !has_near {
        is_resolved = true;
        is_near = exists;
        if exists {
            atomicMin(&first_place, local);
        }
    }
    workgroupBarrier();
    let first = atomicLoad(&first_place);
    if local == first {
        first_packed = mine;
    }
    workgroupBarrier();
    if first == 0xffffffffu || (is_near && any(mine != first_packed)) {
        atomicStore(&differing, 1u);
    }
    workgroupBarrier();
    if local == 0u && exists {
        look = BRICK_MIXED;
        if atomicLoad(&differing) == 0u {
            for (var i = 0u; i < arrayLength(&materials); i++) {
                // Textures follow.
                if materials[i].base_roughness.w < 0.0 {
                    break;
                }
                if look == BRICK_MIXED && all(pack_material(materials[i]) == first_packed) {
                    look = i;
                }
            }
        }
        let number = brick_number(word);
        var before = 0u;
        if is_brick(near.y) {
            before = brick_materials[number];
        }
        if look == BRICK_MIXED {
            if (before & BRICK_MIXED) != 0u {
                look = before;
            } else {
                look = BRICK_MIXED | take_mixed();
            }
        } else {
            free_mixed(before);
        }
        brick_materials[number] = look;
    }
    workgroupBarrier();
    let block = look & ~BRICK_MIXED;
    if exists && (look & BRICK_MIXED) != 0u && block < volume.mixed {
        let to = volume.capacity + 2u * (block * MATERIAL_PLACES + local);
        // Lists do not decide what is too far away to be sampled.
        let kept = select(first_packed, mine, is_resolved);
        brick_materials[to] = kept.x;
        brick_materials[to + 1u] = kept.y;
    }
}
