//! The dispatches of a sample of an image.

use crate::recording::{Destination, FrameKey, GROUP, MoreLight};
use crate::trace_mode::TraceMode;
use argil_abi::{FOG_PLACES, FrameUniform, LAMP_POINTS};

/// Maximum instructions times pixels of one dispatch and of one submission: a fraction of a second even on a small
/// GPU, so that no driver considers it hung.
pub(crate) const WORK_PER_DISPATCH: u64 = 400_000_000;
/// Maximum workgroups along an axis on every device.
const MAX_GROUPS: u32 = 65_535;

/// The entry points that every mode has, and indices of their pipelines.
const ALL_MODES: [&str; 5] = ["march", "resolve_hits", "shadow", "shade", "show"];
const MARCH: usize = 0;
const FINISH: usize = 1;
const SHADOW: usize = 2;
const SHADE: usize = 3;
const SHOW: usize = 4;
/// Those of modes whose cones go first.
const WITH_CONES: [&str; 7] = [
    "cone",
    "exact_normals",
    "sun_cone",
    "shadow_blocks",
    "shade_plain",
    "shade_blocks",
    "shade_deferred",
];
const CONE: usize = 5;
const EXACT_NORMALS: usize = 6;
const SUN_CONE: usize = 7;
const SHADOW_BLOCKS: usize = 8;
const SHADE_PLAIN: usize = 9;
const SHADE_BLOCKS: usize = 10;
const DEFERRED: usize = 11;

/// Those that show what they hit, of modes with cones and of modes without. They follow the others.
const SHOWING_WITH_CONES: [&str; 2] = ["cone_and_show", "march_and_show"];
const SHOWING: [&str; 1] = ["march_and_show"];
const CONE_AND_SHOW: usize = 12;
const MARCH_AND_SHOW: usize = 13;
const MARCH_WITHOUT_CONES: usize = 5;

/// Those of light that only some images have, which are never shown at once. They follow the others too.
const MORE_LIGHT: [&str; 3] = ["lamp_shadow", "light_fog", "bend_normals"];

/// Returns the index of the first of those that follow.
fn first_of_others(way: &TraceMode) -> usize {
    ALL_MODES.len() + if way.has_cones { WITH_CONES.len() } else { 0 }
}

/// Returns the entry points of a mode, by the indices of their pipelines.
pub(crate) fn entry_points(way: &TraceMode, has_more: bool) -> Vec<&'static str> {
    let with_cones: &[&str] = if way.has_cones { &WITH_CONES } else { &[] };
    let others: &[&str] = match way {
        _ if has_more => &MORE_LIGHT,
        way if way.has_cones => &SHOWING_WITH_CONES,
        way if way.marches_at_once() => &SHOWING,
        _ => &[],
    };
    [&ALL_MODES, with_cones, others].concat()
}

/// Whether a march shows what it hits, because the frame has no light that other passes gather.
fn is_shown_at_once(way: &TraceMode, key: &FrameKey) -> bool {
    let has_normals = !way.has_cones || key.normals != argil_abi::NORMALS_FIELD;
    way.marches_at_once() && has_normals && key.show != argil_abi::MODE_SHADED
}

/// Returns what the recording of a frame depends on. `field` is as in the key.
pub(crate) fn frame_key(
    way: &TraceMode,
    frames: &[FrameUniform],
    field: (usize, u32),
    goes: Destination,
) -> FrameKey {
    let first = frames.first().copied().unwrap_or_default();
    let key = FrameKey {
        size: [first.width, first.height],
        samples: frames.len(),
        show: first.mode,
        normals: first.normals,
        has_ground: first.has_ground != 0,
        max_steps: first.max_steps,
        field,
        goes,
        more: MoreLight::of(&first),
        has_statistics: first.records & argil_abi::RECORD_COUNTS != 0,
        records: 0,
    };
    let records = records(way, &key);
    FrameKey { records, ..key }
}

/// Returns the `RECORD_…` bits of a frame: what is stored of its rays.
fn records(way: &TraceMode, key: &FrameKey) -> u32 {
    use argil_abi::{MODE_BRICKS, MODE_HEAT, MODE_LEVELS, MODE_NODES};
    let is_shown = is_shown_at_once(way, key);
    let shows_counts = matches!(key.show, MODE_HEAT | MODE_BRICKS | MODE_NODES | MODE_LEVELS);
    // A march of several dispatches stores its state.
    let goes_on = way.is_exact && key.field.1 < key.max_steps;
    let has_counts = key.has_statistics
        || key.goes == Destination::CpuWithHits
        || goes_on
        || !is_shown && shows_counts;
    if has_counts {
        argil_abi::RECORD_HITS | argil_abi::RECORD_COUNTS
    } else if !is_shown || key.goes != Destination::Cpu {
        argil_abi::RECORD_HITS
    } else {
        0
    }
}

