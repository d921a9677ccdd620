// Made from argil-abi by `cargo xtask generate`. Do not edit.
const OP_FIRST_ITERATIVE: u32 = 48u;
const OP_SHAPES_END: u32 = 64u;
const OP_PUSH_VALUE: u32 = 64u;
const OP_COMBINE: u32 = 65u;
const OP_PUSH_POINT: u32 = 66u;
const OP_POP_POINT: u32 = 67u;
const OP_AFFINE: u32 = 68u;
const OP_MIRROR: u32 = 69u;
const OP_ELONGATE: u32 = 70u;
const OP_REPEAT: u32 = 71u;
const OP_RADIAL: u32 = 72u;
const OP_NEXT: u32 = 73u;
const OP_TWIST: u32 = 74u;
const OP_BEND: u32 = 75u;
const OP_UNCLAMP: u32 = 76u;
const OP_ROUND: u32 = 77u;
const OP_SHELL: u32 = 78u;
const OP_DISPLACE: u32 = 79u;
const OP_FLATTEN: u32 = 80u;
const OP_EXTRUDE: u32 = 81u;
const OP_REVOLVE: u32 = 82u;
const OP_SHIFT: u32 = 83u;
const OP_WRAP: u32 = 84u;
const OP_UNWRAP: u32 = 85u;
const OP_RAMP: u32 = 86u;
const COMBINE_SMOOTH: u32 = 0u;
const COMBINE_CHAMFER: u32 = 1u;
const COMBINE_PAINT: u32 = 2u;
const COMBINE_MORPH: u32 = 3u;
const COMBINE_RAMPED: u32 = 4u;
const COMBINE_MASK: u32 = 7u;
const FLAG_SWAPPED: u32 = 8u;
const FLAG_KEEP_MATERIAL: u32 = 16u;
const FLAG_TRANSLATION: u32 = 32u;
const FLAG_BOUNDED: u32 = 64u;
const FLAG_PAINT: u32 = 128u;
const TEXTURES_SHIFT: u32 = 8u;
const BRUSH_HEADER_WORDS: u32 = 18u;
const PARAMS_ALIGNMENT: u32 = 4u;
const COLUMN_OPCODE_MASK: u32 = 127u;
const COLUMN_TRANSLATION: u32 = 128u;
const COLUMN_UNION: u32 = 256u;
const COLUMN_SWAPPED: u32 = 512u;
const COLUMN_QUICK: u32 = 1024u;
const COLUMN_RECORD_SHIFT: u32 = 12u;
const PIECE_WORDS: u32 = 8u;
const SAMPLED_HEADER: u32 = 8u;
const SAMPLED_SUMMARY: u32 = 16u;
const MODE_SHADED: u32 = 0u;
const MODE_NORMAL: u32 = 1u;
const MODE_DEPTH: u32 = 2u;
const MODE_HEAT: u32 = 3u;
const MODE_BRICKS: u32 = 4u;
const MODE_NODES: u32 = 5u;
const MODE_LEVELS: u32 = 6u;
const MATERIAL_SIDE: u32 = 4u;
const BRICK_MIXED: u32 = 2147483648u;
const BLOCK_SIDE: u32 = 4u;
const BUILD_BLOCKS: u32 = 0u;
const BUILD_COUNT_ONLY: u32 = 1u;
const COUNTER_CANDIDATES: u32 = 0u;
const COUNTER_BRICKS: u32 = 1u;
const COUNTER_MIXED: u32 = 2u;
const COUNTER_LISTS: u32 = 3u;
const COUNTER_FREED: u32 = 4u;
const COUNTER_FREED_MIXED: u32 = 5u;
const COUNTER_FREE: u32 = 6u;
const COUNTER_FREE_MIXED: u32 = 7u;
const COUNTER_HIGH_WATER: u32 = 8u;
const COUNTER_HIGH_WATER_MIXED: u32 = 9u;
const COUNTER_FILLED: u32 = 10u;
const COUNTER_ADDED: u32 = 11u;
const COUNTER_REMOVED: u32 = 12u;
const COUNTERS: u32 = 16u;
const NORMALS_VOXEL: u32 = 0u;
const NORMALS_SMOOTH: u32 = 1u;
const NORMALS_FIELD: u32 = 2u;
const HIT_NONE: u32 = 0u;
const HIT_OUTSIDE: u32 = 1u;
const HIT_INSIDE: u32 = 2u;
const HIT_GROUND: u32 = 3u;
const HIT_PENDING: u32 = 4u;
const HIT_KIND_BIT: u32 = 1073741824u;
const RECORD_HITS: u32 = 1u;
const RECORD_COUNTS: u32 = 2u;
const GPU_STACK_SLOTS: u32 = 32u;
const DESCENT_ROOT: u32 = 0u;
const DESCENT_PATH: u32 = 1u;
const OCTREE_MAX_DEPTH: u32 = 8u;
const OCTREE_HEADER_BRICKS: u32 = 0u;
const OCTREE_HEADER_NODES: u32 = 1u;
const OCTREE_HEADER_LEVELS: u32 = 2u;
const OCTREE_HEADER_WORDS: u32 = 16u;
const MARCH_NONE: u32 = 0u;
const MARCH_GRADIENT: u32 = 1u;
const MARCH_FIELD: u32 = 2u;
const MARCH_FACE: u32 = 3u;
const DISPATCH_ROW: u32 = 32768u;
const BIND_FRAME: u32 = 0u;
const BIND_INSTRS: u32 = 1u;
const BIND_PARAMS: u32 = 2u;
const BIND_MATERIALS: u32 = 3u;
const BIND_HITS: u32 = 4u;
const BIND_COLORS: u32 = 5u;
const BIND_QUERIES: u32 = 6u;
const BIND_ANSWERS: u32 = 7u;
const BIND_VOLUME: u32 = 8u;
const BIND_STORED: u32 = 9u;
const BIND_LINEAR: u32 = 10u;
const BIND_NODES: u32 = 11u;
const BIND_TREE_WORDS: u32 = 12u;
const BIND_FILL: u32 = 13u;
const BIND_TEXELS: u32 = 14u;
const BIND_OCCUPIED: u32 = 15u;
const BIND_CENTERS: u32 = 16u;
const BIND_KEYS: u32 = 17u;
const BIND_ARGUMENTS: u32 = 18u;
const BIND_CELLS: u32 = 19u;
const BIND_BRICK_MATERIALS: u32 = 20u;
const BIND_CANDIDATES: u32 = 21u;
const BIND_COUNTERS: u32 = 22u;
const BIND_REQUESTS: u32 = 23u;
const BIND_LISTS: u32 = 24u;
const BIND_PRUNE: u32 = 25u;
const BIND_OLD_MATERIALS: u32 = 26u;
const BIND_OLD_POOL: u32 = 27u;
const BIND_RASTER: u32 = 28u;
const BIND_MARCHING: u32 = 29u;
const BIND_CASES: u32 = 30u;
const BIND_OWNERS: u32 = 31u;
const BIND_UNITS: u32 = 32u;
const BIND_UNIT_GROUPS: u32 = 33u;
const BIND_EDGE_ROWS: u32 = 34u;
const BIND_VERTICES: u32 = 35u;
const BIND_TRIANGLES: u32 = 36u;
const BIND_SPANS: u32 = 37u;
const BIND_UNINDEXED: u32 = 38u;
const BIND_PIXELS: u32 = 39u;
const BIND_COUNTS: u32 = 40u;
const BIND_FEEDBACK: u32 = 41u;
const BIND_LIGHT_WORDS: u32 = 42u;
const BIND_LIGHT_STORED: u32 = 43u;
const BIND_PATHS: u32 = 44u;
const BIND_PATH_STATES: u32 = 45u;
const BIND_PATH_PIXELS: u32 = 46u;
const BIND_PATH_TABLES: u32 = 47u;
const BIND_ENVIRONMENT: u32 = 48u;
const BIND_KEPT_COLORS: u32 = 49u;
const BIND_KEPT_DISTANCES: u32 = 50u;
const BIND_MOVED: u32 = 51u;
const BIND_MOTIONS: u32 = 52u;
const PATH_NEW: u32 = 0u;
const PATH_SHADOW: u32 = 1u;
const PATH_RAY: u32 = 2u;
const PATH_MET: u32 = 3u;
const PATH_INSIDE: u32 = 4u;
const PATH_MISSED: u32 = 5u;
const PATH_ENDED: u32 = 6u;
const PATH_DONE: u32 = 7u;
const PATH_STEPS: u32 = 4096u;
const CERTAIN_BOUNCES: u32 = 3u;
const ALBEDO_SIDE: u32 = 32u;
const LIGHT_SUN: u32 = 0u;
const LIGHT_SPHERE: u32 = 1u;
const LIGHT_RECTANGLE: u32 = 2u;
const LIGHT_ENVIRONMENT: u32 = 3u;
const MAX_LAMPS: u32 = 8u;
const LAMP_STEPS: u32 = 48u;
const LAMP_SHADOW_STEPS: u32 = 48u;
const LAMP_POINTS: u32 = 16u;
const COLOR_LAYERS: u32 = 5u;
const FOG_LAYER: u32 = 3u;
const BENT_LAYER: u32 = 4u;
const FOG_PLACES: u32 = 8u;
const TONE_ACES: u32 = 0u;
const TONE_AGX: u32 = 1u;
const TONE_NONE: u32 = 2u;
const BACKGROUND_SKY: u32 = 0u;
const BACKGROUND_EVEN: u32 = 1u;
const BACKGROUND_IMAGE: u32 = 2u;
const FAR: f32 = 1e30;
const WORLD_LIMIT: f32 = 10000000.0;
const WRAP_TRUSTED: f32 = 0.75;
const TAPER_STEPS: u32 = 4u;
const SMALL_GAIN: f32 = 1e-6;
const STRAIGHT_CURVE: f32 = 0.001;
const TUBE_WORDS: u32 = 17u;
const SHADOW_SHARPNESS: f32 = 14.0;
const SHADOW_STEPS: u32 = 64u;
const OCCLUSION_TAPS: u32 = 5u;
const TEXTURE_NORMAL_STEP: f32 = 0.005;
const SUN_LIGHT = vec3<f32>(3.3, 3.05, 2.65);
const ZENITH = vec3<f32>(0.3, 0.45, 0.72);
const HORIZON = vec3<f32>(0.8, 0.86, 0.92);
const NADIR = vec3<f32>(0.44, 0.45, 0.47);
const CONE_SIDE: u32 = 8u;
const CONE_STEPS: u32 = 64u;
const CONE_RADIUS: f32 = 5.7;
const SATURATED: f32 = 0.99;
const DENSE_NEAR: f32 = 0.28;
const NEAR_VOXELS: f32 = 0.2;
const MIN_WEIGHT: f32 = 0.001;
const MATERIAL_OWN_RATIO: f32 = 1.48;
const RELAXATION: f32 = 0.9;
const EXACT_STEPS: u32 = 24u;
const NUDGE_VOXELS: f32 = 0.001;
const NUDGE_RELATIVE: f32 = 5e-7;
const NUDGE_POSITION: f32 = 2.5e-7;
const UNITS_PER_GROUP: u32 = 256u;
const MIN_EDGE_FRACTION: f32 = 0.00390625;
const WORD_EMPTY: u32 = 2147483648u;
const WORD_BLOCK_EMPTY: u32 = 1u;
const FAR_ENTRY: u32 = 2147483648u;
const FAR_SLOTS: u32 = 16u;
const NO_PAGE: u32 = 4294967295u;
const UNKNOWN_CELL: u32 = 4294967293u;
const MISSING_BRICK: u32 = 2147483647u;
const PAGE_VOXELS_LOG2: u32 = 4u;
const RECORD_WORDS: u32 = 24u;
const FEEDBACK_HEAD: u32 = 2u;
const FEEDBACK_WORDS: u32 = 3u;
const LIGHT_KNOWN: f32 = 0.9;
const LIGHT_ROW: u32 = 1024u;
const LIGHT_HEAD: u32 = 24u;
const LIGHT_VOXELS: f32 = 2.0;
const MIN_STEP_VOXELS: f32 = 0.25;
const LIFT_VOXELS: f32 = 1.5;
const CONE_VOXELS: f32 = 2.0;
const LEVEL_MISSING: u32 = 64u;
const LEVEL_DITHER: f32 = 0.3;
struct Instruction {
    op: u32,
    flags: u32,
    params: u32,
    operand: u32,
}
struct GpuMaterial {
    base_roughness: vec4<f32>,
    emission_metallic: vec4<f32>,
}
struct FrameUniform {
    eye: vec3<f32>,
    inv_lipschitz: f32,
    right: vec3<f32>,
    jitter_x: f32,
    up: vec3<f32>,
    jitter_y: f32,
    forward: vec3<f32>,
    ground_y: f32,
    box_min: vec3<f32>,
    epsilon: f32,
    box_max: vec3<f32>,
    normal_bias: f32,
    sun: vec3<f32>,
    radius: f32,
    width: u32,
    height: u32,
    first_row: u32,
    max_steps: u32,
    mode: u32,
    sample_weight: f32,
    far: f32,
    depth_near: f32,
    depth_far: f32,
    pixel_width: f32,
    first_step: u32,
    step_count: u32,
    light_offset: f32,
    normals: u32,
    has_ground: u32,
    descent: u32,
    eye_right: vec3<f32>,
    close_slope: f32,
    eye_up: vec3<f32>,
    records: u32,
    sun_light: vec3<f32>,
    exposure: f32,
    zenith: vec3<f32>,
    tone: u32,
    horizon: vec3<f32>,
    glow: f32,
    nadir: vec3<f32>,
    lamp_count: u32,
    fog_albedo: vec3<f32>,
    fog_density: f32,
    fog_falloff: f32,
    fog_height: f32,
    fog_anisotropy: f32,
    has_bent_normals: u32,
    near_plane: vec4<f32>,
    lamps: array<vec4<f32>, 32>,
}
struct QueryPoint {
    point: vec4<f32>,
}
struct QueryResult {
    distance: vec4<f32>,
    base_roughness: vec4<f32>,
    emission_metallic: vec4<f32>,
}
struct DenseUniform {
    corner: vec3<f32>,
    band_width: f32,
    extent: vec3<f32>,
    voxel_size: f32,
    size_x: u32,
    size_y: u32,
    size_z: u32,
    levels: u32,
    grid_x: u32,
    grid_y: u32,
    grid_z: u32,
    max_code: u32,
}
struct OctreeUniform {
    corner: vec3<f32>,
    band_width: f32,
    extent: vec3<f32>,
    voxel_size: f32,
    grid_x: u32,
    grid_y: u32,
    grid_z: u32,
    brick_size_voxels: u32,
    depth: u32,
    code_count: u32,
    max_center_distance: f32,
    sample_margin: f32,
}
struct CellTable {
    tree_x: i32,
    tree_y: i32,
    tree_z: i32,
    levels: u32,
    top_x: u32,
    top_y: u32,
    top_z: u32,
    slots_at: u32,
    words_at: u32,
    cells: u32,
    pad0: u32,
    pad1: u32,
}
struct BrickUniform {
    corner: vec3<f32>,
    band_width: f32,
    extent: vec3<f32>,
    voxel_size: f32,
    inv_pool_size: vec3<f32>,
    slope: f32,
    size_x: u32,
    size_y: u32,
    size_z: u32,
    brick_size_voxels: u32,
    begin_x: i32,
    begin_y: i32,
    begin_z: i32,
    capacity: u32,
    low_x: i32,
    low_y: i32,
    low_z: i32,
    pool_x: u32,
    high_x: i32,
    high_y: i32,
    high_z: i32,
    pool_y: u32,
    table: CellTable,
    max_code: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}
