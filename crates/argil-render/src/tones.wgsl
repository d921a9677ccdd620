// GPU version of tones.rs.

// Whether images may have lamps, fog, bent normals or another tone curve. A software device executes what a thread skips.
override HAS_MORE_LIGHT: bool = false;

fn aces(c: vec3<f32>) -> vec3<f32> {
    let x = c * 0.5;
    return clamp(x * (x * 2.51 + 0.03) / (x * (x * 2.43 + 0.59) + 0.14), vec3(0.0), vec3(1.0));
}

fn agx(light: vec3<f32>) -> vec3<f32> {
    let inset = mat3x3(
        vec3(0.8424791, 0.04232824, 0.04237566),
        vec3(0.0784336, 0.8784686, 0.0784336),
        vec3(0.07922375, 0.07916613, 0.879143),
    );
    let outset = mat3x3(
        vec3(1.196879, -0.05289685, -0.05297164),
        vec3(-0.09802088, 1.1519031, -0.09804345),
        vec3(-0.09902974, -0.09896118, 1.1510737),
    );
    let least = -12.47393;
    let most = 4.026069;
    let bright = max(inset * light, vec3(1e-10));
    let x = (clamp(log2(bright), vec3(least), vec3(most)) - least) / (most - least);
    let curve = ((((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x) - 0.00232;
    return min(pow(max(outset * curve, vec3(0.0)), vec3(2.2)), vec3(1.0));
}

fn tone_map(light: vec3<f32>) -> vec3<f32> {
    let c = light * frame.exposure;
    if !HAS_MORE_LIGHT {
        return aces(c);
    }
    switch per_thread(frame.tone, bitcast<u32>(c.x)) {
        case TONE_ACES: { return aces(c); }
        case TONE_AGX: { return agx(c); }
        default: { return clamp(c, vec3(0.0), vec3(1.0)); }
    }
}
