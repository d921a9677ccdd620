// GPU version of `inside` in still.rs of the crate argil: something opaque that is one solid with glass.

const INNER_PLACES: u32 = 16u;
const HALVINGS: u32 = 16u;

@compute @workgroup_size(64)
fn look_inside(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= paths.pixel_count || states[id.x].phase != PATH_MET || states[id.x].side >= 0.0 {
        return;
    }
    let origin = states[id.x].origin;
    let direction = states[id.x].direction;
    let end = states[id.x].t;
    // First places along the ray, and then the middle between the last clear one and the first opaque one.
    var clear = 0.0;
    var opaque = -1.0;
    material_shift = paths.extras_at;
    for (var index = 0u; index < INNER_PLACES + HALVINGS; index++) {
        let is_search = index >= INNER_PLACES;
        if is_search && opaque < 0.0 {
            return;
        }
        if !is_search && opaque >= 0.0 {
            continue;
        }
        let t = select(end * f32(index) / f32(INNER_PLACES), 0.5 * (clear + opaque), is_search);
        field_surface(origin + t * direction);
        let is_opaque = field_material.base_roughness.x * (1.0 - field_material.emission_metallic.w) <= 0.0;
        if is_opaque && index == 0u {
            return;
        }
        if is_opaque {
            opaque = t;
        } else {
            clear = t;
        }
    }
    // Gradients differ on both sides of what separates them, so far from it that their differences do not reach across.
    let apart = 4.0 * paths.epsilon;
    let away = 8.0 * apart;
    var sum = vec3(0.0);
    for (var index = 0u; index < 12u; index++) {
        let i = index % 6u;
        let axis = vec3(f32(i < 2u), f32(i / 2u == 1u), f32(i >= 4u));
        let sign = (1.0 - 2.0 * f32(i & 1u)) * select(1.0, -1.0, index < 6u);
        let t = select(opaque + away, max(clear - away, 0.0), index < 6u);
        let step = axis * ((1.0 - 2.0 * f32(i & 1u)) * apart);
        sum += axis * (field_distance(origin + t * direction + step) * sign);
    }
    var normal = direction_or_zero(sum);
    if all(normal == vec3(0.0)) {
        normal = -direction;
    }
    states[id.x].shadow_direction = select(normal, -normal, dot(normal, direction) > 0.0);
    states[id.x].t = clear;
    states[id.x].shadow_reach = opaque;
    states[id.x].phase = PATH_INSIDE;
}
