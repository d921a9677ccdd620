// What paths ask of a dense volume.

// GPU version of Query::sample: the distance, and 1 if it is one and not a lower bound.
fn scene_sample(p: vec3<f32>) -> vec2<f32> {
    let inside = clamp(p, volume.corner, volume.corner + volume.extent);
    let d = stored_distance(inside, 0u);
    let aside = distance(inside, p);
    if aside > 0.0 {
        return vec2(max(aside, d - aside), 0.0);
    }
    return vec2(d, select(0.0, 1.0, abs(d) < 0.99 * volume.band_width));
}

// Sets `field_material` where the material is stored.
fn is_stored_material(p: vec3<f32>, outward: vec3<f32>) -> bool {
    return false;
}