/// What the threads of a dispatch have.
#[derive(Clone, Copy)]
pub(crate) enum Threads {
    /// A pixel each.
    Pixels,
    /// A cone each, which lists its block of pixels or not.
    Cones,
    /// A pixel each of the listed blocks.
    ListedBlocks,
    /// The same, and they list what is left.
    ListedBlocksOnce,
}

/// One dispatch.
pub(crate) struct Stage {
    pub label: &'static str,
    /// Index of its pipeline.
    pub pipeline: usize,
    pub first_step: u32,
    pub step_count: u32,
    pub threads: Threads,
    /// Whether it evaluates the field.
    pub is_exact: bool,
}

/// Returns the dispatches of one sample of one band. Marches are cut into as many steps as a thread may do at
/// once.
pub(crate) fn stages(way: &TraceMode, key: &FrameKey) -> Vec<Stage> {
    let budget = key.field.1;
    let exact = |label, pipeline, steps: u32| {
        let budget = budget.min(steps).max(1);
        (0..steps)
            .step_by(budget as usize)
            .map(move |first_step| Stage {
                label,
                pipeline,
                first_step,
                step_count: budget.min(steps - first_step),
                threads: Threads::Pixels,
                is_exact: true,
            })
    };
    // Evaluates nothing, so it is one dispatch.
    let whole = |label, pipeline, threads| Stage {
        label,
        pipeline,
        first_step: 0,
        step_count: key.max_steps,
        threads,
        is_exact: false,
    };
    let blocks = Threads::ListedBlocks;
    if is_shown_at_once(way, key) {
        return match way.has_cones {
            true => vec![
                whole("Cones::march", CONE_AND_SHOW, Threads::Cones),
                whole("Bricks::march", MARCH_AND_SHOW, blocks),
            ],
            false => vec![whole("Trace::march", MARCH_WITHOUT_CONES, Threads::Pixels)],
        };
    }
    let mut stages: Vec<Stage> = if way.is_exact {
        exact("Trace::march", MARCH, key.max_steps).collect()
    } else if way.has_cones {
        vec![
            whole("Cones::march", CONE, Threads::Cones),
            whole("Bricks::march", MARCH, blocks),
        ]
    } else {
        vec![whole("Trace::march", MARCH, Threads::Pixels)]
    };
    // Bricks have their normals already.
    if !way.has_cones || key.has_ground {
        stages.extend(exact("Trace::finish", FINISH, 1));
    }
    if key.normals == argil_abi::NORMALS_FIELD && way.has_cones {
        stages.extend(exact("Trace::normals", EXACT_NORMALS, 1));
    }
    stages.extend(more_light(way, key));
    if key.show == argil_abi::MODE_SHADED {
        let steps = argil_render::SHADOW_STEPS;
        if way.has_cones {
            stages.push(whole("Shade::sun_cones", SUN_CONE, Threads::Cones));
            stages.push(whole("Shade::shadow", SHADOW_BLOCKS, blocks));
            stages.push(whole("Shade::plain", SHADE_PLAIN, Threads::Pixels));
            stages.push(whole(
                "Shade::light",
                SHADE_BLOCKS,
                Threads::ListedBlocksOnce,
            ));
            stages.push(whole("Shade::deferred", DEFERRED, blocks));
        } else {
            stages.extend(exact("Shade::shadow", SHADOW, steps));
            stages.extend(exact("Shade::light", SHADE, 1));
        }
    } else {
        stages.extend(exact("Shade::show", SHOW, 1));
    }
    // If the field is not evaluated, its length does not count.
    for stage in &mut stages {
        let asks = match stage.pipeline {
            MARCH | FINISH => way.is_exact,
            EXACT_NORMALS => true,
            SHADOW | SHADE | DEFERRED => true,
            other => other >= first_of_others(way) && !way.has_cones,
        };
        stage.is_exact = asks;
    }
    stages
}

