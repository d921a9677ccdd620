//! Sentences about each experiment's records.

use super::devices::done_by_device;
use crate::formatting::{counted, number};
use crate::record::Record;

/// Describes the records of one device; `None` if some are missing.
type Sentence = fn(&[&Record]) -> Option<String>;

const SENTENCES: &[(&str, Sentence)] = &[
    ("construction", construction),
    ("dense-fill", dense_fill),
    ("bakes", bakes),
    ("frames", frames),
    ("cameras", frames),
    ("heat", heat),
    ("fidelity", fidelity),
    ("convergence", convergence),
    ("normals", normals),
    ("strides", strides),
    ("center", center),
    ("sweep", sweep),
    ("edits", edits),
    ("memory", memory),
    ("stored", stored),
    ("triangles", triangles),
    ("pipelines", pipelines),
    ("peer", peer),
    ("lost", lost),
];

/// Describes records.
pub(super) fn sentences(name: &str, records: &[&Record]) -> Vec<String> {
    let mut all = Vec::new();
    let known = SENTENCES.iter().find(|(experiment, _)| *experiment == name);
    for (device, records) in done_by_device(records) {
        let text = known.and_then(|(_, sentence)| sentence(&records));
        all.extend(text.map(|text| format!("On {device}: {text}")));
    }
    let failed = records.iter().filter(|r| r.error.is_some()).count();
    if failed > 0 {
        let failed = counted(failed, "case");
        all.push(format!("{failed} failed; the table lists the errors."));
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
    records: &'a [&'a Record],
    word: &'static str,
) -> impl Iterator<Item = &'a &'a Record> + Clone {
    records.iter().filter(move |r| r.via == word)
}

