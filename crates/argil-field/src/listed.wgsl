// The interpreter's list: a range of `lists`.

// Its first index, and its length.
var<private> list: vec2<u32>;

fn list_length() -> u32 {
    return list.y;
}

fn listed(place: u32) -> u32 {
    return lists[list.x + place];
}
