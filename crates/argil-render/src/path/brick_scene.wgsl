// What paths ask of sparse bricks.

// GPU version of Query::sample: the distance, and 1 if it is one and not a lower bound.
fn scene_sample(p: vec3<f32>) -> vec2<f32> {
    let inside = clamp(p, cone_box_min(), cone_box_max());
    let u = held_voxels(in_voxels(inside));
    let cell = cell_of_voxels(u);
    let index = word_index(vec3<i32>(cell));
    let word = word_at(index);
    let inner = inner_of(u, cell);
    let has_samples = is_brick(word);
    var d = 0.0;
    if has_samples {
        d = brick_distance(filter_origin(word), inner);
    } else {
        d = empty_distance_in(index / 64u, u, away(word, inner), word);
    }
    let aside = distance(inside, p);
    if aside > 0.0 {
        return vec2(max(aside, d - aside), 0.0);
    }
    return vec2(d, select(0.0, 1.0, has_samples && abs(d) < 0.99 * volume.band_width));
}

// Sets `field_material` where the material is stored.
fn is_stored_material(p: vec3<f32>, outward: vec3<f32>) -> bool {
    lacks_material = false;
    let found = surface_material(p, outward);
    if !lacks_material {
        field_material = found;
    }
    return !lacks_material;
}
