// GPU version of octree.rs, one pixel per thread. `nodes` and `tree_words` are the bound tree.

// The path of Tree::find_from in argil-volume: the nodes from the root to the end of the last look-up.
var<private> path_nodes: array<u32, OCTREE_MAX_DEPTH>;
var<private> path_code: u32;
var<private> path_end: u32;

struct Lookup {
    is_brick: bool,
    nodes: u32,
}

fn first_level(code: u32) -> u32 {
    let root = volume.depth - 1u;
    if path_end >= volume.depth || frame.descent == DESCENT_ROOT {
        return root;
    }
    let differing = 32u - countLeadingZeros(code ^ path_code);
    let shared_level = max((differing + 2u) / 3u, 1u) - 1u;
    return min(max(shared_level, path_end), root);
}

fn find_brick(cell: vec3<u32>) -> Lookup {
    let code = morton(cell);
    let node_count = tree_words[OCTREE_HEADER_NODES];
    if node_count == 0u {
        return Lookup(false, 0u);
    }
    path_nodes[volume.depth - 1u] = node_count - 1u;
    var level = first_level(code);
    path_code = code;
    var visited = 0u;
    loop {
        visited++;
        let node = nodes[path_nodes[level]];
        let bit = (code >> (3u * level)) & 7u;
        path_end = level;
        if ((node.valid_mask >> bit) & 1u) == 0u {
            return Lookup(false, visited);
        }
        if level == 0u {
            return Lookup(true, visited);
        }
        level--;
        let before = countOneBits(node.valid_mask & ((1u << bit) - 1u));
        path_nodes[level] = tree_words[OCTREE_HEADER_LEVELS + level] + node.child_offset + before;
    }
    // Unreachable: the loop descends to level 0 at most.
    return Lookup(false, visited);
}

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
    let edge = f32(volume.brick_size_voxels) * volume.voxel_size;
    let grid = vec3<i32>(vec3(volume.grid_x, volume.grid_y, volume.grid_z));

    // Set up the traversal: the first cell, and where the ray meets the next plane of each axis.
    let d = ray.direction;
    let inverse = vec3(1.0 / not_zero(d.x), 1.0 / not_zero(d.y), 1.0 / not_zero(d.z));
    let start = (ray.origin + d * span.x - volume.corner) / edge;
    var cell = clamp(vec3<i32>(floor(start)), vec3(0), grid - 1);
    let step = select(vec3(1), vec3(-1), inverse < vec3(0.0));
    let ahead = vec3<f32>(max(step, vec3(0)));
    let corner = volume.corner - ray.origin;

    path_end = OCTREE_MAX_DEPTH;
    var walk = SurfaceStep(span.x, 0.0, 0.0, false);
    var entered = 3u;
    var kind = HIT_NONE;
    var steps = 0u;
    var descents = 0u;
    var cells = 0u;
    var mark = 0u;
    var normal = vec3(0.0);
    let mode = per_thread(frame.mode, id.x);
    let shows_boxes = mode == MODE_BRICKS || mode == MODE_NODES;
    if span.x <= span.y && span.z > 0.0 && !shows_boxes {
        // A solid that the volume's box clips is hit at the box, with or without a brick.
        steps = 1u;
        let stored_d = stored_distance(ray.origin + d * span.x, 0u);
        if stored_d < 0.0 {
            walk_step(&walk, span.z, stored_d, false);
            kind = select(HIT_NONE, walk_kind(walk), walk.reached);
        }
    }
    while span.x <= span.y && steps < frame.max_steps && kind == HIT_NONE {
        let visit = find_brick(vec3<u32>(cell));
        cells++;
        descents += visit.nodes;
        steps += 1u + visit.nodes;
        let planes = (corner + (vec3<f32>(cell) + ahead) * edge) * inverse;
        let leave = min(planes.x, min(planes.y, planes.z));
        let end = min(leave, span.y);
        if visit.is_brick {
            if shows_boxes {
                let code = morton(vec3<u32>(cell));
                mark = 1u + select(code, code >> 3u, frame.mode == MODE_NODES);
                kind = HIT_OUTSIDE;
                normal = -d;
                if entered < 3u {
                    normal = select(vec3(0.0), -vec3<f32>(step), vec3(0u, 1u, 2u) == vec3(entered));
                }
                break;
            }
            // March inside the brick.
            while walk.t <= end && steps < frame.max_steps && !walk.reached {
                steps++;
                let stored_d = stored_distance(ray.origin + d * walk.t, 0u);
                walk_step(&walk, span.z, stored_d, steps == frame.max_steps);
            }
            if walk.reached {
                kind = walk_kind(walk);
                break;
            }
        }
        // Advance to the next cell.
        walk.t = leave;
        if planes.x <= planes.y && planes.x <= planes.z {
            entered = 0u;
        } else if planes.y <= planes.z {
            entered = 1u;
        } else {
            entered = 2u;
        }
        cell[entered] += step[entered];
        if leave > span.y || cell[entered] < 0 || cell[entered] >= grid[entered] {
            break;
        }
    }
    if mark == 0u {
        normal = vec3(walk.side, 0.0, 0.0);
    }
    let hit = Hit(vec4(normal, walk.t), kind, steps, descents, cells, mark);
    end_walk(y * frame.width + id.x, ray, hit, shows);
}
