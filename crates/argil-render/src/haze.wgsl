// GPU version of haze.rs. One pass for each place along the rays and each light, which is the first step.

const ENDLESS: f32 = 1e6;

fn haze_noise(x: u32, y: u32) -> f32 {
    let own = 52.982918 * fract(0.06711056 * f32(x) + 0.00583715 * f32(y));
    return fract(fract(own) + frame.jitter_x + 0.37 * frame.jitter_y);
}

// Returns the share of the sky's light that comes through the fog above a point.
fn sky_passed(p: vec3<f32>) -> vec3<f32> {
    let depth = fog_depth(p, vec3(0.0, 1.0, 0.0), frame.far);
    let lost = 1.0 - frame.fog_albedo;
    return exp(-sqrt(max(3.0 * lost * (1.0 - frame.fog_albedo * frame.fog_anisotropy), vec3(0.0))) * depth);
}

@compute @workgroup_size(8, 8)
fn light_fog(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.width || y >= frame.height {
        return;
    }
    let at = y * frame.width + id.x;
    let hit = stored_hit(at);
    let ray = primary_ray(id.x, y);
    let reach = select(hit.normal_t.w, ENDLESS, hit.kind == HIT_NONE);
    let passed = exp(-fog_depth(ray.origin, ray.direction, reach));
    // The sun, the sky, and all lamps.
    let lights = 2u + frame.lamp_count;
    let place = (f32(frame.first_step / lights) + haze_noise(id.x, y)) / f32(FOG_PLACES);
    let depth = -log(1.0 - place * (1.0 - passed));
    let length = min(fog_length(ray.origin, ray.direction, depth), reach);
    let p = ray.origin + ray.direction * length;
    var lamp = LampLight(frame.sun, UNLIMITED, frame.sun_light * (0.5 * PI), SHADOW_SHARPNESS);
    let light_index = per_thread(frame.first_step % lights, at);
    let is_sky = light_index == 1u;
    if is_sky {
        let mean = frame.zenith * 0.32805 + frame.horizon * 0.23445 + frame.nadir * (7.0 / 16.0);
        lamp = LampLight(vec3(0.0, 1.0, 0.0), UNLIMITED, mean, 1.0);
    } else if light_index > 1u {
        lamp = lamp_at(light_index - 2u, p);
    }
    let phase = fog_phase(dot(ray.direction, lamp.direction));
    let passed_there = fog_transmitted(p, lamp.direction, min(frame.far, lamp.distance));
    let factor = select(vec3(phase * passed_there), sky_passed(p), is_sky);
    let own = lamp.light * factor * lamp_share(p, lamp, light_step(length));
    let index = layer_at(FOG_LAYER, at);
    let before = select(colors[index].xyz, vec3(0.0), frame.first_step == 0u);
    colors[index] = vec4(before + own, passed);
}
