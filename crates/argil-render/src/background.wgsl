// What is behind and below all solids, for all integrators.

const PI: f32 = 3.1415927;

fn sky(direction: vec3<f32>) -> vec3<f32> {
    let up = direction.y;
    let above = mix(HORIZON, ZENITH, sqrt(max(up, 0.0)));
    let below = mix(HORIZON, NADIR, clamp(-up * 4.0, 0.0, 1.0));
    let base = select(below, above, up >= 0.0);
    let below_horizon = select(base, HORIZON, frame.has_ground != 0u && up < 0.0);
    let glow = max(dot(direction, frame.sun), 0.0);
    let glow2 = glow * glow;
    let glow8 = glow2 * glow2 * glow2 * glow2;
    return below_horizon + vec3(0.25, 0.18, 0.08) * (glow8 * glow8);
}

// Whether the volume has no material for the last surface.
var<private> lacks_material: bool;

fn ground_material() -> GpuMaterial {
    return GpuMaterial(vec4(0.46, 0.45, 0.43, 0.9), vec4(0.0));
}
