// GPU version of dense.rs, one pixel per thread.

@compute @workgroup_size(8, 8)
fn march(@builtin(global_invocation_id) id: vec3<u32>) {
    march_pixel(id, false);
}

@compute @workgroup_size(8, 8)
fn march_and_show(@builtin(global_invocation_id) id: vec3<u32>) {
    march_pixel(id, true);
}

fn march_pixel(id: vec3<u32>, shows: bool) {
    let y = id.y + frame.first_row;
    if id.x >= frame.width || y >= frame.height {
        return;
    }
    let ray = primary_ray(id.x, y);
    let span = primary_span(ray);
    let top = volume.levels - 1u;
    var walk = SurfaceStep(span.x, 0.0, 0.0, false);
    var level = 0u;
    var kind = HIT_NONE;
    var steps = 0u;
    while span.x <= span.y && steps < frame.max_steps {
        steps++;
        let d = stored_distance(ray.origin + ray.direction * walk.t, level);
        var range = volume.band_width * f32(1u << level);
        if level == 0u {
            walk_step(&walk, span.z, d, steps == frame.max_steps);
            if walk.reached {
                kind = walk_kind(walk);
                break;
            }
            if walk.gap >= SATURATED * range {
                // At the start of a ray, nothing is known about the distance.
                level = select(min(top, 1u), top, steps == 1u);
            }
        } else {
            let gap = max(d, 0.0);
            walk.t += gap * frame.inv_lipschitz;
            if gap >= SATURATED * range {
                level = min(top, level + 1u);
            } else {
                while level > 0u && gap < DENSE_NEAR * range {
                    level--;
                    range *= 0.5;
                }
            }
        }
        if walk.t > span.y {
            break;
        }
    }
    let hit = Hit(vec4(walk.side, 0.0, 0.0, walk.t), kind, steps, 0u, 0u, 0u);
    end_walk(y * frame.width + id.x, ray, hit, shows);
}
