//! What a surface reflects of light from one direction.

use glam::{Vec3, vec3};

/// Returns what a surface reflects toward the viewer of light from a direction, times its cosine: the body's color, what a mirror
/// reflects at a right angle, and the roughness.
#[inline(always)]
pub(super) fn reflected_from(
    n: Vec3,
    view: Vec3,
    light: Vec3,
    (body, mirror, roughness): (Vec3, Vec3, f32),
) -> Vec3 {
    let facing = high(n.dot(view), 1e-3);
    let height = high(n.dot(light), 0.0);
    let toward = light + view;
    let length = toward.dot(toward).sqrt();
    let half = toward * (if length > 1e-20 { 1.0 / length } else { 0.0 });
    let alpha = high(roughness * roughness, 0.01);
    let alpha2 = alpha * alpha;
    let peak = high(n.dot(half), 0.0);
    let spread = peak * peak * (alpha2 - 1.0) + 1.0;
    let lobe = alpha2 / (std::f32::consts::PI * spread * spread);
    let hidden = |cosine: f32| (cosine * cosine * (1.0 - alpha2) + alpha2).sqrt();
    let visibility = 0.5 / (height * hidden(facing) + facing * hidden(height));
    let fresnel = schlick(mirror, high(view.dot(half), 0.0), 1.0);
    let body = body * (std::f32::consts::FRAC_1_PI * let_through(roughness, facing, height));
    (body + fresnel * (lobe * visibility)) * height
}

/// Returns the share of light that a dielectric's facets let through to its body and back (Kelemen and Szirmay-Kalos, "A
/// microfacet based coupled specular-matte BRDF model", 2001). The shares that facets reflect are fitted, to 0.03 for a roughness
/// above 0.3.
#[inline(always)]
fn let_through(roughness: f32, from: f32, to: f32) -> f32 {
    let gloss = 1.0 - roughness;
    let level = 0.95 + 0.036 * roughness * roughness;
    let rim = 0.065 + 1.09 * (gloss * gloss * gloss);
    let albedo = |cosine: f32| {
        let m = high(1.0 - cosine, 0.0);
        let m2 = m * m;
        level - rim * (m2 * m2)
    };
    high(albedo(from), 0.0) * high(albedo(to), 0.0) / (0.907 + 0.078 * roughness)
}

/// Returns Schlick's Fresnel term. The rim of a rough surface is darker.
#[inline(always)]
pub(super) fn schlick(mirror: Vec3, cosine: f32, gloss: f32) -> Vec3 {
    let m = low(high(1.0 - cosine, 0.0), 1.0);
    let m2 = m * m;
    let rim = vec3(
        high(mirror.x, gloss),
        high(mirror.y, gloss),
        high(mirror.z, gloss),
    );
    mirror + (rim - mirror) * (m2 * m2 * m)
}

#[inline(always)]
pub(super) fn mix(a: Vec3, b: Vec3, share: f32) -> Vec3 {
    a + (b - a) * share
}

#[inline(always)]
pub(super) fn low(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

#[inline(always)]
pub(super) fn high(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}
