// What shaders of a host ask of a volume, besides `argil_distance`. Other names of the module get the same prefix.

var<private> lacks_material: bool;

// A material of the scene, in linear colors.
struct ArgilMaterial {
    base_color: vec3<f32>,
    roughness: f32,
    emission: vec3<f32>,
    metallic: f32,
}

// What a ray hits: how far away, and the normal there, toward the ray.
struct ArgilHit {
    is_hit: bool,
    t: f32,
    normal: vec3<f32>,
}

// Returns the change of the distance along each axis, by differences over a voxel.
fn argil_gradient(p: vec3<f32>) -> vec3<f32> {
    let h = 0.5 * voxel_at(p);
    return vec3(
        argil_distance(p + vec3(h, 0.0, 0.0)) - argil_distance(p - vec3(h, 0.0, 0.0)),
        argil_distance(p + vec3(0.0, h, 0.0)) - argil_distance(p - vec3(0.0, h, 0.0)),
        argil_distance(p + vec3(0.0, 0.0, h)) - argil_distance(p - vec3(0.0, 0.0, h)),
    ) / (2.0 * h);
}

// Returns the material at a point of the surface. Where no brick is, that is the first one of the scene.
fn argil_material(p: vec3<f32>) -> ArgilMaterial {
    let gradient = argil_gradient(p);
    let slope = length(gradient);
    let outward = select(vec3(0.0), gradient / max(slope, 1e-30), slope > 0.0);
    let found = surface_material(p, outward);
    let base = found.base_roughness;
    let emission = found.emission_metallic;
    return ArgilMaterial(base.xyz, base.w, emission.xyz, emission.w);
}

// Finds the first surface along a ray with a unit direction, up to a length. A ray that begins in the solid finds where
// it leaves.
fn argil_cast_ray(origin: vec3<f32>, direction: vec3<f32>, max_length: f32) -> ArgilHit {
    let ray = Ray(origin, direction);
    let span = box_span(ray);
    let end = min(span.y, max_length);
    if span.x > end {
        return ArgilHit(false, 0.0, vec3(0.0));
    }
    let hit = host_hit(ray, vec2(span.x, end));
    if !hit.is_hit || hit.t > max_length {
        return ArgilHit(false, 0.0, vec3(0.0));
    }
    return hit;
}
