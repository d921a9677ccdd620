// What passes call to evaluate the field.

fn field_distance(p: vec3<f32>) -> f32 {
    return field(p, false);
}

// Returns the distance, and sets `field_material`.
fn field_surface(p: vec3<f32>) -> f32 {
    return field(p, true);
}
