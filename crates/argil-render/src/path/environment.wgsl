// GPU version of environment.rs. Pixels of `environment` are colors, and sums within their rows.

// Returns the position of a direction, from 0 to 1 across and downward.
fn environment_place(direction: vec3<f32>) -> vec2<f32> {
    let across = (atan2(direction.x, direction.z) - paths.environment_turn) / TAU + 0.5;
    return vec2(across - floor(across), 0.5 - asin(clamp(direction.y, -1.0, 1.0)) * FRAC_1_PI);
}

fn environment_size() -> vec2<i32> {
    return vec2<i32>(vec2(paths.environment_width, paths.environment_height));
}

fn environment_pixel(x: i32, y: i32) -> vec4<f32> {
    let size = environment_size();
    let inside = vec2((x + size.x) % size.x, clamp(y, 0, size.y - 1));
    return textureLoad(environment, inside, 0);
}

// Returns the light from a direction, mixed between pixels.
fn environment_radiance(direction: vec3<f32>) -> vec3<f32> {
    let place = environment_place(direction) * vec2<f32>(environment_size()) - 0.5;
    let first = floor(place);
    let t = place - first;
    let at = vec2<i32>(first);
    let above = mix(environment_pixel(at.x, at.y).xyz, environment_pixel(at.x + 1, at.y).xyz, t.x);
    let below = mix(environment_pixel(at.x, at.y + 1).xyz, environment_pixel(at.x + 1, at.y + 1).xyz, t.x);
    return paths.environment_strength * mix(above, below, t.y);
}

// Returns the share of all light in the rows up to one.
fn environment_rows(row: u32) -> f32 {
    return path_tables[paths.rows_at + row / 4u][row % 4u];
}

// Returns the density of a pixel per solid angle.
fn environment_density_at(x: i32, y: i32) -> f32 {
    let own = environment_pixel(x, y).w;
    var before = 0.0;
    if x > 0 {
        before = environment_pixel(x - 1, y).w;
    }
    let size = vec2<f32>(environment_size());
    return (own - before) * (size.x * size.y) / (TAU * PI);
}

fn environment_density(direction: vec3<f32>) -> f32 {
    let size = environment_size();
    let at = min(vec2<i32>(environment_place(direction) * vec2<f32>(size)), size - 1);
    return environment_density_at(at.x, at.y);
}

// Chooses a direction, and returns its density.
fn environment_sample(point: vec2<f32>) -> vec4<f32> {
    let size = environment_size();
    var low = 0u;
    var high = u32(size.y);
    while low < high {
        let middle = (low + high) / 2u;
        if environment_rows(middle) <= point.y {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    let y = min(low, u32(size.y) - 1u);
    var before = 0.0;
    if y > 0u {
        before = environment_rows(y - 1u);
    }
    let inner_y = (point.y - before) / max(environment_rows(y) - before, 1e-30);
    let row = i32(y);
    let sought = point.x * environment_pixel(size.x - 1, row).w;
    low = 0u;
    high = u32(size.x);
    while low < high {
        let middle = (low + high) / 2u;
        if environment_pixel(i32(middle), row).w <= sought {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    let x = min(i32(low), size.x - 1);
    before = 0.0;
    if x > 0 {
        before = environment_pixel(x - 1, row).w;
    }
    let inner_x = (sought - before) / max(environment_pixel(x, row).w - before, 1e-30);
    let across = (f32(x) + clamp(inner_x, 0.0, 0.9999)) / f32(size.x);
    let down = (f32(y) + clamp(inner_y, 0.0, 0.9999)) / f32(size.y);
    let azimuth = (across - 0.5) * TAU + paths.environment_turn;
    let elevation = 0.5 * PI - down * PI;
    let direction = vec3(cos(elevation) * sin(azimuth), sin(elevation), cos(elevation) * cos(azimuth));
    return vec4(direction, environment_density_at(x, row));
}
