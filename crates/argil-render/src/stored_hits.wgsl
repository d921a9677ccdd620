// Stores and reads what rays hit, in the bound records.

fn stored_hit(at: u32) -> Hit {
    return hit_of(hits[at]);
}

fn store_surface(at: u32, hit: Hit) {
    hits[at] = surface_record(hit);
}

fn store_hit(at: u32, hit: Hit) {
    store_surface(at, hit);
    if (per_thread(frame.records, at) & RECORD_COUNTS) != 0u {
        hits[counts_at(at)] = vec4(hit.steps, hit.descents, hit.cells, hit.id);
    }
}

// A hit with what the ray did, if that is stored.
fn counted_hit(at: u32) -> Hit {
    var hit = stored_hit(at);
    if (per_thread(frame.records, at) & RECORD_COUNTS) != 0u {
        let counts = hits[counts_at(at)];
        hit.steps = counts.x;
        hit.descents = counts.y;
        hit.cells = counts.z;
        hit.id = counts.w;
    }
    return hit;
}
