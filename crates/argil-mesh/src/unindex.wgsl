// GPU version of Mesh::unindexed, one triangle per thread: three vertices of its own, with the face normal or the
// original normals.

@compute @workgroup_size(64)
fn unindex(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) count: vec3<u32>) {
    let at = id.x + 64u * count.x * id.y;
    if at >= marching.triangles {
        return;
    }
    var corners: array<vec3<f32>, 3>;
    for (var i = 0u; i < 3u; i++) {
        let begin = 6u * triangles[3u * at + i];
        corners[i] = vec3(vertices[begin], vertices[begin + 1u], vertices[begin + 2u]);
    }
    let n = cross(corners[1] - corners[0], corners[2] - corners[0]);
    let length = sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    let face = n * select(0.0, 1.0 / max(length, 1e-37), length > 0.0);
    for (var i = 0u; i < 3u; i++) {
        let begin = 6u * triangles[3u * at + i];
        let out = 18u * at + 6u * i;
        for (var k = 0u; k < 6u; k++) {
            unindexed[out + k] = vertices[begin + k];
        }
        if per_thread(marching.normals, at) == MARCH_FACE {
            unindexed[out + 3u] = face.x;
            unindexed[out + 4u] = face.y;
            unindexed[out + 5u] = face.z;
        }
    }
}
