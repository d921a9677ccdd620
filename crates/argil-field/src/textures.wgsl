// GPU version of textures.rs.

fn texture_flat(own: u32, kind: u32, uv: vec2<f32>) -> vec3<f32> {
    if kind == 5u {
        return vec3(texture_brick(uv));
    }
    return texture_image(own, uv);
}

// Returns weights of the two axes that a normal is nearest to.
fn texture_two_weights(normal: vec3<f32>) -> vec3<f32> {
    let size = length(normal);
    if size <= 0.0 {
        return vec3(0.0);
    }
    let facing = normal / size;
    let least = min(facing.x, min(facing.y, facing.z));
    var weights = clamp((facing - 0.57735) / (1.0 - 0.57735), vec3(1e-4), vec3(1.0));
    if facing.z == least {
        weights.z = 0.0;
    } else if facing.y == least {
        weights.y = 0.0;
    } else {
        weights.x = 0.0;
    }
    return weights;
}

// Returns the pattern of the texture whose words begin at `own`.
fn texture_value(own: u32, at: vec3<f32>, local: vec3<f32>, normal: vec3<f32>, normal_in_scene: vec3<f32>) -> vec3<f32> {
    let is_world = texture_word(own + 2u) != 0.0;
    let p = select(local, at, is_world) / texture_word(own + 1u);
    let kind = u32(texture_word(own));
    let parameter = texture_word(own + 3u);
    if kind < 5u {
        return vec3(texture_solid(kind, parameter, p));
    }
    let outward = select(normal, normal_in_scene, is_world);
    let facing = abs(outward);
    let side = select(vec3(1.0), vec3(-1.0), outward < vec3(0.0));
    var weights = facing * facing * facing * facing;
    if parameter == 0.0 {
        weights = texture_two_weights(facing);
    }
    let sum = weights.x + weights.y + weights.z;
    weights = select(vec3(0.0, 1.0, 0.0), weights / sum, sum > 0.0);
    // One call in a loop, because each call copies its code.
    var total = vec3(0.0);
    for (var axis = 0u; axis < 3u; axis++) {
        let across = vec2(p.x, side.y * p.z);
        let along = select(vec2(-side.x * p.z, -p.y), vec2(side.z * p.x, -p.y), axis == 2u);
        if weights[axis] > 0.0 {
            total += texture_flat(own, kind, select(along, across, axis == 1u)) * weights[axis];
        }
    }
    return total;
}

// Returns the normal of a shape at a point of its space, of any length.
fn texture_normal(op: u32, p: vec3<f32>, own: u32, step: f32) -> vec3<f32> {
    var corners = array(vec3(1.0, -1.0, -1.0), vec3(-1.0, -1.0, 1.0), vec3(-1.0, 1.0, -1.0), vec3(1.0, 1.0, 1.0));
    var sum = vec3(0.0);
    for (var i = 0u; i < 4u; i++) {
        sum += corners[i] * shape_distance(op, p + step * corners[i], own);
    }
    return sum;
}

// Returns a brush's material at a point of the scene, and of its shape.
fn brush_material(instr: Instruction, at: vec3<f32>, p: vec3<f32>, own: u32) -> GpuMaterial {
    var material = materials[material_shift + instr.operand];
    let record = 8u * (instr.flags >> TEXTURES_SHIFT);
    if record == 0u {
        return material;
    }
    // The smallest length of a flat pattern, if there is one.
    var size = FAR;
    for (var channel = 0u; channel < 4u; channel++) {
        let texture = 8u * u32(texture_word(record + channel));
        if texture != 0u && texture_word(texture) >= 5.0 {
            size = min(size, texture_word(texture + 1u));
        }
    }
    var normal = vec3(0.0, 1.0, 0.0);
    if size < FAR {
        normal = texture_normal(instr.op, p, own, TEXTURE_NORMAL_STEP * size);
    }
    let w = instr.params;
    let in_scene = vec3(params[w], params[w + 1u], params[w + 2u]) * normal.x
        + vec3(params[w + 4u], params[w + 5u], params[w + 6u]) * normal.y
        + vec3(params[w + 8u], params[w + 9u], params[w + 10u]) * normal.z;
    // In the list of what materials have besides, the last number of the first four is a height.
    let is_besides = material_shift > 0u;
    for (var channel = select(0u, 2u, is_besides); channel < select(3u, 4u, is_besides); channel++) {
        let texture = 8u * u32(texture_word(record + channel));
        if texture == 0u {
            continue;
        }
        let value = texture_value(texture, at, p, normal, in_scene);
        let low = texture_color(texture + 4u);
        let high = texture_color(texture + 8u);
        if channel == 0u {
            material.base_roughness = vec4(mix(low, high, value), material.base_roughness.w);
            continue;
        }
        let gray = mix(low.x, high.x, dot(value, vec3(0.2126, 0.7152, 0.0722)));
        if channel == 1u || channel == 3u {
            material.base_roughness.w = gray;
        } else {
            material.emission_metallic.w = gray;
        }
    }
    return material;
}
