// GPU version of sampler.rs in argil-volume's levels: finds the finest usable cell at a point.

// A cell, and the position of a point in it.
struct LevelCell {
    cell: u32,
    word: u32,
    level: u32,
    // By how many levels it is too coarse although a finer cell can exist.
    gap: f32,
    // The cell whose brick or page is missing, and the place of that page's cell, or `OWN_BRICK`, or `NOTHING`.
    lacks: u32,
    lacks_child: u32,
    voxel: f32,
    inner: vec3<f32>,
}

const OWN_BRICK: u32 = 8u;
const NOTHING: u32 = 9u;

// Returns a level for voxels of a size at most.
fn level_of(size: f32) -> u32 {
    let exponent = i32(bitcast<u32>(size / volume.voxel_size) >> 23u) - 127;
    return u32(clamp(exponent, 0, i32(volume.root)));
}

// Returns the page of the coarsest level that contains a voxel.
fn root_of(voxel: vec3<i32>) -> u32 {
    let low = vec3(volume.root_x, volume.root_y, volume.root_z);
    let size = vec3<i32>(vec3(volume.roots_x, volume.roots_y, volume.roots_z));
    let at = vec3<u32>(clamp((voxel >> vec3(PAGE_VOXELS_LOG2 + volume.root)) - low, vec3(0), size - 1));
    return cells[at.x + volume.roots_x * (at.y + volume.roots_y * at.z)];
}

// Returns the nearest cell with a resident brick above one.
fn resident_above(missing: u32) -> u32 {
    var cell = missing;
    loop {
        let parent = page_parent(cell / 8u);
        if parent == NO_PAGE || cell_word(cell) != MISSING_BRICK {
            break;
        }
        cell = parent;
    }
    return cell;
}

// Finds the cell of a voxel on a level or a coarser one. The search begins at a page.
fn search(voxel: vec3<i32>, wanted: u32, start: u32) -> LevelCell {
    var slot = start;
    var level = page_level(slot);
    loop {
        let away = bitcast<vec3<u32>>(voxel - page_origin(slot));
        let is_inside = all(away < vec3(1u << (PAGE_VOXELS_LOG2 + level)));
        if is_inside && level >= wanted {
            break;
        }
        let parent = page_parent(slot);
        if parent == NO_PAGE {
            slot = select(root_of(voxel), slot, is_inside);
            break;
        }
        slot = parent / 8u;
        level = page_level(slot);
    }
    var found = LevelCell(0u, 0u, 0u, 0.0, 0u, NOTHING, 1.0, vec3(0.0));
    loop {
        found.cell = 8u * slot + octant_of(voxel, level + PAGE_VOXELS_LOG2 - 1u);
        found.word = cell_word(found.cell);
        if !is_brick(found.word) {
            break;
        }
        let child = cell_child(found.cell);
        if level > wanted && child < UNKNOWN_CELL {
            slot = child;
            level--;
            continue;
        }
        if found.word == MISSING_BRICK {
            found.lacks = found.cell;
            found.lacks_child = OWN_BRICK;
            found.cell = resident_above(found.cell);
            found.word = cell_word(found.cell);
            let own = page_level(found.cell / 8u);
            found.gap = max(f32(own - min(wanted, level)), 1.0);
            level = own;
        } else if level > wanted && child == NO_PAGE {
            found.lacks = found.cell;
            found.lacks_child = octant_of(voxel, level + PAGE_VOXELS_LOG2 - 2u);
            found.gap = f32(level - wanted);
        }
        break;
    }
    found.level = level;
    found.voxel = volume.voxel_size * level_scale(level);
    return found;
}

// Sets the position of a point in its cell. The point is in voxels, counted from the camera's.
fn placed(cell: LevelCell, point: vec3<f32>) -> LevelCell {
    var found = cell;
    let origin = vec3<f32>(page_origin(cell.cell / 8u) - eye_voxel());
    let place = (point - origin) * bitcast<f32>((127u - cell.level) << 23u);
    found.inner = clamp(place - 8.0 * octant_place(cell.cell & 7u), vec3(0.0), vec3(8.0));
    return found;
}

// Finds the cell at an offset from the camera.
fn locate(away: vec3<f32>, wanted: u32, start: u32) -> LevelCell {
    let point = volume.eye_inner + away * (1.0 / volume.voxel_size);
    let first = vec3(volume.first_x, volume.first_y, volume.first_z);
    let last = vec3(volume.last_x, volume.last_y, volume.last_z);
    let whole = vec3<i32>(floor(clamp(point, vec3(-1e9), vec3(1e9))));
    return placed(search(clamp(eye_voxel() + whole, first, last), wanted, start), point);
}

// Finds the nearest cell with a brick above a cell without one, at the same offset from the camera. Only where the
// coarsest level has no brick either, the cell has none.
fn brick_above(empty: LevelCell, away: vec3<f32>) -> LevelCell {
    let above = page_parent(empty.cell / 8u);
    if is_brick(empty.word) || above == NO_PAGE {
        return empty;
    }
    var found = empty;
    found.cell = above;
    if cell_word(above) == MISSING_BRICK {
        found.lacks = above;
        found.lacks_child = OWN_BRICK;
        found.cell = resident_above(above);
    }
    found.word = cell_word(found.cell);
    found.level = page_level(found.cell / 8u);
    found.voxel = volume.voxel_size * level_scale(found.level);
    return placed(found, volume.eye_inner + away * (1.0 / volume.voxel_size));
}
