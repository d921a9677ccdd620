// GPU version of `scattered` in fog.rs.

// Chooses a direction that light is scattered to, and returns its density.
fn fog_scattered(forward: vec3<f32>, point: vec2<f32>) -> vec4<f32> {
    let g = frame.fog_anisotropy;
    var cosine = 1.0 - 2.0 * point.x;
    if per_thread(u32(abs(g) >= 1e-3), way.index) != 0u {
        let share = (1.0 - g * g) / (1.0 - g + 2.0 * g * point.x);
        cosine = clamp((1.0 + g * g - share * share) / (2.0 * g), -1.0, 1.0);
    }
    let side = sqrt(max(1.0 - cosine * cosine, 0.0));
    let turn = TAU * point.y;
    let direction = axes_of(forward) * vec3(side * cos(turn), side * sin(turn), cosine);
    return vec4(normalize(direction), fog_phase(cosine));
}
