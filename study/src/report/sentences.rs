//! Sentences about each experiment's records.

use super::devices::done_by_device;
use crate::formatting::number;
use crate::record::Record;

/// Describes the records of one device; `None` if some are missing.
type Sentence = fn(&[&Record]) -> Option<String>;

const SENTENCES: &[(&str, Sentence)] = &[
    ("construction", construction),
    ("dense-fill", dense_fill),
    ("frames", frames),
    ("cameras", frames),
    ("heat", heat),
    ("fidelity", fidelity),
    ("normals", normals),
    ("strides", strides),
    ("center", center),
    ("sweep", sweep),
    ("edits", edits),
    ("memory", memory),
    ("stored", stored),
    ("triangles", triangles),
    ("lost", lost),
];

/// Describes records.
pub(super) fn sentences(name: &str, records: &[&Record]) -> Vec<String> {
    let mut all = Vec::new();
    let known = SENTENCES.iter().find(|(own, _)| *own == name);
    for (device, own) in done_by_device(records) {
        let text = known.and_then(|(_, sentence)| sentence(&own));
        all.extend(text.map(|text| format!("On {device}: {text}")));
    }
    let failed = records.iter().filter(|r| r.error.is_some()).count();
    if failed > 0 {
        all.push(format!("{failed} cases failed; their rows say why."));
    }
    all
}

/// Formats the minimum and maximum of a value.
fn spread<'a>(records: impl Iterator<Item = &'a &'a Record>, value: &str) -> Option<String> {
    let all: Vec<f64> = records.filter_map(|r| r.value(value)).collect();
    let (least, most) = all
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| {
            (a.min(v), b.max(v))
        });
    (!all.is_empty()).then(|| {
        if least == most {
            number(least)
        } else {
            format!("{} to {}", number(least), number(most))
        }
    })
}

/// Returns the records of a representation.
fn via<'a>(
    own: &'a [&'a Record],
    word: &'static str,
) -> impl Iterator<Item = &'a &'a Record> + Clone {
    own.iter().filter(move |r| r.via == word)
}

fn construction(own: &[&Record]) -> Option<String> {
    let plain = || via(own, "octree").filter(|r| !r.parameters.contains_key("sort"));
    let count = |r: &&&Record| r.value("bricks").unwrap_or(0.0) as u64;
    let (few, many) = (plain().min_by_key(count)?, plain().max_by_key(count)?);
    let all = many.value("build_ms")?;
    let dense = via(own, "dense").find_map(|r| r.value("build_ms"))?;
    let filled = many.value("bricks")? * many.parameter("brick")?.powi(3);
    let times = 1024.0 * 1024.0 * 512.0 / filled;
    Some(format!(
        "an octree of {} brick takes {} ms, one of {} bricks {} ms, of which filling is {} %. Extrapolated to 1024×1024×512 voxels, all of them filled, {} times as many, {} ms. The same volume filled as a dense one takes {} ms.",
        number(few.value("bricks")?),
        number(few.value("build_ms")?),
        number(many.value("bricks")?),
        number(all),
        number(100.0 * many.value("fill_ms")? / all),
        number(times),
        number(times * all),
        number(dense)
    ))
}

fn dense_fill(own: &[&Record]) -> Option<String> {
    let tiled = spread(
        via(own, "dense").filter(|r| !r.parameters.contains_key("fill")),
        "build_ms",
    )?;
    Some(
        match spread(
            via(own, "dense").filter(|r| r.parameters.contains_key("fill")),
            "build_ms",
        ) {
            Some(naive) => {
                format!("by tiles a dense volume takes {tiled} ms, a thread a group {naive} ms.")
            }
            None => format!(
                "a dense volume takes {tiled} ms, an octree {} ms, sparse bricks {} ms.",
                spread(via(own, "octree"), "build_ms")?,
                spread(via(own, "bricks"), "build_ms")?
            ),
        },
    )
}

fn frames(own: &[&Record]) -> Option<String> {
    Some(format!(
        "medians of frames go from {} ms through the field, {} through a dense volume with mips, {} through the octree and {} through sparse bricks.",
        spread(via(own, "field"), "frame_ms")?,
        spread(via(own, "dense, mips"), "frame_ms")?,
        spread(via(own, "octree"), "frame_ms")?,
        spread(via(own, "bricks"), "frame_ms")?
    ))
}

fn heat(own: &[&Record]) -> Option<String> {
    Some(format!(
        "a ray takes {} steps on average through a dense volume, {} with mips, {} through the octree (nodes and cells counted), {} through sparse bricks.",
        spread(via(own, "dense"), "steps_mean")?,
        spread(via(own, "dense, mips"), "steps_mean")?,
        spread(via(own, "octree"), "steps_mean")?,
        spread(via(own, "bricks"), "steps_mean")?
    ))
}

fn fidelity(own: &[&Record]) -> Option<String> {
    let faces = spread(
        via(own, "mesh").filter(|r| r.parameters.contains_key("normals")),
        "flip_mean",
    )?;
    let smooth = spread(
        via(own, "mesh").filter(|r| !r.parameters.contains_key("normals")),
        "flip_mean",
    )?;
    Some(format!(
        "FLIP errors against the field's normals are {} for dense volumes, {} for sparse bricks, {faces} for triangles with their own normals and {smooth} for triangles with the field's.",
        spread(via(own, "dense"), "flip_mean")?,
        spread(via(own, "bricks"), "flip_mean")?
    ))
}

