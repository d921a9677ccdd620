// What paths ask of the exact field.

// Returns the distance, and 1 if it is one and not a lower bound.
fn scene_sample(p: vec3<f32>) -> vec2<f32> {
    return vec2(field_distance(p), 1.0);
}

// Sets `field_material` where the material is stored.
fn is_stored_material(p: vec3<f32>, outward: vec3<f32>) -> bool {
    return false;
}
