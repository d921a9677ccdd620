// GPU version of glass.rs.

// Returns what a facet reflects of light at a cosine, and the cosine beyond it.
fn glass_fresnel(cosine: f32, ratio: f32) -> vec2<f32> {
    let sine2 = ratio * ratio * max(1.0 - cosine * cosine, 0.0);
    if sine2 >= 1.0 {
        return vec2(1.0, 0.0);
    }
    let beyond = sqrt(1.0 - sine2);
    let across = (ratio * cosine - beyond) / (ratio * cosine + beyond);
    let along = (cosine - ratio * beyond) / (cosine + ratio * beyond);
    return vec2(0.5 * (across * across + along * along), beyond);
}

struct GlassSample {
    direction: vec3<f32>,
    weight: f32,
    is_through: bool,
    // Whether light goes anywhere.
    goes: bool,
}

fn glass_sample(normal: vec3<f32>, toward: vec3<f32>, roughness: f32, ratio: f32, choice: f32, point: vec2<f32>) -> GlassSample {
    let alpha = facet_width(roughness);
    let axes = axes_of(normal);
    let seen = toward * axes;
    let source = normalize(vec3(seen.xy, max(seen.z, 1e-3)));
    let facet = visible_normal(alpha, source, point);
    let cosine = clamp(dot(source, facet), 0.0, 1.0);
    let found = glass_fresnel(cosine, ratio);
    let is_through = choice >= found.x;
    let through = (ratio * cosine - found.y) * facet - ratio * source;
    let to = select(2.0 * cosine * facet - source, through, is_through);
    let weight = passed_share(alpha, source.z, abs(to.z));
    return GlassSample(normalize(axes * to), weight, is_through, (to.z < 0.0) == is_through);
}
