// GPU version of lamp_shadows.rs: how much of a lamp surfaces see, before shade.wgsl adds its light.
//
// *Length.* One pass, whose functions no other pass uses.

const LAMP_PLANE: f32 = 0.9;
const NARROW: f32 = 1.0 / 400.0;
const RELAXED: f32 = 1.8;
const NEAR_END: f32 = 0.999;

struct LampShape {
    center: vec3<f32>,
    radius: f32,
    out: vec3<f32>,
    extent: f32,
    width: vec3<f32>,
    is_sun: bool,
    height: vec3<f32>,
}

struct SeenLamp {
    middle: vec3<f32>,
    radius: f32,
    width: vec3<f32>,
    extent: f32,
    height: vec3<f32>,
    is_disc: bool,
}

fn lamp_shape(index: u32) -> LampShape {
    let place = frame.lamps[4u * index];
    let light = frame.lamps[4u * index + 1u];
    let first = frame.lamps[4u * index + 2u];
    let second = frame.lamps[4u * index + 3u];
    let kind = u32(place.w);
    var own = LampShape(place.xyz, light.w, vec3(0.0), light.w, vec3(0.0), kind == LIGHT_SUN, vec3(0.0));
    if kind == LIGHT_SUN {
        own.radius = sqrt(max(1.0 - first.x * first.x, 0.0)) / max(first.x, 1e-6) * frame.far;
        own.extent = own.radius;
    } else if kind == LIGHT_RECTANGLE {
        own.width = first.xyz * first.w;
        own.height = second.xyz * second.w;
        own.out = cross(first.xyz, second.xyz);
        own.radius = length(vec2(first.w, second.w));
        own.extent = max(first.w, second.w);
    }
    return own;
}

fn seen_from(lamp: LampShape, p: vec3<f32>) -> SeenLamp {
    if any(lamp.width != vec3(0.0)) {
        // A cone around the middle holds the near corners, too.
        let to = lamp.center - p;
        let wider = inverseSqrt(max(1.0 - lamp.radius * lamp.radius / max(dot(to, to), 1e-20), 0.01));
        return SeenLamp(lamp.center, lamp.radius * wider, lamp.width, lamp.extent, lamp.height, false);
    }
    var middle = p + lamp.center * frame.far;
    var radius = lamp.radius;
    var toward = lamp.center;
    if !lamp.is_sun {
        // The disc that the outline is around.
        let to = lamp.center - p;
        let size = min(radius * radius / max(dot(to, to), 1e-20), 1.0);
        middle = lamp.center - to * size;
        radius *= sqrt(1.0 - size);
        toward = select(direction_or_zero(to), vec3(0.0, 1.0, 0.0), all(to == vec3(0.0)));
    }
    let axes = axes_of(toward);
    return SeenLamp(middle, radius, axes[0] * radius, radius, axes[1] * radius, true);
}

// Returns one of the points that rays lead to, which differ from sample to sample.
fn lamp_point(seen: SeenLamp, index: u32) -> vec3<f32> {
    let shift = fract(vec2(frame.jitter_x, frame.jitter_y) + 0.5);
    let uv = fract(vec2((f32(index) + 0.5) / 16.0, f32(5u * index % 16u) / 16.0 + 0.03125) + shift);
    var at = 2.0 * uv - 1.0;
    if seen.is_disc {
        at = sqrt(uv.x) * vec2(cos(TAU * uv.y), sin(TAU * uv.y));
    }
    return seen.middle + at.x * seen.width + at.y * seen.height;
}

// Returns what a point of a lamp brings to a surface, but for a factor that all points have.
fn lamp_weight(lamp: LampShape, to: vec3<f32>, n: vec3<f32>) -> f32 {
    let square = max(dot(to, to), 1e-20);
    let facing = max(dot(n, to), 0.0);
    let of_rectangle = max(-dot(lamp.out, to), 0.0) / (square * square);
    return facing * select(of_rectangle, inverseSqrt(square), all(lamp.out == vec3(0.0)));
}

