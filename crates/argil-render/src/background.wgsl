// What is behind and below all solids, for all integrators.

const PI: f32 = 3.1415927;
const TAU: f32 = 6.2831853;
// Infinite densities, and lengths: nothing compares with them.
const UNLIMITED: f32 = 1e30;

// Up to this height, the sky leaves the color of the horizon gradually.
const LOW_SKY: f32 = 0.12;

fn sky_share(up: f32) -> f32 {
    let rise = min(up * (1.0 / LOW_SKY), 1.0);
    return sqrt(up) * (rise * rise * (3.0 - 2.0 * rise));
}

fn sky(direction: vec3<f32>) -> vec3<f32> {
    let up = direction.y;
    let above = mix(frame.horizon, frame.zenith, sky_share(max(up, 0.0)));
    let below = mix(frame.horizon, frame.nadir, clamp(-up * 4.0, 0.0, 1.0));
    let base = select(below, above, up >= 0.0);
    let below_horizon = select(base, frame.horizon, up < 0.0 && frame.has_ground != 0u);
    let glow = max(dot(direction, frame.sun), 0.0);
    let glow2 = glow * glow;
    let glow8 = glow2 * glow2 * glow2 * glow2;
    return below_horizon + vec3(0.25, 0.18, 0.08) * (frame.glow * (glow8 * glow8));
}

// Whether the volume has no material for the last surface.
var<private> lacks_material: bool;

fn ground_material() -> GpuMaterial {
    return GpuMaterial(vec4(0.46, 0.45, 0.43, 0.9), vec4(0.0));
}

fn direction_or_zero(v: vec3<f32>) -> vec3<f32> {
    let size = length(v);
    return select(vec3(0.0), v / max(size, 1e-30), size > 0.0);
}

// Returns the share of a sphere's light that its cone lets through: an axis and the cosine where light is gone, and the cosine
// where it is full.
fn cone_share(cone: vec4<f32>, full: f32, away: vec3<f32>) -> f32 {
    let cosine = dot(away, cone.xyz);
    if cosine >= full {
        return 1.0;
    }
    let t = clamp((cosine - cone.w) / max(full - cone.w, 1e-6), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// GPU version of any_orthonormal_pair in glam: columns across and along a unit vector, and the vector.
fn axes_of(n: vec3<f32>) -> mat3x3<f32> {
    let sign = select(1.0, -1.0, n.z < 0.0);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    return mat3x3(
        vec3(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        vec3(b, sign + n.y * n.y * a, -n.y),
        n,
    );
}
