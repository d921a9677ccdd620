// Light and materials of the field, and of volumes that use the field for them.

fn light_distance(p: vec3<f32>) -> f32 {
    return field_distance(p);
}

// Returns how far above the surface the shadow of a hit at a length of its ray begins.
fn light_lift(length: f32) -> f32 {
    return frame.light_offset;
}

// Returns the shortest step of a shadow's ray.
fn light_step(length: f32) -> f32 {
    return 2.0 * frame.epsilon;
}

fn surface_material(p: vec3<f32>, outward: vec3<f32>) -> GpuMaterial {
    field_surface(p);
    return field_material;
}

// Every surface has a material.
fn defer(at: u32) {
}
