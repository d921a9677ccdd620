// Light and materials of the field, and of volumes that use the field for them.

fn light_distance(p: vec3<f32>) -> f32 {
    return field_distance(p);
}

fn surface_material(p: vec3<f32>, outward: vec3<f32>) -> GpuMaterial {
    field_surface(p);
    return field_material;
}
