// What rays of an image do about pages that are missing: they ask for them, and stop before what those may hold.

fn set_bits(at: u32, bits: u32) {
    if (atomicLoad(&feedback[at]) & bits) != bits {
        atomicOr(&feedback[at], bits);
    }
}

// Notes that a ray used a cell, and what it lacked.
fn note(found: LevelCell) {
    set_bits(FEEDBACK_HEAD + FEEDBACK_WORDS * (found.cell / 8u), 1u << (found.cell & 7u));
    if found.lacks_child == NOTHING {
        return;
    }
    let inner = found.lacks & 7u;
    let at = FEEDBACK_HEAD + FEEDBACK_WORDS * (found.lacks / 8u);
    if found.lacks_child == OWN_BRICK {
        set_bits(at, 256u << inner);
    } else {
        set_bits(at + 1u + inner / 4u, 1u << (8u * (inner & 3u) + found.lacks_child));
    }
}

// Returns how much nearer than interpolated the surface may be, because a finer page is missing.
fn doubt_of(found: LevelCell) -> f32 {
    return select(0.0, volume.error_voxels * found.voxel, found.gap > 0.0);
}