struct LevelsUniform {
    eye_inner: vec3<f32>,
    voxel_size: f32,
    box_min: vec3<f32>,
    error_voxels: f32,
    box_max: vec3<f32>,
    steepness: f32,
    eye_x: i32,
    eye_y: i32,
    eye_z: i32,
    root: u32,
    first_x: i32,
    first_y: i32,
    first_z: i32,
    records_at: u32,
    last_x: i32,
    last_y: i32,
    last_z: i32,
    materials_at: u32,
    root_x: i32,
    root_y: i32,
    root_z: i32,
    mixed_at: u32,
    roots_x: u32,
    roots_y: u32,
    roots_z: u32,
    pool_x: u32,
    pool_y: u32,
    pixel_error: f32,
    band_voxels: f32,
    pad0: u32,
}
struct BrickBuildUniform {
    corner: vec3<f32>,
    voxel_size: f32,
    low_x: i32,
    low_y: i32,
    low_z: i32,
    brick_size_voxels: u32,
    high_x: i32,
    high_y: i32,
    high_z: i32,
    is_clipped: u32,
    table: CellTable,
    max_center_distance: f32,
    half_diagonal: f32,
    lipschitz: f32,
    far: f32,
    pool_x: u32,
    pool_y: u32,
    capacity: u32,
    chunk: u32,
    chunks: u32,
    mixed: u32,
    pad0: u32,
    pad1: u32,
}
struct FillUniform {
    first_bias: vec4<f32>,
    spacing_scale: vec4<f32>,
    size_x: u32,
    size_y: u32,
    size_z: u32,
    first_layer: u32,
    layer_count: u32,
    tile: u32,
    max_code: u32,
    pad0: u32,
}
struct PruneUniform {
    slack: f32,
    blocks_first: u32,
    cells_first: u32,
    arena_first: u32,
    arena_words: u32,
    cells_room: u32,
    count: u32,
    build_mode: u32,
    blocks_at: u32,
    dirty_first: u32,
    freed_first: u32,
    bounds_first: u32,
}
struct NearUniform {
    corner: vec3<f32>,
    inv_edge: f32,
    blocks_x: u32,
    blocks_y: u32,
    blocks_z: u32,
    arena_first: u32,
    arena_words: u32,
    block_margin: f32,
    part_margin: f32,
    pad0: u32,
}
struct MarchingUniform {
    first_voxel: vec4<f32>,
    iso: f32,
    quantum: f32,
    bias: f32,
    units: u32,
    side: u32,
    normals: u32,
    is_moved: u32,
    vertices: u32,
    triangles: u32,
    first_vertex: u32,
    pad1: u32,
    pad2: u32,
}
struct OctreeNode {
    child_offset: u32,
    valid_mask: u32,
    leaf_mask: u32,
}
struct PathUniform {
    even: vec3<f32>,
    background: u32,
    clamp: f32,
    environment_strength: f32,
    environment_turn: f32,
    environment_width: u32,
    environment_height: u32,
    lens_radius: f32,
    lens_focus: f32,
    epsilon: f32,
    lift: f32,
    normal_step: f32,
    least_step: f32,
    bump_step: f32,
    light_count: u32,
    albedo_at: u32,
    rows_at: u32,
    extras_at: u32,
    is_stored: u32,
    max_bounces: u32,
    sample_count: u32,
    first_sample: u32,
    step_count: u32,
    first_pixel: u32,
    pixel_count: u32,
    is_transparent: u32,
}
struct PathState {
    origin: vec3<f32>,
    density: f32,
    direction: vec3<f32>,
    bounce: u32,
    carried: vec3<f32>,
    phase: u32,
    absorption: vec3<f32>,
    is_inside: u32,
    shadow_origin: vec3<f32>,
    shadow_reach: f32,
    shadow_direction: vec3<f32>,
    ends: u32,
    arrives: vec3<f32>,
    t: f32,
    light: vec3<f32>,
    reach: f32,
    albedo: vec3<f32>,
    distance: f32,
    normal: vec3<f32>,
    covered: f32,
    opacity: f32,
    side: f32,
    steps: u32,
    index: u32,
    seed: u32,
    pair: u32,
    pad0: u32,
    pad1: u32,
}
struct PathPixel {
    light: vec3<f32>,
    count: u32,
    squares: vec3<f32>,
    covered: f32,
    albedo: vec3<f32>,
    distance: f32,
    normal: vec3<f32>,
    opacity: f32,
}
// Whether branches hide that they depend on uniforms. Mesa's software device compiles a shader again for each dispatch, with
// the values of the uniforms that alone decide its branches.
override HIDES_UNIFORMS: bool = false;
// Returns a uniform's value for a branch. No thread has the index 0xffffffff, which the compiler does not know.
fn per_thread(value: u32, index: u32) -> u32 {
    return select(value, 0u, HIDES_UNIFORMS && index == 0xffffffffu);
}