// Marches a ray whose cone ends with a radius. Returns the least distance in cone radii, from −1 to 1.
fn march_to_lamp(lamp: LampShape, surface: Ray, length: f32, to: vec3<f32>, radius: f32, is_point: bool) -> f32 {
    let n = surface.direction;
    let lift = min(light_lift(length), 0.05 * distance(surface.origin, to));
    let origin = surface.origin + n * lift;
    let way = max(distance(to, origin), 1e-20);
    let direction = (to - origin) / way;
    // What gains with the way: the cone's radius, and the heights above the surface's plane and before the lamp's.
    let gains = vec3(radius / way, dot(direction, n), dot(direction, lamp.out));
    let has_plane = any(lamp.out != vec3(0.0));
    let begin = vec3(0.0, lift, select(UNLIMITED, dot(origin - lamp.center, lamp.out), has_plane));
    let span = grown_span(Ray(origin, direction), radius);
    let end = min(way - min(0.1 * lamp.extent, 0.1 * way), span.y);
    let half = 0.5 * (end - span.x);
    // A software device ends long loops.
    let steps = select(LAMP_SHADOW_STEPS, LAMP_SHADOW_STEPS / 2u, HIDES_UNIFORMS);
    var least = 1.0;
    // Two halves, from the surface and from the lamp: steps become longer where a ray leaves a plane.
    for (var side = 0u; side < 2u; side++) {
        var s = 0.0;
        // The last step, and how far it was safe to go.
        var last = vec2(0.0);
        for (var step = 0u; step < steps; step++) {
            if s >= half {
                break;
            }
            let t = select(end - s, span.x + s, side == 0u);
            let d = light_distance(origin + direction * t);
            let at = begin + gains * t;
            let planes = LAMP_PLANE * max(min(at.y, at.z), 0.0);
            let own = max(min(at.x, planes), 1e-20);
            let safe = abs(d) * frame.inv_lipschitz;
            // Whole cones take the distance that is certain, and points the likely one.
            let certain = select(sign(d) * safe, d, is_point);
            if certain <= -select(at.x, own, is_point) {
                return -1.0;
            }
            let free = max(certain / max(at.x, 1e-20), d / max(planes, 1e-20));
            least = min(least, max(free, select(-0.99, -1.0, is_point)));
            if last.x > last.y + safe {
                // The balls around both places do not touch.
                s += last.y - last.x;
                last = vec2(0.0);
                continue;
            }
            let share = f32(step + 1u) / f32(steps);
            let low = max(max(light_step(length), 0.5 * own), share * share * share * half - s);
            var next = max(RELAXED * safe, low);
            if next >= half - s && safe < half - s {
                // What is at the end tells whether the step was too long.
                next = NEAR_END * (half - s);
            }
            last = vec2(next, max(safe, low));
            s += next;
        }
    }
    return least;
}

// Returns where a ray enters and leaves the scene's box, which is grown on all sides.
fn grown_span(ray: Ray, by: f32) -> vec2<f32> {
    let d = ray.direction;
    let inverse = vec3(1.0 / not_zero(d.x), 1.0 / not_zero(d.y), 1.0 / not_zero(d.z));
    let a = (frame.box_min - by - ray.origin) * inverse;
    let c = (frame.box_max + by - ray.origin) * inverse;
    let low = min(a, c);
    let high = max(a, c);
    return vec2(max(max(low.x, max(low.y, low.z)), 0.0), min(high.x, min(high.y, high.z)));
}

// Returns the share of a ray's light that passes something in its way, from −1 for all of it to 1 for nothing.
fn covered(seen: f32) -> f32 {
    let t = clamp(0.5 + 0.5 * seen, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// Returns the share of all rays to points of a lamp that one of them has, by what arrives from there.
fn point_share(lamp: LampShape, seen: SeenLamp, point: u32, surface: Ray) -> f32 {
    var whole = 0.0;
    for (var other = 0u; other < LAMP_POINTS; other++) {
        whole += lamp_weight(lamp, lamp_point(seen, other) - surface.origin, surface.direction);
    }
    let own = lamp_weight(lamp, lamp_point(seen, point) - surface.origin, surface.direction);
    return own / max(whole, 1e-30);
}

// One pass for each lamp and each of its points, before which the whole is tried: the first step is its number. As long as a share is
// not known, it is kept as −1 less what has arrived.
@compute @workgroup_size(8, 8)
fn lamp_shadow(@builtin(global_invocation_id) id: vec3<u32>) {
    let y = id.y + frame.first_row;
    if id.x >= frame.width || y >= frame.height {
        return;
    }
    let at = y * frame.width + id.x;
    let hit = stored_hit(at);
    let first = per_thread(frame.first_step, at);
    let index = first / (LAMP_POINTS + 1u);
    let part = first % (LAMP_POINTS + 1u);
    let place = layer_at(1u + index / 4u, at);
    let ray = primary_ray(id.x, y);
    let length = hit.normal_t.w;
    let surface = Ray(ray.origin + ray.direction * length, hit.normal_t.xyz);
    let lamp = lamp_shape(index);
    let seen = seen_from(lamp, surface.origin);
    let way = distance(surface.origin, seen.middle);
    var is_point = seen.radius < NARROW * way;
    var to = seen.middle;
    var radius = max(seen.radius, 0.5 * NARROW * way);
    // What is known without a ray.
    var share = 0.0;
    var weight = 0.0;
    if part > 0u {
        share = colors[place][index % 4u];
        if share > -0.5 {
            return;
        }
        is_point = true;
        to = lamp_point(seen, part - 1u);
        radius = seen.extent / f32(LAMP_POINTS);
        weight = point_share(lamp, seen, part - 1u, surface);
    } else if hit.kind != HIT_NONE {
        let light = lamp_above(index, surface.origin, surface.direction);
        let is_lit = max(light.light.x, max(light.light.y, light.light.z)) > 0.0;
        if is_lit && dot(surface.direction, light.direction) > 0.0 {
            share = -1.0;
            // A lamp across the horizon has no whole cone.
            weight = select(0.0, 1.0, is_point || dot(surface.direction, to - surface.origin) >= seen.radius);
        }
    }
    var least = 1.0;
    if weight > 0.0 {
        least = march_to_lamp(lamp, surface, length, to, radius, is_point);
    }
    if part > 0u {
        let arrived = covered(least) * weight - 1.0 - share;
        share = select(-1.0 - arrived, arrived, part == LAMP_POINTS);
    } else if weight > 0.0 && (is_point || abs(least) >= 1.0) {
        share = covered(least);
    }
    colors[place][index % 4u] = share;
}
