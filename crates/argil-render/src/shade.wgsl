// GPU version of shade.rs, one pixel per thread.
//
// *Length.* One pass, whose functions no other pass uses.

fn tap_height(radius: f32, tap: u32) -> f32 {
    let step = f32(tap + 1u) / f32(OCCLUSION_TAPS);
    return radius * 0.16 * step * step;
}

fn reach_at(length: f32) -> f32 {
    return min(frame.radius, length);
}

// Returns the fraction of the sky that a point sees.
fn ambient_occlusion(p: vec3<f32>, n: vec3<f32>, reach: f32) -> f32 {
    var closed = 0.0;
    var weight = 1.0;
    for (var tap = 0u; tap < OCCLUSION_TAPS; tap++) {
        // A camera may be on the surface.
        let height = max(tap_height(reach, tap), 1e-20);
        var d = light_distance(p + n * height);
        d = select(d, min(d, p.y + n.y * height - frame.ground_y), frame.has_ground != 0u);
        closed += weight * max(height - d, 0.0) / height;
        weight *= 0.75;
    }
    // Nearly an exponential: no place is black.
    let x = 0.5 * closed;
    return 1.0 / (1.0 + x * (1.0 + x * (0.5 + x / 6.0)));
}

// Computes the visible fraction of the sun for each hit, in as many dispatches as its steps need.
@compute @workgroup_size(8, 8)
fn shadow(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.width || y >= frame.height {
        return;
    }
    let at = y * frame.width + id.x;
    let hit = stored_hit(at);
    let n = hit.normal_t.xyz;
    let view = primary_ray(id.x, y);
    let ray = Ray(view.origin + view.direction * hit.normal_t.w + n * light_lift(hit.normal_t.w), frame.sun);
    let span = box_span(ray);
    // The side away from the sun needs no ray, and a ray that misses the box hits nothing.
    let dark = hit.kind == HIT_NONE || dot(n, ray.direction) <= 0.0 || span.x > span.y;
    var state = vec2(1.0, select(span.x, -1.0, dark));
    if per_thread(frame.first_step, at) > 0u {
        state = bitcast<vec2<f32>>(hits[sun_at(at)].xy);
    }
    let steps = vec2(frame.first_step, per_thread(frame.step_count, at));
    state = march_to_sun(ray.origin, state, span.y, hit.normal_t.w, steps);
    hits[sun_at(at)] = vec4(bitcast<vec2<u32>>(state), 0u, 0u);
}

// Marches a ray on from what it has seen and how far it has come, up to a length. That is negative once it is done. `steps` has
// the first step and their number.
fn march_to_sun(origin: vec3<f32>, begin: vec2<f32>, end: f32, length: f32, steps: vec2<u32>) -> vec2<f32> {
    var share = begin.x;
    var t = begin.y;
    for (var step = 0u; step < steps.y; step++) {
        if t < 0.0 {
            break;
        }
        let d = light_distance(origin + frame.sun * t);
        let own = clamp(SHADOW_SHARPNESS * d / max(t, frame.epsilon), 0.0, 1.0);
        share = min(share, own);
        // One that still marches after all steps would count as lit.
        let part = f32(steps.x + step + 1u) / f32(SHADOW_STEPS);
        t = max(t + max(d * frame.inv_lipschitz, light_step(length)), part * part * part * (2.0 * frame.radius));
        if own <= 0.005 || t >= end {
            t = -1.0;
        }
    }
    return vec2(share, t);
}

fn schlick(mirror: vec3<f32>, cosine: f32, gloss: f32) -> vec3<f32> {
    let m = clamp(1.0 - cosine, 0.0, 1.0);
    let m2 = m * m;
    return mirror + (max(mirror, vec3(gloss)) - mirror) * (m2 * m2 * m);
}

// Returns the share of light that a dielectric's facets let through to its body and back.
fn let_through(roughness: f32, cosines: vec2<f32>) -> f32 {
    let gloss = 1.0 - roughness;
    let level = 0.95 + 0.036 * roughness * roughness;
    let rim = 0.065 + 1.09 * (gloss * gloss * gloss);
    let m = max(1.0 - cosines, vec2(0.0));
    let m2 = m * m;
    let own = max(level - rim * (m2 * m2), vec2(0.0));
    return own.x * own.y / (0.907 + 0.078 * roughness);
}