/// Returns the dispatches that gather light that only some images have. The first step is a number: of a lamp
/// and a point of it, or of a light at a place in fog.
fn more_light(way: &TraceMode, key: &FrameKey) -> impl Iterator<Item = Stage> {
    let first = first_of_others(way);
    let lights_in_fog = FOG_PLACES * (2 + key.more.lamps);
    let counts = [
        ("Shade::lamps", key.more.lamps * (LAMP_POINTS + 1)),
        ("Shade::fog", u32::from(key.more.has_fog) * lights_in_fog),
        ("Shade::bent_normals", u32::from(key.more.has_bent_normals)),
    ];
    let all = counts.into_iter().enumerate();
    all.flat_map(move |(index, (label, count))| {
        (0..count).map(move |first_step| Stage {
            label,
            pipeline: first + index,
            first_step,
            step_count: 1,
            threads: Threads::Pixels,
            is_exact: true,
        })
    })
}

/// Returns the rows of a band, whose dispatches follow one another. A cone's thread has a block of pixels, and a band has
/// whole workgroups of them, because blocks that two bands have would be lit twice.
pub(crate) fn band_rows(key: &FrameKey, has_cones: bool) -> u32 {
    let [width, height] = key.size;
    let step = if has_cones { GROUP * GROUP } else { GROUP };
    let row_work = u64::from(width) * key.field.0 as u64;
    let rows = u32::try_from(WORK_PER_DISPATCH / row_work.max(1)).unwrap_or(u32::MAX);
    // As many blocks as a dispatch may have along an axis.
    let most_rows = MAX_GROUPS / width.div_ceil(GROUP) * GROUP;
    let rows = rows.min(most_rows);
    if rows >= height {
        return height.next_multiple_of(step);
    }
    (rows / step * step).max(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bands have whole workgroups, and all of them cover the image.
    #[test]
    fn bands_do_not_share_blocks() {
        for (size, length) in [
            ([1280, 720], 92),
            ([1280, 720], 3000),
            ([33, 7], 1),
            ([9000, 5000], 50_000),
        ] {
            let key = FrameKey {
                size,
                samples: 1,
                show: argil_abi::MODE_SHADED,
                normals: 0,
                has_ground: true,
                max_steps: 10,
                field: (length, 1),
                goes: Destination::Cpu,
                more: Default::default(),
                has_statistics: false,
                records: 0,
            };
            for (has_cones, step) in [(false, GROUP), (true, GROUP * GROUP)] {
                let rows = band_rows(&key, has_cones);
                assert!(rows > 0 && rows.is_multiple_of(step), "{size:?}: {rows}");
                let blocks = u64::from(size[0].div_ceil(GROUP)) * u64::from(rows / GROUP);
                assert!(blocks <= u64::from(MAX_GROUPS), "{size:?}: {blocks}");
            }
        }
    }

    /// A frame stores hits only for who reads them, and counts only for who asks.
    #[test]
    fn frames_store_what_is_read() {
        use argil_abi::{MODE_HEAT, MODE_NORMAL, MODE_SHADED, RECORD_COUNTS, RECORD_HITS};
        let [bricks, _] = crate::bricks::brick_ways();
        let field = &crate::render::FIELD;
        let all = RECORD_HITS | RECORD_COUNTS;
        for (way, mode, goes, counts, expected) in [
            (bricks, MODE_NORMAL, Destination::Cpu, 0, 0),
            (bricks, MODE_HEAT, Destination::Cpu, 0, 0),
            (bricks, MODE_NORMAL, Destination::Cpu, RECORD_COUNTS, all),
            (bricks, MODE_NORMAL, Destination::Textures, 0, RECORD_HITS),
            (bricks, MODE_NORMAL, Destination::Host, 0, RECORD_HITS),
            (bricks, MODE_NORMAL, Destination::CpuWithHits, 0, all),
            (bricks, MODE_SHADED, Destination::Cpu, 0, RECORD_HITS),
            (field, MODE_NORMAL, Destination::Cpu, 0, RECORD_HITS),
            (field, MODE_HEAT, Destination::Cpu, 0, all),
        ] {
            let frame = FrameUniform {
                mode,
                records: counts,
                max_steps: 10,
                ..Default::default()
            };
            let key = frame_key(way, &[frame], (1, 10), goes);
            assert_eq!(key.records, expected, "{}: {mode} {goes:?}", way.name);
            // A march that takes several dispatches stores its state.
            let goes_on = frame_key(way, &[frame], (1, 9), goes);
            assert_eq!(goes_on.records == all, way.is_exact || expected == all);
        }
    }
}
