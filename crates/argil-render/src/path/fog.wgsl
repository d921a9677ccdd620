// GPU version of fog.rs.

const EVEN_FOG: f32 = 1e-4;

fn fog_density_at(p: vec3<f32>) -> f32 {
    return frame.fog_density * exp(min(-frame.fog_falloff * (p.y - frame.fog_height), 40.0));
}

// Returns 1 − exp(−x), without a difference of nearly equal numbers.
fn one_less_exp(x: f32) -> f32 {
    let near = x * (1.0 - x * (0.5 - x * (1.0 / 6.0)));
    return select(1.0 - exp(-x), near, abs(x) < 0.02);
}

fn fog_depth(origin: vec3<f32>, direction: vec3<f32>, length: f32) -> f32 {
    let density = fog_density_at(origin);
    let slope = frame.fog_falloff * direction.y;
    let change = slope * length;
    if abs(change) < EVEN_FOG {
        return density * length * (1.0 - 0.5 * change);
    }
    return density * one_less_exp(change) / slope;
}

fn fog_transmitted(origin: vec3<f32>, direction: vec3<f32>, length: f32) -> f32 {
    return select(1.0, exp(-fog_depth(origin, direction, length)), frame.fog_density > 0.0);
}

// Returns the length after which a ray has an optical depth, or UNLIMITED if it never has.
fn fog_length(origin: vec3<f32>, direction: vec3<f32>, depth: f32) -> f32 {
    let density = fog_density_at(origin);
    if density <= 0.0 {
        return UNLIMITED;
    }
    let slope = frame.fog_falloff * direction.y;
    let even = depth / density;
    if abs(slope * even) < EVEN_FOG {
        return even;
    }
    let left = 1.0 - even * slope;
    if left <= 0.0 {
        return UNLIMITED;
    }
    return -log(left) / slope;
}

fn fog_phase(cosine: f32) -> f32 {
    let g = frame.fog_anisotropy;
    let below = max(1.0 + g * g - 2.0 * g * cosine, 1e-6);
    return (1.0 - g * g) / (2.0 * TAU * below * sqrt(below));
}
