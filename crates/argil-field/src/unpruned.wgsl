// The interpreter's list for the whole program.

fn list_length() -> u32 {
    return arrayLength(&instructions);
}

fn listed(place: u32) -> u32 {
    return place;
}
