// GPU version of `nearest` in still.rs of the crate argil: the surface where a path's ray ended.

struct PathSurface {
    point: vec3<f32>,
    distance: f32,
    normal: vec3<f32>,
    transmission: f32,
    shading_normal: vec3<f32>,
    refractive_index: f32,
    material: GpuMaterial,
    // 1 / the distance inside after which white light has the base color, or 0.
    attenuation: f32,
    is_solid: bool,
    is_there: bool,
}

// Returns the gradient's direction, out of the solid. One call in a loop, because each call copies the code of the field.
fn scene_normal(p: vec3<f32>) -> vec3<f32> {
    var n = vec3(0.0);
    for (var i = 0u; i < 6u; i++) {
        let axis = vec3(f32(i < 2u), f32(i / 2u == 1u), f32(i >= 4u));
        let sign = 1.0 - 2.0 * f32(i & 1u);
        n += axis * (scene_sample(p + axis * (paths.normal_step * sign)).x * sign);
    }
    return direction_or_zero(n);
}

// Evaluates the properties of the material at a point, those besides `material` if there are any, and how heights turn the normal.
fn set_materials(hit: ptr<function, PathSurface>, p: vec3<f32>) {
    let axes = axes_of((*hit).normal);
    let has_bumps = any((*hit).normal != vec3(0.0)) && paths.bump_step > 0.0;
    var count = 1u;
    if per_thread(paths.extras_at, way.index) > 0u {
        count = select(2u, 4u, has_bumps);
    } else if per_thread(paths.is_stored, way.index) != 0u && is_stored_material(p, (*hit).normal) {
        (*hit).material = field_material;
        count = 0u;
    }
    var heights = vec3(0.0);
    for (var index = 0u; index < count; index++) {
        material_shift = select(0u, paths.extras_at, index > 0u);
        let step = select(0.0, paths.bump_step, index > 1u);
        field_surface(p + step * select(axes[0], axes[1], index == 3u));
        let extras = field_material.base_roughness;
        switch index {
            case 0u: { (*hit).material = field_material; }
            case 1u: {
                (*hit).transmission = extras.x;
                (*hit).refractive_index = extras.y;
                (*hit).attenuation = extras.z;
                heights.x = extras.w;
            }
            case 2u: { heights.y = extras.w; }
            default: { heights.z = extras.w; }
        }
    }
    material_shift = 0u;
    if count == 4u {
        let slope = ((heights.y - heights.x) * axes[0] + (heights.z - heights.x) * axes[1]) / paths.bump_step;
        let turned = direction_or_zero((*hit).normal - slope);
        (*hit).shading_normal = select((*hit).normal, turned, any(turned != vec3(0.0)));
    }
}

// Returns the distance to the ground along a ray that begins outside of glass, or UNLIMITED.
fn ground_distance(origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let down = (frame.ground_y - origin.y) / direction.y;
    let is_seen = direction.y <= -1e-6 && down > 0.0 && down < frame.far && frame.has_ground != 0u;
    return select(UNLIMITED, down, is_seen);
}

// Returns the surface that a path's ray met: a solid's, or the ground's.
fn surface_met() -> PathSurface {
    var hit: PathSurface;
    hit.refractive_index = 1.5;
    if way.phase == PATH_MISSED {
        let down = ground_distance(way.origin, way.direction);
        hit.is_there = way.is_inside == 0u && down < UNLIMITED;
        hit.distance = down;
        hit.normal = select(vec3(0.0), vec3(0.0, 1.0, 0.0), hit.is_there);
        hit.material = ground_material();
    } else {
        hit.is_there = true;
        hit.is_solid = true;
        hit.distance = way.t;
    }
    hit.point = way.origin + hit.distance * way.direction;
    if hit.is_solid {
        // What is opaque inside of glass has a normal that is already known, and a material behind its surface.
        hit.normal = way.shadow_direction;
        var p = way.origin + way.shadow_reach * way.direction;
        if way.phase == PATH_MET {
            hit.normal = scene_normal(hit.point);
            p = hit.point;
        }
        hit.shading_normal = hit.normal;
        set_materials(&hit, p);
    }
    hit.shading_normal = select(hit.normal, hit.shading_normal, hit.is_solid);
    return hit;
}
