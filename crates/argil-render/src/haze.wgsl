// GPU version of haze.rs. One pass for each place along the rays and each light, which is the first step.

const ENDLESS: f32 = 1e6;

fn haze_noise(x: u32, y: u32) -> f32 {
    let own = 52.982918 * fract(0.06711056 * f32(x) + 0.00583715 * f32(y));
    return fract(fract(own) + frame.jitter_x + 0.37 * frame.jitter_y);
}

@compute @workgroup_size(8, 8)
fn light_fog(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.width || y >= frame.height {
        return;
    }
    let at = y * frame.width + id.x;
    let hit = hits[at];
    let ray = primary_ray(id.x, y);
    let reach = select(hit.normal_t.w, ENDLESS, hit.kind == HIT_NONE);
    let passed = exp(-fog_depth(ray.origin, ray.direction, reach));
    let lights = 1u + frame.lamp_count;
    let place = (f32(frame.first_step / lights) + haze_noise(id.x, y)) / f32(FOG_PLACES);
    let depth = -log(1.0 - place * (1.0 - passed));
    let length = min(fog_length(ray.origin, ray.direction, depth), reach);
    let p = ray.origin + ray.direction * length;
    var lamp = LampLight(frame.sun, UNLIMITED, frame.sun_light * (0.5 * PI), SHADOW_SHARPNESS);
    let nth = frame.first_step % lights;
    if nth > 0u {
        lamp = lamp_at(nth - 1u, p);
    }
    let share = lamp_share(p, lamp, light_step(length)) * fog_transmitted(p, lamp.direction, min(frame.far, lamp.distance));
    let own = lamp.light * (fog_phase(dot(ray.direction, lamp.direction)) * share);
    let index = layer_at(FOG_LAYER, at);
    let before = select(colors[index].xyz, vec3(0.0), frame.first_step == 0u);
    colors[index] = vec4(before + own, passed);
}
