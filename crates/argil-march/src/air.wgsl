// Light of the field, and of volumes that leave it to the field.

fn air_distance(p: vec3<f32>) -> f32 {
    return field_distance(p);
}
