// GPU version of emitters.rs and sky.rs. A light has four rows of `path_tables`:
// a sun its direction; irradiance and angle; the cosine at its rim;
// a sphere its center; intensity and radius; its cone's axis and cosine where light is gone; the cosine where it is full;
// a rectangle its center; radiance; half of its width; half of its height.
// The last number of the first row is a LIGHT_….

const LEAST_RADIUS: f32 = 1e-5;

struct EmitterPoint {
    direction: vec3<f32>,
    // Negative for no point at all.
    distance: f32,
    radiance: vec3<f32>,
    density: f32,
}

fn no_emitter() -> EmitterPoint {
    return EmitterPoint(vec3(0.0), -1.0, vec3(0.0), 0.0);
}

fn light_row(index: u32, row: u32) -> vec4<f32> {
    return path_tables[4u * index + row];
}

fn sun_sample(index: u32, point: vec2<f32>) -> EmitterPoint {
    let light = light_row(index, 1u);
    let below = point.x * (1.0 - light_row(index, 2u).x);
    let side = sqrt(max(below * (2.0 - below), 0.0));
    let turn = TAU * point.y;
    let direction = axes_of(light_row(index, 0u).xyz) * vec3(side * cos(turn), side * sin(turn), 1.0 - below);
    return EmitterPoint(normalize(direction), UNLIMITED, light.xyz / light.w, 1.0 / light.w);
}

fn sphere_importance(index: u32, p: vec3<f32>) -> f32 {
    let light = light_row(index, 1u);
    let to = p - light_row(index, 0u).xyz;
    let near = max(max(dot(to, to), light.w * light.w), 1e-12);
    let share = 0.05 + 0.95 * cone_share(light_row(index, 2u), light_row(index, 3u).x, direction_or_zero(to));
    return dot(light.xyz, vec3(1.0)) * share / near;
}

// Returns one minus the cosine of the cone that a sphere fills, or a negative number from inside.
fn sphere_cap(radius: f32, square: f32) -> f32 {
    let sine2 = radius * radius / square;
    return select(sine2 / (1.0 + sqrt(max(1.0 - sine2, 0.0))), -1.0, sine2 >= 1.0);
}

// Returns the distance where a ray enters a sphere, or a negative number.
fn sphere_begin(center: vec3<f32>, radius: f32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let to = center - origin;
    let along = dot(to, direction);
    let beside = to - along * direction;
    let half2 = radius * radius - dot(beside, beside);
    return select(-1.0, along - sqrt(max(half2, 0.0)), half2 > 0.0);
}

fn sphere_radiance(index: u32, away: vec3<f32>) -> vec3<f32> {
    let light = light_row(index, 1u);
    return light.xyz * (cone_share(light_row(index, 2u), light_row(index, 3u).x, away) * FRAC_1_PI / (light.w * light.w));
}

fn sphere_sample(index: u32, p: vec3<f32>, point: vec2<f32>) -> EmitterPoint {
    let center = light_row(index, 0u).xyz;
    let light = light_row(index, 1u);
    let to = center - p;
    let square = dot(to, to);
    if square <= 0.0 {
        return no_emitter();
    }
    let axis = to / sqrt(square);
    if light.w < LEAST_RADIUS {
        return EmitterPoint(axis, sqrt(square), light.xyz * (cone_share(light_row(index, 2u), light_row(index, 3u).x, -axis) / square), UNLIMITED);
    }
    let cap = sphere_cap(light.w, square);
    if cap < 0.0 {
        return no_emitter();
    }
    let below = point.x * cap;
    let side = sqrt(max(below * (2.0 - below), 0.0));
    let turn = TAU * point.y;
    let direction = normalize(axes_of(axis) * vec3(side * cos(turn), side * sin(turn), 1.0 - below));
    var distance = dot(to, direction);
    let beside = to - distance * direction;
    let half2 = light.w * light.w - dot(beside, beside);
    if half2 > 0.0 {
        distance = max(distance - sqrt(half2), 0.0);
    }
    return EmitterPoint(direction, distance, sphere_radiance(index, -direction), 1.0 / (TAU * cap));
}

fn sphere_met(index: u32, origin: vec3<f32>, direction: vec3<f32>) -> EmitterPoint {
    let center = light_row(index, 0u).xyz;
    let radius = light_row(index, 1u).w;
    let to = center - origin;
    let cap = sphere_cap(radius, dot(to, to));
    let distance = sphere_begin(center, radius, origin, direction);
    if radius < LEAST_RADIUS || cap < 0.0 || distance <= 0.0 {
        return no_emitter();
    }
    return EmitterPoint(direction, distance, sphere_radiance(index, -direction), 1.0 / (TAU * cap));
}