fn normals(own: &[&Record]) -> Option<String> {
    Some(format!(
        "differences of Laplacians are {} of 255 {}, {} over the normals of sparse bricks.",
        spread(via(own, "dense"), "laplacian_mean_abs")?,
        if via(own, "dense").count() > 1 {
            "over the biases of a dense volume"
        } else {
            "for a dense volume with a bias of a voxel"
        },
        spread(via(own, "bricks"), "laplacian_mean_abs")?
    ))
}

fn strides(own: &[&Record]) -> Option<String> {
    let by_flip = |r: &&&Record| (1e6 * r.value("flip_mean").unwrap_or(f64::INFINITY)) as u64;
    let best = via(own, "dense")
        .filter(|r| r.value("flip_mean").is_some())
        .min_by_key(by_flip)?;
    Some(format!(
        "of 8 bits, the picture nearest to the field's is that of stride {}, a band of {} voxels; errors go over {}.",
        best.parameter("stride")?,
        number(256.0 / best.parameter("stride")?),
        spread(via(own, "dense"), "flip_mean")?
    ))
}

fn center(own: &[&Record]) -> Option<String> {
    Some(format!(
        "{} bricks are there, those in the middle.",
        spread(via(own, "octree"), "bricks")?
    ))
}

fn sweep(own: &[&Record]) -> Option<String> {
    let of = |word: &'static str, brick: f64| {
        via(own, word).filter(move |r| r.parameter("brick") == Some(brick))
    };
    Some(format!(
        "medians of frames through the octree are {} ms with bricks of 8³, {} with 16³, {} with 32³; through sparse bricks {} with 4³, {} with 8³, {} with 16³.",
        spread(of("octree", 8.0), "frame_ms")?,
        spread(of("octree", 16.0), "frame_ms")?,
        spread(of("octree", 32.0), "frame_ms")?,
        spread(of("bricks", 4.0), "frame_ms")?,
        spread(of("bricks", 8.0), "frame_ms")?,
        spread(of("bricks", 16.0), "frame_ms")?
    ))
}

fn edits(own: &[&Record]) -> Option<String> {
    let others = own.iter().filter(|r| r.via != "bricks");
    Some(format!(
        "medians of an edit of sparse bricks are {} ms; the other volumes, which are made again, take {} ms.",
        spread(via(own, "bricks"), "edit_ms")?,
        spread(others, "edit_ms")?
    ))
}

fn memory(own: &[&Record]) -> Option<String> {
    let most = own
        .iter()
        .filter_map(|r| r.parameter("resolution"))
        .fold(0.0, f64::max);
    let of = |word: &'static str| {
        via(own, word)
            .filter(move |r| r.parameter("resolution") == Some(most))
            .filter(|r| !r.parameters.contains_key("bits"))
    };
    let mb = |word| spread(of(word), "memory_bytes");
    Some(format!(
        "at {most}³, bytes are {} for a dense volume, {} with mips, {} for the octree and {} for sparse bricks with 16 bits and materials.",
        mb("dense")?,
        mb("dense, mips")?,
        mb("octree")?,
        mb("bricks")?
    ))
}

fn stored(own: &[&Record]) -> Option<String> {
    let of = |word: &'static str, bits: f64| {
        via(own, word).filter(move |r| r.parameter("bits") == Some(bits))
    };
    Some(format!(
        "root mean squares are {} voxels for dense volumes of 8 bits, {} of 16; {} for sparse bricks of 8 bits and {} of 16.",
        spread(of("dense", 8.0), "error_voxels_rms")?,
        spread(of("dense", 16.0), "error_voxels_rms")?,
        spread(of("bricks", 8.0), "error_voxels_rms")?,
        spread(of("bricks", 16.0), "error_voxels_rms")?
    ))
}

fn triangles(own: &[&Record]) -> Option<String> {
    let teapot = |faces: bool| {
        let own = via(own, "mesh")
            .filter(|r| r.scene == "teapot" && r.parameter("resolution") == Some(100.0));
        own.clone()
            .find(|r| r.parameters.contains_key("normals") == faces)
    };
    let (shared, faces) = (teapot(false)?, teapot(true)?);
    Some(format!(
        "the teapot at 100³ is {} triangles with {} corners ({} MB), or {} where none are shared ({} MB), made in {} ms.",
        number(shared.value("triangles")?),
        number(shared.value("vertices")?),
        number(shared.value("memory_bytes")? / 1e6),
        number(faces.value("vertices")?),
        number(faces.value("memory_bytes")? / 1e6),
        number(shared.value("mesh_ms")?)
    ))
}

fn lost(own: &[&Record]) -> Option<String> {
    let by_center = via(own, "octree").filter(|r| r.parameters.contains_key("keep"));
    let others = own.iter().filter(|r| !r.parameters.contains_key("keep"));
    Some(format!(
        "the study's test, that a brick's center is within ±4 voxels of the surface, loses {} bricks of 32³ a scene that hold surface, the conservative one and sparse bricks {}.",
        spread(by_center, "lost_bricks")?,
        spread(others, "lost_bricks")?
    ))
}
