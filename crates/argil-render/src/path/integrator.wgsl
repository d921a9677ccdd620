// GPU version of integrator.rs: what happens at the end of a ray.

// Adds light that passed as many surfaces as the path has.
fn add_light(light: vec3<f32>) {
    if way.bounce > 0u {
        way.light += clamped(light);
    } else if max(light.x, max(light.y, light.z)) < UNLIMITED {
        way.light += light;
    }
}

fn note_first(albedo: vec3<f32>, normal: vec3<f32>, hit: PathSurface) {
    if way.bounce == 0u {
        way.albedo = albedo;
        way.normal = normal;
        way.distance = select(0.0, hit.distance, hit.is_there);
        way.covered = select(0.0, 1.0, hit.is_solid);
    }
}

// Looks for a light from a point, which sends `arrives`. It is added when its ray has found nothing in the way.
fn look_for(origin: vec3<f32>, point: EmitterPoint, arrives: vec3<f32>) {
    let reach = min(frame.far, point.distance);
    let down = (frame.ground_y - origin.y) / point.direction.y;
    let is_under = point.direction.y < 0.0 && down > 0.0 && down < reach && frame.has_ground != 0u;
    let brightest = max(arrives.x, max(arrives.y, arrives.z));
    if is_under || !(brightest > 0.0) {
        return;
    }
    way.arrives = arrives * fog_transmitted(origin, point.direction, reach);
    way.shadow_origin = origin;
    way.shadow_direction = point.direction;
    way.shadow_reach = reach;
    way.phase = PATH_SHADOW;
}

fn turn_in_fog(length: f32) -> bool {
    way.carried *= frame.fog_albedo;
    if way.bounce == paths.max_bounces {
        return false;
    }
    let origin = way.origin + length * way.direction;
    let which = random_one();
    let point = light_sample(origin, which, random_pair());
    if point.distance >= 0.0 {
        let share = fog_phase(dot(way.direction, point.direction));
        look_for(origin, point, way.carried * point.radiance * (share * power_share(point.density, share)));
    }
    let next = fog_scattered(way.direction, random_pair());
    way.origin = origin;
    way.direction = next.xyz;
    way.density = next.w;
    return true;
}

// Returns a shading normal on the viewer's side. `outward` is the direction in which rays leave the surface.
fn seen_normal(shading: vec3<f32>, outward: vec3<f32>, toward: vec3<f32>) -> vec3<f32> {
    let facing = dot(shading, toward);
    if facing >= 0.01 {
        return shading;
    }
    return normalize(shading + (0.01 - facing) * toward);
}

fn pass_glass(hit: PathSurface, lift: f32) -> bool {
    let toward = -way.direction;
    let is_inside = way.is_inside != 0u;
    var side = select(1.0, -1.0, is_inside);
    side = select(side, -side, dot(side * hit.normal, toward) < -0.5);
    let outward = side * hit.normal;
    let normal = seen_normal(side * hit.shading_normal, outward, toward);
    let index = max(hit.refractive_index, 1.0);
    let ratio = select(1.0 / index, index, is_inside);
    let choice = random_one();
    let next = glass_sample(normal, toward, hit.material.base_roughness.w, ratio, choice, random_pair());
    if !next.goes {
        return false;
    }
    way.carried *= next.weight;
    let away = select(outward, -outward, next.is_through);
    if next.is_through {
        let base = hit.material.base_roughness.xyz;
        if hit.attenuation <= 0.0 {
            // Half of the color at each of two surfaces.
            way.carried *= sqrt(base);
        }
        way.absorption = -log(max(base, vec3(1e-4))) * hit.attenuation;
        way.is_inside = select(1u, 0u, is_inside);
    }
    way.origin = hit.point + away * lift;
    way.direction = next.direction;
    way.density = UNLIMITED;
    return dot(next.direction, away) > 0.0;
}

// Adds the light of a surface, and chooses how a path goes on from it. Returns whether it goes on.
fn meet(hit: PathSurface) -> bool {
    let toward = -way.direction;
    if way.is_inside != 0u {
        way.carried *= exp(-way.absorption * hit.distance);
    }
    if !hit.is_solid {
        let haze = clamp(hit.distance / frame.far * 2.2, 0.0, 1.0);
        if way.bounce == 0u && paths.is_transparent != 0u {
            way.opacity = 1.0 - haze;
        } else {
            add_light(way.carried * path_background(way.direction) * haze);
        }
        way.carried *= 1.0 - haze;
    }
    let most = max(abs(hit.point.x), max(abs(hit.point.y), abs(hit.point.z)));
    let lift = max(paths.lift, 2.4e-7 * most);
    let glass = hit.transmission * (1.0 - hit.material.emission_metallic.w);
    if glass > 0.0 && (way.is_inside != 0u || random_one() < glass) {
        note_first(vec3(1.0), hit.normal, hit);
        return pass_glass(hit, lift);
    }
    let flip = select(1.0, -1.0, dot(hit.normal, toward) < -0.5);
    let outward = flip * hit.normal;
    let normal = seen_normal(flip * hit.shading_normal, outward, toward);
    add_light(way.carried * hit.material.emission_metallic.xyz);
    let own = bsdf_of(hit.material, normal, toward);
    note_first(select(own.albedo, vec3(1.0), frame.fog_density > 0.0), normal, hit);
    if way.bounce == paths.max_bounces {
        return false;
    }
    let start = hit.point + outward * lift;
    // Normals that a texture turns must not let light through the surface.
    let is_turned = any(hit.shading_normal != hit.normal);
    let which = random_one();
    let point = light_sample(hit.point, which, random_pair());
    if point.distance >= 0.0 && (!is_turned || dot(point.direction, outward) > 0.0) {
        let reflected = bsdf_reflected(own, point.direction * own.axes);
        let share = power_share(point.density, reflected.w);
        look_for(start, point, way.carried * reflected.xyz * point.radiance * share);
    }
    let lobe = random_one();
    let to = bsdf_sample(own, lobe, random_pair());
    let next = bsdf_reflected(own, to);
    let direction = normalize(own.axes * to);
    way.carried *= next.xyz / max(next.w, 1e-30);
    way.origin = start;
    way.direction = direction;
    way.density = next.w;
    return next.w > 0.0 && dot(direction, normal) > 0.0 && (!is_turned || dot(direction, outward) > 0.0);
}
