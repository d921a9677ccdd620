// GPU version of microfacets.rs, albedo.rs and bsdf.rs. Directions are in a frame whose z is the normal.

const FRAC_1_PI: f32 = 0.31830989;
const DIELECTRIC: f32 = 0.04;

fn facet_width(roughness: f32) -> f32 {
    return max(roughness * roughness, 1e-3);
}

fn facet_density(alpha: f32, h: vec3<f32>) -> f32 {
    let alpha2 = alpha * alpha;
    let spread = alpha2 * h.z * h.z + h.x * h.x + h.y * h.y;
    return alpha2 / max(PI * spread * spread, 1e-30);
}

fn facet_shadow(alpha: f32, cosine: f32) -> f32 {
    let cosine2 = max(cosine * cosine, 1e-12);
    let tangent2 = max(1.0 - cosine2, 0.0) / cosine2;
    return 0.5 * (sqrt(1.0 + alpha * alpha * tangent2) - 1.0);
}

fn passed_share(alpha: f32, source: f32, to: f32) -> f32 {
    let own = facet_shadow(alpha, source);
    return (1.0 + own) / (1.0 + own + facet_shadow(alpha, to));
}

fn visible_normal(alpha: f32, source: vec3<f32>, point: vec2<f32>) -> vec3<f32> {
    let stretched = normalize(vec3(alpha * source.x, alpha * source.y, source.z));
    let side = vec3(-stretched.y, stretched.x, 0.0);
    let size = length(side);
    let across = select(vec3(1.0, 0.0, 0.0), side / max(size, 1e-30), size > 1e-20);
    let along = cross(stretched, across);
    let radius = sqrt(point.x);
    let x = radius * cos(TAU * point.y);
    let share = 0.5 * (1.0 + stretched.z);
    let y = (1.0 - share) * sqrt(max(1.0 - x * x, 0.0)) + share * radius * sin(TAU * point.y);
    let z = sqrt(max(1.0 - x * x - y * y, 0.0));
    let own = x * across + y * along + z * stretched;
    return normalize(vec3(alpha * own.x, alpha * own.y, max(own.z, 1e-6)));
}

fn albedo_entry(index: u32) -> vec2<f32> {
    let two = path_tables[paths.albedo_at + index / 2u];
    return select(two.xy, two.zw, (index & 1u) == 1u);
}

// Returns the shares at a cosine, and their means over all directions.
fn albedo_shares(alpha: f32, cosine: f32) -> vec4<f32> {
    let most = f32(ALBEDO_SIDE - 1u);
    let place = clamp(vec2(cosine, sqrt(alpha)), vec2(0.0), vec2(1.0)) * most;
    let first = min(vec2<u32>(place), vec2(ALBEDO_SIDE - 2u));
    let t = place - vec2<f32>(first);
    let row = ALBEDO_SIDE * first.y + first.x;
    let low = mix(albedo_entry(row), albedo_entry(row + 1u), t.x);
    let high = mix(albedo_entry(row + ALBEDO_SIDE), albedo_entry(row + ALBEDO_SIDE + 1u), t.x);
    let means = ALBEDO_SIDE * ALBEDO_SIDE + first.y;
    return vec4(mix(low, high, t.y), mix(albedo_entry(means), albedo_entry(means + 1u), t.y));
}

struct Bsdf {
    axes: mat3x3<f32>,
    toward: vec3<f32>,
    alpha: f32,
    mirror: vec3<f32>,
    dielectric_again: f32,
    lost: vec3<f32>,
    mirror_chance: f32,
    body: vec3<f32>,
    albedo: vec3<f32>,
}

fn again_of(mirror: vec3<f32>, lost_mean: f32) -> vec3<f32> {
    let mean = (20.0 * mirror + 1.0) / 21.0;
    return mean * mean * (1.0 - lost_mean) / (1.0 - mean * lost_mean);
}

fn bsdf_of(material: GpuMaterial, normal: vec3<f32>, toward: vec3<f32>) -> Bsdf {
    var own: Bsdf;
    let base = material.base_roughness.xyz;
    let metallic = material.emission_metallic.w;
    own.alpha = facet_width(material.base_roughness.w);
    own.mirror = mix(vec3(DIELECTRIC), base, metallic);
    own.axes = axes_of(normal);
    let seen = toward * own.axes;
    own.toward = normalize(vec3(seen.xy, max(seen.z, 1e-3)));
    let shares = albedo_shares(own.alpha, own.toward.z);
    let lost = 1.0 - shares.x - shares.y;
    let lost_mean = 1.0 - shares.z - shares.w;
    own.dielectric_again = again_of(vec3(DIELECTRIC), lost_mean).x;
    let again = own.dielectric_again + metallic * (again_of(base, lost_mean) - own.dielectric_again);
    let let_through = 1.0 - (DIELECTRIC * shares.x + shares.y + own.dielectric_again * lost);
    let let_through_mean = 1.0 - (DIELECTRIC * shares.z + shares.w + own.dielectric_again * lost_mean);
    let through = base * (1.0 - metallic) * let_through;
    let shine = own.mirror * shares.x + shares.y;
    let around = again * lost + through;
    own.lost = again * (lost / max(lost_mean, 1e-6));
    own.body = through / max(let_through_mean, 1e-6);
    own.albedo = shine + around;
    let sum = dot(shine, vec3(1.0));
    own.mirror_chance = clamp(sum / max(sum + dot(around, vec3(1.0)), 1e-6), 0.1, 1.0);
    return own;
}

// Returns what is reflected from a direction in the axes, times its cosine, and the density with which it is chosen.
fn bsdf_reflected(own: Bsdf, to: vec3<f32>) -> vec4<f32> {
    if to.z <= 0.0 {
        return vec4(0.0);
    }
    let halfway = normalize(own.toward + to);
    let density = facet_density(own.alpha, halfway);
    let rim = pow(clamp(1.0 - dot(own.toward, halfway), 0.0, 1.0), 5.0);
    let fresnel = own.mirror + (1.0 - own.mirror) * rim;
    let shadow = facet_shadow(own.alpha, own.toward.z);
    let lobe = density / (4.0 * own.toward.z * (1.0 + shadow + facet_shadow(own.alpha, to.z)));
    let shares = albedo_shares(own.alpha, to.z).xy;
    let left = 1.0 - shares.x - shares.y;
    let through = 1.0 - (DIELECTRIC * shares.x + shares.y + own.dielectric_again * left);
    let around = (own.lost * left + own.body * through) * (FRAC_1_PI * to.z);
    let of_facet = density / (4.0 * own.toward.z * (1.0 + shadow));
    let chance = own.mirror_chance;
    return vec4(fresnel * lobe + around, chance * of_facet + (1.0 - chance) * FRAC_1_PI * to.z);
}

// Chooses a direction in the axes.
fn bsdf_sample(own: Bsdf, lobe: f32, point: vec2<f32>) -> vec3<f32> {
    if lobe < own.mirror_chance {
        let facet = visible_normal(own.alpha, own.toward, point);
        return 2.0 * dot(own.toward, facet) * facet - own.toward;
    }
    let radius = sqrt(point.x);
    return vec3(radius * cos(TAU * point.y), radius * sin(TAU * point.y), sqrt(max(1.0 - point.x, 0.0)));
}
