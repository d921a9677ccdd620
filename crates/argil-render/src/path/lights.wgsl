// GPU version of lights.rs.

fn light_count() -> u32 {
    return per_thread(paths.light_count, way.index);
}

fn light_kind(index: u32) -> u32 {
    return u32(light_row(index, 0u).w);
}

fn light_importance(index: u32, p: vec3<f32>) -> f32 {
    switch light_kind(index) {
        case LIGHT_SUN: { return dot(light_row(index, 1u).xyz, vec3(1.0)); }
        case LIGHT_SPHERE: { return sphere_importance(index, p); }
        case LIGHT_RECTANGLE: { return rectangle_importance(index, p); }
        default: { return light_row(index, 1u).x; }
    }
}

fn all_importance(p: vec3<f32>) -> f32 {
    var all = 0.0;
    for (var index = 0u; index < light_count(); index++) {
        all += light_importance(index, p);
    }
    return all;
}

// Returns the chance with which a light is chosen. `all` is the importance of all lights.
fn light_chance(index: u32, p: vec3<f32>, all: f32) -> f32 {
    if light_count() == 1u {
        return 1.0;
    }
    return light_importance(index, p) / max(all, 1e-30);
}

// Returns the share of a way with a density, if another way has a second one (the power heuristic).
fn power_share(own: f32, other: f32) -> f32 {
    if own >= UNLIMITED {
        return 1.0;
    }
    let ratio = min(other / max(own, 1e-30), 1e15);
    return 1.0 / (1.0 + ratio * ratio);
}

// Returns what is behind everything, without the lights.
fn path_background(direction: vec3<f32>) -> vec3<f32> {
    switch per_thread(paths.background, way.index) {
        case BACKGROUND_SKY: { return sky(direction); }
        case BACKGROUND_EVEN: { return paths.even; }
        default: { return environment_radiance(direction); }
    }
}

// Returns what a ray finds that meets nothing.
fn lights_behind(origin: vec3<f32>, direction: vec3<f32>, density: f32) -> vec3<f32> {
    var behind = path_background(direction);
    var suns = vec3(0.0);
    let all = all_importance(origin);
    for (var index = 0u; index < light_count(); index++) {
        let kind = light_kind(index);
        if kind == LIGHT_SUN && dot(direction, light_row(index, 0u).xyz) >= light_row(index, 2u).x {
            let light = light_row(index, 1u);
            suns += light.xyz / light.w * power_share(density, light_chance(index, origin, all) / light.w);
        } else if kind == LIGHT_ENVIRONMENT {
            behind *= power_share(density, environment_density(direction) * light_chance(index, origin, all));
        }
    }
    return behind + suns;
}

// Returns the light of all lights with a place that a ray passes up to a distance.
fn lights_passed(origin: vec3<f32>, direction: vec3<f32>, distance: f32, density: f32) -> vec3<f32> {
    var sum = vec3(0.0);
    var all = -1.0;
    for (var index = 0u; index < light_count(); index++) {
        let kind = light_kind(index);
        var point = no_emitter();
        if kind == LIGHT_SPHERE {
            point = sphere_met(index, origin, direction);
        } else if kind == LIGHT_RECTANGLE {
            point = rectangle_met(index, origin, direction);
        }
        if point.distance > 0.0 && point.distance < distance {
            if all < 0.0 {
                all = all_importance(origin);
            }
            sum += point.radiance * power_share(density, point.density * light_chance(index, origin, all));
        }
    }
    return sum;
}

// A point of a light. Its radiance is divided by the density.
fn light_sample(p: vec3<f32>, which: f32, point: vec2<f32>) -> EmitterPoint {
    if light_count() == 0u {
        return no_emitter();
    }
    let all = all_importance(p);
    var index = 0u;
    if light_count() > 1u {
        var left = which * all;
        var last = light_count();
        for (var i = 0u; i < light_count(); i++) {
            let own = light_importance(i, p);
            if own <= 0.0 {
                continue;
            }
            last = i;
            left -= own;
            if left < 0.0 {
                break;
            }
        }
        if last == light_count() {
            return no_emitter();
        }
        index = last;
    }
    var found = no_emitter();
    switch light_kind(index) {
        case LIGHT_SUN: { found = sun_sample(index, point); }
        case LIGHT_SPHERE: { found = sphere_sample(index, p, point); }
        case LIGHT_RECTANGLE: { found = rectangle_sample(index, p, point); }
        default: {
            let chosen = environment_sample(point);
            found = EmitterPoint(chosen.xyz, UNLIMITED, environment_radiance(chosen.xyz), chosen.w);
        }
    }
    let chance = light_chance(index, p, all);
    let is_point = found.density >= UNLIMITED;
    let own = select(found.density, 1.0, is_point);
    if found.distance < 0.0 || own <= 0.0 || chance <= 0.0 {
        return no_emitter();
    }
    found.radiance /= own * chance;
    found.density = select(found.density * chance, UNLIMITED, is_point);
    return found;
}
