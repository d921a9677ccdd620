// GPU version of path.rs. A thread follows the paths of a pixel, one after another, from ray to ray: `march_paths` marches, and
// `turn_paths` chooses where to go on.

var<private> way: PathState;

// Returns the direction of a place in the image.
fn path_direction(place: vec2<f32>) -> vec3<f32> {
    let across = place.x / f32(frame.width) * 2.0 - 1.0;
    let up = 1.0 - place.y / f32(frame.height) * 2.0;
    return normalize(frame.forward + frame.right * across + frame.up * up);
}

// Begins a path of a pixel.
fn begin_path(pixel: u32, done: u32) {
    way = PathState();
    way.index = paths.first_sample + done;
    way.seed = mixed(pixel ^ 0x9e3779b9u);
    way.opacity = 1.0;
    way.carried = vec3(1.0);
    way.density = UNLIMITED;
    way.origin = frame.eye;
    let place = vec2(f32(pixel % frame.width), f32(pixel / frame.width)) + random_pair();
    way.direction = path_direction(place);
    let on_lens = random_pair();
    if per_thread(u32(paths.lens_radius > 0.0), pixel) != 0u {
        let sharp = frame.eye + way.direction * (paths.lens_focus / max(dot(way.direction, frame.forward), 1e-4));
        let turn = TAU * on_lens.y;
        let aside = direction_or_zero(frame.right) * cos(turn) + direction_or_zero(frame.up) * sin(turn);
        way.origin = frame.eye + paths.lens_radius * sqrt(on_lens.x) * aside;
        way.direction = normalize(sharp - way.origin);
    }
}

// Adds what a path found to its pixel.
fn end_path(index: u32) {
    let before = pixels.rows[index];
    pixels.rows[index] = PathPixel(
        before.light + way.light,
        before.count + 1u,
        before.squares + way.light * way.light,
        before.covered + way.covered,
        before.albedo + way.albedo,
        before.distance + way.distance,
        before.normal + way.normal,
        before.opacity + way.opacity,
    );
}

// Goes on from the end of a ray. Returns whether the path goes on.
fn turn() -> bool {
    let hit = surface_met();
    var reach = select(UNLIMITED, hit.distance, hit.is_there);
    var length = UNLIMITED;
    if way.is_inside == 0u && frame.fog_density > 0.0 {
        length = fog_length(way.origin, way.direction, -log(1.0 - random_one()));
    }
    let is_in_fog = length < min(reach, frame.far);
    if is_in_fog {
        reach = length;
    }
    add_light(way.carried * lights_passed(way.origin, way.direction, reach, way.density));
    if is_in_fog {
        // A denoiser looks at the surface behind the fog, which is the same for all paths.
        note_first(vec3(1.0), hit.normal, hit);
        return turn_in_fog(length);
    }
    if hit.is_there {
        return meet(hit);
    }
    if way.bounce == 0u && frame.fog_density > 0.0 {
        way.albedo = vec3(1.0);
    }
    if way.bounce == 0u && paths.is_transparent != 0u {
        way.opacity = 0.0;
    } else {
        add_light(way.carried * lights_behind(way.origin, way.direction, way.density));
    }
    return false;
}

// Whether chance lets a path go on, which carries more then.
fn survives() -> bool {
    if way.bounce < CERTAIN_BOUNCES {
        return true;
    }
    let chance = min(max(way.carried.x, max(way.carried.y, way.carried.z)), 0.95);
    let goes_on = random_one() < chance;
    way.carried /= max(chance, 1e-30);
    return goes_on;
}

@compute @workgroup_size(64)
fn turn_paths(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = id.x;
    if index >= paths.pixel_count {
        return;
    }
    way = states[index];
    if way.phase == PATH_SHADOW || way.phase == PATH_RAY || way.phase == PATH_DONE {
        return;
    }
    var goes_on = false;
    if way.phase != PATH_NEW && way.phase != PATH_ENDED {
        goes_on = turn();
        // What a light sends is on its way.
        let is_lit = way.phase == PATH_SHADOW;
        goes_on = goes_on && survives();
        way.bounce++;
        goes_on = goes_on && way.bounce <= paths.max_bounces;
        way.ends = select(1u, 0u, goes_on);
        if is_lit {
            states[index] = way;
            let is_near = begin_march(index, way.shadow_origin, way.shadow_direction, way.shadow_reach);
            states[index].phase = PATH_SHADOW;
            if !is_near {
                states[index].phase = end_shadow(index, true);
            }
            return;
        }
    }
    if !goes_on {
        if way.phase != PATH_NEW {
            end_path(index);
        }
        let done = pixels.rows[index].count;
        if done >= paths.sample_count {
            states[index].phase = PATH_DONE;
            atomicAdd(&pixels.finished, 1u);
            return;
        }
        begin_path(paths.first_pixel + index, done);
    }
    states[index] = way;
    states[index].phase = begin_ray(index);
}
