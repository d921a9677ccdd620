// The interpreter without marks: nothing is pruned while it runs.

const MARKING: bool = false;

fn mark_at(place: u32, loops: u32) {}

fn mark(a: f32, b: f32, j: Joint, flags: u32, is_group: bool) {}