// Returns what a surface reflects toward the viewer of light from a direction, times its cosine.
fn reflected_from(n: vec3<f32>, view: vec3<f32>, light: vec3<f32>, material: GpuMaterial) -> vec3<f32> {
    let base = material.base_roughness.xyz;
    let roughness = material.base_roughness.w;
    let metallic = material.emission_metallic.w;
    let facing = max(dot(n, view), 1e-3);
    let body = base * (1.0 - metallic);
    let mirror = mix(vec3(0.04), base, metallic);
    let toward = light + view;
    let toward_length = length(toward);
    let halfway = select(vec3(0.0), toward / max(toward_length, 1e-20), toward_length > 0.0);
    let alpha = max(roughness * roughness, 0.01);
    let alpha2 = alpha * alpha;
    let peak = max(dot(n, halfway), 0.0);
    let spread = peak * peak * (alpha2 - 1.0) + 1.0;
    let lobe = alpha2 / (PI * spread * spread);
    let height = max(dot(n, light), 0.0);
    let cosines = vec2(facing, height);
    let hidden = sqrt(cosines * cosines * (1.0 - alpha2) + alpha2);
    let visibility = 0.5 / (height * hidden.x + facing * hidden.y);
    let fresnel = schlick(mirror, max(dot(view, halfway), 0.0), 1.0);
    return (body / PI * let_through(roughness, cosines) + fresnel * (lobe * visibility)) * height;
}

// Returns what a surface reflects of all lamps.
fn lamp_light(at: u32, p: vec3<f32>, n: vec3<f32>, view: vec3<f32>, material: GpuMaterial) -> vec3<f32> {
    var sum = vec3(0.0);
    if !HAS_MORE_LIGHT {
        return sum;
    }
    let lamp_count = per_thread(frame.lamp_count, at);
    for (var index = 0u; index < lamp_count; index++) {
        let share = colors[layer_at(1u + index / 4u, at)][index % 4u];
        let lamp = lamp_above(index, p, n);
        let passed = fog_transmitted(p, lamp.direction, min(frame.far, lamp.distance));
        sum += reflected_from(n, view, lamp.direction, material) * lamp.light * (share * passed);
    }
    return sum;
}

// Returns light with that of the fog and of the lamps in front of it.
fn with_more(at: u32, ray: Ray, reach: f32, light: vec3<f32>) -> vec3<f32> {
    if !HAS_MORE_LIGHT {
        return light;
    }
    let seen = lamps_seen(ray, reach, per_thread(frame.lamp_count, at));
    if per_thread(u32(frame.fog_density > 0.0), at) == 0u {
        return light + seen;
    }
    let found = colors[layer_at(FOG_LAYER, at)];
    return light * found.w + found.xyz / f32(FOG_PLACES) * frame.fog_albedo * (1.0 - found.w) + seen;
}

// Returns the light that a surface sends toward the viewer. `open` is where the sky's light comes from, and its share.
fn shade_surface(at: u32, ray: Ray, hit: Hit, material: GpuMaterial, sunlit: f32, open: vec4<f32>) -> vec3<f32> {
    let base = material.base_roughness.xyz;
    let roughness = material.base_roughness.w;
    let metallic = material.emission_metallic.w;
    let n = hit.normal_t.xyz;
    let view = -ray.direction;
    let facing = max(dot(n, view), 1e-3);
    let body = base * (1.0 - metallic);
    let mirror = mix(vec3(0.04), base, metallic);

    // The sun, and lamps.
    let p = ray.origin + ray.direction * hit.normal_t.w;
    var share = sunlit * sunlit * (3.0 - 2.0 * sunlit);
    if HAS_MORE_LIGHT {
        share *= fog_transmitted(p, frame.sun, frame.far);
    }
    let direct = reflected_from(n, view, frame.sun, material) * frame.sun_light * (share * (PI * 0.5));
    let lamps = lamp_light(at, p, n, view, material);

    // The sky.
    let around = mix(frame.nadir, mix(frame.zenith, frame.horizon, 0.5), 0.5 + 0.5 * open.y);
    let reflected = ray.direction - n * (2.0 * dot(ray.direction, n));
    let gloss = 1.0 - roughness;
    let environment = mix(around, sky(reflected), gloss * gloss);
    let rim = schlick(mirror, facing, gloss);
    let ambient = (body * around * 0.9 + rim * environment) * open.w;

    // Light reflected from below.
    let below = frame.nadir * vec3(0.363636, 0.311111, 0.255319);
    let bounce = body * below * ((0.5 - 0.5 * open.y) * open.w);
    let color = direct + lamps + ambient + bounce + material.emission_metallic.xyz;
    if hit.kind != HIT_GROUND {
        return color;
    }
    return mix(color, sky(ray.direction), clamp(hit.normal_t.w / frame.far * 2.2, 0.0, 1.0));
}

fn id_color(hit: Hit) -> vec3<f32> {
    let mixed = hit.id * 2654435761u;
    let bytes = vec3<f32>((vec3(mixed) >> vec3(8u, 16u, 24u)) & vec3(255u));
    let n = abs(hit.normal_t.xyz);
    return (vec3(0.25) + 0.75 * bytes / 255.0) * (0.55 * n.x + n.y + 0.75 * n.z);
}

