// Evaluates the field at given points, one per thread. Its invariants are those of the interpreter.

@compute @workgroup_size(64)
fn query(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= arrayLength(&queries) {
        return;
    }
    let d = field_surface(queries[i].point.xyz);
    answers[i] = QueryResult(vec4(d, 0.0, 0.0, 0.0), field_material.base_roughness, field_material.emission_metallic);
}