fn construction(records: &[&Record]) -> Option<String> {
    let plain = || via(records, "octree").filter(|r| !r.parameters.contains_key("sort"));
    let count = |r: &&&Record| r.value("bricks").unwrap_or(0.0) as u64;
    let (few, many) = (plain().min_by_key(count)?, plain().max_by_key(count)?);
    let all = many.value("build_ms")?;
    let dense = via(records, "dense").find_map(|r| r.value("build_ms"))?;
    let filled = many.value("bricks")? * many.parameter("brick")?.powi(3);
    let times = 1024.0 * 1024.0 * 512.0 / filled;
    Some(format!(
        "the octree with the fewest bricks ({}) takes {} ms to build. The one with the most ({}) takes {} ms, and {} % of that fills bricks. Extrapolated to 1024×1024×512 filled voxels, {} times as many, it takes {} ms. A dense volume of the same scene takes {} ms.",
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

fn dense_fill(records: &[&Record]) -> Option<String> {
    let tiled = spread(
        via(records, "dense").filter(|r| !r.parameters.contains_key("fill")),
        "build_ms",
    )?;
    Some(
        match spread(
            via(records, "dense").filter(|r| r.parameters.contains_key("fill")),
            "build_ms",
        ) {
            Some(naive) => {
                format!(
                    "a dense volume takes {tiled} ms when filled by tiles, and {naive} ms with one thread per workgroup."
                )
            }
            None => format!(
                "a dense volume takes {tiled} ms, an octree {} ms, and sparse bricks {} ms.",
                spread(via(records, "octree"), "build_ms")?,
                spread(via(records, "bricks"), "build_ms")?
            ),
        },
    )
}

/// Compares volumes at each resolution.
fn bakes(records: &[&Record]) -> Option<String> {
    let mut resolutions: Vec<f64> = records
        .iter()
        .filter_map(|r| r.parameter("resolution"))
        .collect();
    resolutions.sort_by(f64::total_cmp);
    resolutions.dedup();
    let line = |resolution: &f64| {
        let of = |word: &'static str| {
            let same =
                via(records, word).filter(|r| r.parameter("resolution") == Some(*resolution));
            spread(same, "build_ms")
        };
        Some(format!(
            "at {resolution}³, a dense volume takes {} ms, an octree {} ms, and sparse bricks {} ms",
            of("dense")?,
            of("octree")?,
            of("bricks")?
        ))
    };
    let lines: Option<Vec<String>> = resolutions.iter().map(line).collect();
    let lines = lines.filter(|lines| !lines.is_empty())?;
    Some(format!("{}.", lines.join("; ")))
}

/// Describes frames without light, and with light where they were measured.
fn frames(records: &[&Record]) -> Option<String> {
    let is_lit = |r: &&&Record| r.parameters.contains_key("light");
    let [lit, plain] = [true, false].map(|lit| -> Vec<&Record> {
        records
            .iter()
            .filter(|r| is_lit(r) == lit)
            .copied()
            .collect()
    });
    let text = plain_frames(&plain)?;
    let lit = |word| spread(via(&lit, word), "frame_ms");
    let Some((dense, bricks)) = lit("dense").zip(lit("bricks")) else {
        return Some(text);
    };
    Some(format!(
        "{text} With light, they are {dense} ms for a dense volume, and {bricks} ms for sparse bricks."
    ))
}

fn plain_frames(records: &[&Record]) -> Option<String> {
    Some(format!(
        "median frame times are {} ms for the field, {} ms for a dense volume with mips, {} ms for the octree, and {} ms for sparse bricks.",
        spread(via(records, "field"), "frame_ms")?,
        spread(via(records, "dense, mips"), "frame_ms")?,
        spread(via(records, "octree"), "frame_ms")?,
        spread(via(records, "bricks"), "frame_ms")?
    ))
}

fn heat(records: &[&Record]) -> Option<String> {
    Some(format!(
        "the mean number of steps per ray is {} for a dense volume, {} with mips, {} for the octree (including nodes and cells), and {} for sparse bricks.",
        spread(via(records, "dense"), "steps_mean")?,
        spread(via(records, "dense, mips"), "steps_mean")?,
        spread(via(records, "octree"), "steps_mean")?,
        spread(via(records, "bricks"), "steps_mean")?
    ))
}

fn fidelity(records: &[&Record]) -> Option<String> {
    let faces = spread(
        via(records, "mesh").filter(|r| r.parameters.contains_key("normals")),
        "flip_mean",
    )?;
    let smooth = spread(
        via(records, "mesh").filter(|r| !r.parameters.contains_key("normals")),
        "flip_mean",
    )?;
    Some(format!(
        "the FLIP error against the field, rendered as normals, is {} for dense volumes, {} for sparse bricks, {faces} for triangles with face normals, and {smooth} for triangles with the field's normals.",
        spread(via(records, "dense"), "flip_mean")?,
        spread(via(records, "bricks"), "flip_mean")?
    ))
}

/// Counts the images whose error falls with each doubling of the resolution.
fn convergence(records: &[&Record]) -> Option<String> {
    let mut errors = std::collections::BTreeMap::<_, Vec<(f64, f64)>>::new();
    for record in records {
        let of = (
            record.scene.as_str(),
            record.parameters.get("show")?.as_str()?,
        );
        let error = (record.parameter("resolution")?, record.value("flip_mean")?);
        errors.entry(of).or_default().push(error);
    }
    let falls = |points: &mut Vec<(f64, f64)>| {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.len() > 1 && points.windows(2).all(|pair| pair[1].1 < pair[0].1)
    };
    let images = errors.len();
    let falling = errors.values_mut().filter_map(|p| falls(p).then_some(()));
    Some(format!(
        "the FLIP error of bricks against the field falls with each doubling of the resolution in {} of {images} images, with light and with normals.",
        falling.count()
    ))
}

fn normals(records: &[&Record]) -> Option<String> {
    Some(format!(
        "the mean difference of Laplacians is {} of 255 {}, and {} over the kinds of normals of sparse bricks.",
        spread(via(records, "dense"), "laplacian_mean_abs")?,
        if via(records, "dense").count() > 1 {
            "over the biases of a dense volume"
        } else {
            "for a dense volume with a bias of one voxel"
        },
        spread(via(records, "bricks"), "laplacian_mean_abs")?
    ))
}

fn strides(records: &[&Record]) -> Option<String> {
    let by_flip = |r: &&&Record| (1e6 * r.value("flip_mean").unwrap_or(f64::INFINITY)) as u64;
    let best = via(records, "dense")
        .filter(|r| r.value("flip_mean").is_some())
        .min_by_key(by_flip)?;
    Some(format!(
        "with 8-bit samples, stride {}, a band of {} voxels, gives the image nearest to the field's. FLIP errors are {}.",
        best.parameter("stride")?,
        number(256.0 / best.parameter("stride")?),
        spread(via(records, "dense"), "flip_mean")?
    ))
}

fn center(records: &[&Record]) -> Option<String> {
    Some(format!(
        "the octree stores {} bricks, at the center.",
        spread(via(records, "octree"), "bricks")?
    ))
}

fn sweep(records: &[&Record]) -> Option<String> {
    let of = |word: &'static str, brick: f64| {
        via(records, word).filter(move |r| r.parameter("brick") == Some(brick))
    };
    Some(format!(
        "median frame times of the octree are {} ms with bricks of 8³, {} ms with 16³, and {} ms with 32³. Median frame times of sparse bricks are {} ms with 4³, {} ms with 8³, and {} ms with 16³.",
        spread(of("octree", 8.0), "frame_ms")?,
        spread(of("octree", 16.0), "frame_ms")?,
        spread(of("octree", 32.0), "frame_ms")?,
        spread(of("bricks", 4.0), "frame_ms")?,
        spread(of("bricks", 8.0), "frame_ms")?,
        spread(of("bricks", 16.0), "frame_ms")?
    ))
}

fn edits(records: &[&Record]) -> Option<String> {
    let others = records.iter().filter(|r| r.via != "bricks");
    Some(format!(
        "the median edit of sparse bricks takes {} ms. The other volumes are rebuilt, which takes {} ms.",
        spread(via(records, "bricks"), "edit_ms")?,
        spread(others, "edit_ms")?
    ))
}

fn memory(records: &[&Record]) -> Option<String> {
    let most = records
        .iter()
        .filter_map(|r| r.parameter("resolution"))
        .fold(0.0, f64::max);
    let of = |word: &'static str| {
        via(records, word)
            .filter(move |r| r.parameter("resolution") == Some(most))
            .filter(|r| !r.parameters.contains_key("bits"))
    };
    let mb = |word| spread(of(word), "memory_bytes");
    Some(format!(
        "at {most}³, the memory in bytes is {} for a dense volume, {} with mips, {} for the octree, and {} for sparse bricks with 16-bit codes and materials.",
        mb("dense")?,
        mb("dense, mips")?,
        mb("octree")?,
        mb("bricks")?
    ))
}

