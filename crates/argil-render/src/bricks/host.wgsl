// What shaders of a host ask of bricks. Other names of the module get the same prefix.

var<private> lacks_material: bool;
var<private> field_material: GpuMaterial;

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

// Returns the signed distance at a point of the scene, negative inside. More than a band from the surface, it is a lower
// bound.
fn argil_distance(p: vec3<f32>) -> f32 {
    return scene_sample(p).x;
}

// Returns the change of the distance along each axis, by differences over a voxel.
fn argil_gradient(p: vec3<f32>) -> vec3<f32> {
    let h = 0.5 * volume.voxel_size;
    return vec3(
        argil_distance(p + vec3(h, 0.0, 0.0)) - argil_distance(p - vec3(h, 0.0, 0.0)),
        argil_distance(p + vec3(0.0, h, 0.0)) - argil_distance(p - vec3(0.0, h, 0.0)),
        argil_distance(p + vec3(0.0, 0.0, h)) - argil_distance(p - vec3(0.0, 0.0, h)),
    ) / (2.0 * h);
}

// Returns the material at a point of the surface. Farther than a brick from it, that is the first one of the scene.
fn argil_material(p: vec3<f32>) -> ArgilMaterial {
    let gradient = argil_gradient(p);
    let slope = length(gradient);
    let outward = select(vec3(0.0), gradient / max(slope, 1e-30), slope > 0.0);
    if !is_stored_material(p, outward) {
        field_material = materials[0];
    }
    let base = field_material.base_roughness;
    let emission = field_material.emission_metallic;
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
    let is_inside = span.x <= 0.0 && argil_distance(origin) < 0.0;
    let walk = walk_bricks(ray, span.x, end, select(1.0, -1.0, is_inside));
    if walk.kind == HIT_NONE || walk.t > max_length {
        return ArgilHit(false, 0.0, vec3(0.0));
    }
    return ArgilHit(true, walk.t, walked_normal(ray, walk));
}
