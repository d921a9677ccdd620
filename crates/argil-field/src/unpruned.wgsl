// The interpreter's list for the whole program.

const MARKING: bool = false;

fn list_length() -> u32 {
    return arrayLength(&instructions);
}

fn listed(place: u32) -> u32 {
    return place;
}

fn mark_at(place: u32, loops: u32) {}

fn mark(a: f32, b: f32, j: Joint, flags: u32, is_group: bool) {}