fn stored(records: &[&Record]) -> Option<String> {
    let of = |word: &'static str, bits: f64| {
        via(records, word).filter(move |r| r.parameter("bits") == Some(bits))
    };
    Some(format!(
        "the root-mean-square error is {} voxels for dense volumes of 8 bits, {} of 16 bits, {} for sparse bricks of 8 bits, and {} of 16 bits.",
        spread(of("dense", 8.0), "error_voxels_rms")?,
        spread(of("dense", 16.0), "error_voxels_rms")?,
        spread(of("bricks", 8.0), "error_voxels_rms")?,
        spread(of("bricks", 16.0), "error_voxels_rms")?
    ))
}

fn triangles(records: &[&Record]) -> Option<String> {
    let teapot = |faces: bool| {
        let records = via(records, "mesh")
            .filter(|r| r.scene == "teapot" && r.parameter("resolution") == Some(100.0));
        records
            .clone()
            .find(|r| r.parameters.contains_key("normals") == faces)
    };
    let (shared, faces) = (teapot(false)?, teapot(true)?);
    let time = shared.value("mesh_ms");
    let time = time.map_or(String::new(), |ms| {
        format!(" Meshing takes {} ms.", number(ms))
    });
    Some(format!(
        "the teapot at 100³ has {} triangles and {} shared vertices ({} MB), or {} vertices if none is shared ({} MB).{time}",
        number(shared.value("triangles")?),
        number(shared.value("vertices")?),
        number(shared.value("memory_bytes")? / 1e6),
        number(faces.value("vertices")?),
        number(faces.value("memory_bytes")? / 1e6)
    ))
}

fn pipelines(records: &[&Record]) -> Option<String> {
    Some(format!(
        "the first use takes {} ms, and the second {} ms.",
        spread(records.iter(), "first_ms")?,
        spread(records.iter(), "second_ms")?
    ))
}

fn peer(records: &[&Record]) -> Option<String> {
    Some(format!(
        "a frame with its read-back takes {} ms by fidget-wgpu, {} ms through the field, and {} ms through sparse bricks.",
        spread(via(records, "fidget-wgpu"), "frame_wall_ms")?,
        spread(via(records, "field"), "frame_wall_ms")?,
        spread(via(records, "bricks"), "frame_wall_ms")?
    ))
}

fn lost(records: &[&Record]) -> Option<String> {
    let by_center = via(records, "octree").filter(|r| r.parameters.contains_key("keep"));
    let others = records
        .iter()
        .filter(|r| !r.parameters.contains_key("keep"));
    Some(format!(
        "the study keeps a brick if its center is within ±4 voxels of the surface. That test loses {} bricks of 32³ per scene that contain surface. The conservative test and sparse bricks lose {}.",
        spread(by_center, "lost_bricks")?,
        spread(others, "lost_bricks")?
    ))
}