fn level_color(hit: Hit) -> vec3<f32> {
    let n = abs(hit.normal_t.xyz);
    let light = 0.55 * n.x + n.y + 0.75 * n.z;
    if ((hit.id - 1u) & LEVEL_MISSING) != 0u {
        return vec3(1.0, 0.1, 0.05) * light;
    }
    let level = f32((hit.id - 1u) & (LEVEL_MISSING - 1u));
    return (0.3 + 0.6 * abs(2.0 * fract(0.381966 * level + vec3(0.0, 1.0 / 3.0, 2.0 / 3.0)) - 1.0)) * light;
}

// The far depth is a number of steps in this mode.
fn heat(steps: u32) -> vec3<f32> {
    let s = clamp(f32(steps) / frame.depth_far, 0.0, 1.0) * 3.0;
    return vec3(
        clamp(s - 1.0, 0.0, 1.0),
        clamp(s, 0.0, 1.0) - clamp(s - 2.0, 0.0, 1.0),
        clamp(1.0 - s, 0.0, 1.0),
    );
}

fn material_of(ray: Ray, hit: Hit) -> GpuMaterial {
    lacks_material = false;
    if hit.kind == HIT_GROUND || hit.kind == HIT_NONE {
        return ground_material();
    }
    let n = hit.normal_t.xyz;
    let p = ray.origin + ray.direction * hit.normal_t.w;
    return surface_material(p, select(n, -n, hit.kind == HIT_INSIDE));
}

fn shaded(at: u32, ray: Ray, hit: Hit, material: GpuMaterial, sunlit: f32) -> vec3<f32> {
    if hit.kind == HIT_NONE {
        return tone_map(with_more(at, ray, UNLIMITED, sky(ray.direction)));
    }
    let p = ray.origin + ray.direction * hit.normal_t.w;
    let n = hit.normal_t.xyz;
    let reach = tap_height(frame.radius, OCCLUSION_TAPS - 1u);
    let low = frame.box_min - reach;
    let high = frame.box_max + reach;
    var open = vec4(n, 1.0);
    if HAS_MORE_LIGHT && per_thread(frame.has_bent_normals, at) != 0u {
        open = colors[layer_at(BENT_LAYER, at)];
    } else if hit.kind != HIT_GROUND || (all(p >= low) && all(p <= high)) {
        open.w = ambient_occlusion(p, n, reach_at(hit.normal_t.w));
    }
    let own = shade_surface(at, ray, hit, material, sunlit, open);
    return tone_map(with_more(at, ray, hit.normal_t.w, own));
}

fn put(at: u32, kind: u32, color: vec3<f32>) {
    let covered = select(0.0, 1.0, kind == HIT_OUTSIDE || kind == HIT_INSIDE);
    colors[at] += vec4(color, covered) * frame.sample_weight;
}

fn shade_pixel(x: u32, y: u32, sunlit: f32) {
    let at = y * frame.width + x;
    let hit = stored_hit(at);
    let ray = primary_ray(x, y);
    let material = material_of(ray, hit);
    if lacks_material {
        defer(at);
        return;
    }
    put(at, hit.kind, shaded(at, ray, hit, material, sunlit));
}

// Shades hits with their materials.
@compute @workgroup_size(8, 8)
fn shade(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x < frame.width && y < frame.height {
        shade_pixel(id.x, y, bitcast<f32>(hits[sun_at(y * frame.width + id.x)].x));
    }
}

// Shows the render modes without lighting.
@compute @workgroup_size(8, 8)
fn show(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.width || y >= frame.height {
        return;
    }
    let at = y * frame.width + id.x;
    show_hit(at, counted_hit(at));
}

// Adds what a render mode without lighting shows.
fn show_hit(at: u32, hit: Hit) {
    var color = vec3(0.0);
    switch per_thread(frame.mode, at) {
        case MODE_NORMAL: {
            if hit.kind != HIT_NONE {
                color = hit.normal_t.xyz * 0.5 + 0.5;
            }
        }
        case MODE_DEPTH: {
            if hit.kind != HIT_NONE {
                let range = max(frame.depth_far - frame.depth_near, 1e-6);
                color = vec3(clamp(1.0 - (hit.normal_t.w - frame.depth_near) / range, 0.0, 1.0));
            }
        }
        case MODE_BRICKS, MODE_NODES: {
            if hit.id != 0u {
                color = id_color(hit);
            }
        }
        case MODE_LEVELS: {
            if hit.id != 0u {
                color = level_color(hit);
            }
        }
        default: { color = heat(hit.steps); }
    }
    put(at, hit.kind, color);
}
