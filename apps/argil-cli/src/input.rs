//! The inputs that commands share: a scene or a volume, a device, a representation.

use crate::args::{DeviceArgs, VolumeArgs};
use anyhow::{Context, ensure};
use argil::field::CoincidingCopies;
use argil::scene::Scene;
use argil::volume::{Band, Encoding, VolumeFile};
use argil::{
    BricksOptions, DenseOptions, Engine, LevelsOptions, MeshRenderOptions, OctreeOptions,
    Representation, World,
};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Creates the requested engine, with the requested number of threads.
pub(crate) fn engine(on: &DeviceArgs) -> anyhow::Result<Engine> {
    if let Some(threads) = on.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global()
            .map_err(|e| argil::EngineError::Threads(e.to_string()))?;
    }
    let engine = Engine::with_backend(on.device)?;
    Ok(crate::progress::watched(engine))
}

/// Whether an input is the manifest of a world, or its folder or address.
pub(crate) fn is_stored_world(input: &Path) -> bool {
    input.to_str().is_some_and(|text| text.contains("://"))
        || input
            .file_name()
            .is_some_and(|name| name == "manifest.json")
        || ["manifest.json", "plan.json"]
            .iter()
            .any(|name| input.join(name).is_file())
}

/// Rejects a file of an unknown format before it is parsed as JSON.
pub(crate) fn refuse_unknown(path: &Path) -> anyhow::Result<()> {
    // A file that is not regular, such as a pipe, can be read only once.
    if path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("json"))
        || !path.is_file()
    {
        return Ok(());
    }
    let mut start = Vec::new();
    let file = std::fs::File::open(path).with_context(|| path.display().to_string())?;
    file.take(64)
        .read_to_end(&mut start)
        .with_context(|| path.display().to_string())?;
    let text = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&start);
    ensure!(
        matches!(text.trim_ascii_start().first(), None | Some(b'{' | b'[')),
        "{}: unknown format: export it as {} (mesh), .vdb, .nvdb, .npy or .nrrd (volume) or .png (heightmap), for example \
         from Blender or 3D Slicer, and convert that with `argil import`",
        path.display(),
        argil::mesh::MeshFormat::extensions("or")
    );
    Ok(())
}

/// Reads the scene of a scene file or of a volume file.
pub(crate) fn scene(path: &Path, outside: bool) -> anyhow::Result<Scene> {
    ensure!(
        argil::mesh::MeshFormat::from_path(path).is_none() || is_volume(path)?,
        "{}: this is a mesh, not a scene: convert it with `argil import {0} -o scene.json`",
        path.display()
    );
    ensure!(
        !argil::is_volume_file(path),
        "{}: this is a volume of another program, not a scene: convert it with `argil import {0} -o scene.json`",
        path.display()
    );
    ensure!(
        !path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("png")),
        "{}: this is an image, not a scene: convert a heightmap with `argil import {0} -o scene.json`",
        path.display()
    );
    ensure!(
        !is_stored_world(path),
        "{}: this is a stored world, which `argil render`, `argil world edit` and `argil world export` open{}: expected the scene that it was planned from",
        path.display(),
        if cfg!(feature = "world") {
            ""
        } else {
            " if they are built with `--features world`"
        }
    );
    let mut scene = if is_volume(path)? {
        scene_of(&VolumeFile::open(path)?, path)?
    } else {
        refuse_unknown(path)?;
        Scene::open(path)?
    };
    load_meshes(&mut scene, path, outside)?;
    for copies in CoincidingCopies::of(&scene) {
        eprintln!("warning: {}: {copies}", path.display());
    }
    Ok(scene)
}

/// Loads the meshes of a scene, and warns about removed parts and closed holes.
pub(crate) fn load_meshes(
    scene: &mut Scene,
    path: &Path,
    outside: bool,
) -> anyhow::Result<Vec<argil::LoadedMesh>> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let loaded = argil::load_meshes(scene, folder, outside);
    let loaded = loaded.with_context(|| path.display().to_string())?;
    for mesh in &loaded {
        for warning in mesh.warnings() {
            eprintln!("warning: {}: {warning}", mesh.path);
        }
    }
    Ok(loaded)
}

/// Rejects an output that would replace a mesh of the scene.
pub(crate) fn spare_meshes<'a>(
    scene: &Scene,
    place: &Path,
    outputs: impl IntoIterator<Item = &'a Path>,
) -> anyhow::Result<()> {
    let folder = place.parent().unwrap_or(Path::new("."));
    let meshes: Vec<PathBuf> = scene.mesh_paths().iter().map(|p| folder.join(p)).collect();
    for output in outputs {
        for mesh in &meshes {
            crate::output::check_place(output, mesh)?;
        }
    }
    Ok(())
}

/// Returns true if a file is a volume. Rejects a file that is named `.argil` but is not a volume, because it is not
/// a scene either.
pub(crate) fn is_volume(path: &Path) -> anyhow::Result<bool> {
    if path.is_file() {
        // What cannot be read must not be taken for another kind of file.
        std::fs::File::open(path).with_context(|| path.display().to_string())?;
    }
    let is_volume = VolumeFile::is_volume_file(path);
    let is_named_so = path.extension().is_some_and(|e| e == "argil");
    if is_named_so && !is_volume && path.is_file() {
        return Err(argil::volume::VolumeError::NotAVolumeFile(path.into()).into());
    }
    Ok(is_volume)
}

/// Reads the scene that a volume was made from.
pub(crate) fn scene_of(stored: &VolumeFile, path: &Path) -> anyhow::Result<Scene> {
    Ok(argil::stored_scene(stored, path)?)
}

/// Builds a scene with the representation of the flags, or loads a volume as it was baked.
pub(crate) fn world(
    path: &Path,
    engine: &Engine,
    via: Option<Representation>,
    flags: &VolumeArgs,
    (time, outside): (Option<f32>, bool),
) -> anyhow::Result<(Scene, World)> {
    if !is_volume(path)? {
        let mut scene = scene(path, outside)?;
        set_time(&mut scene, time, path)?;
        let via = representation(via.unwrap_or_default(), flags, engine)?;
        let place = || path.display().to_string();
        let built = engine.build(&scene).with_context(place)?;
        crate::long_work::warn(built.program(), via, path);
        let world = built.with_representation(via).with_context(place)?;
        return Ok((scene, world));
    }
    let marching = VolumeArgs {
        descent: flags.descent,
        ..VolumeArgs::default()
    };
    ensure!(
        via.is_none() && *flags == marching,
        "{}: this volume is already baked (see `argil info`): omit flags that control the build, such as --via, --resolution and --method",
        path.display()
    );
    let (mut scene, mut world) = if outside {
        engine.load_with_external_meshes(VolumeFile::open(path)?, path)?
    } else {
        engine.load(VolumeFile::open(path)?, path)?
    };
    if flags.descent.is_some() {
        ensure!(
            matches!(world.representation(), Representation::Octree(_)),
            "--descent: {} is not an octree",
            path.display()
        );
    }
    if time.is_some() {
        set_time(&mut scene, time, path)?;
        world.apply(&scene)?;
    }
    Ok((scene, world))
}

/// Evaluates keyframes at a time.
pub(crate) fn set_time(scene: &mut Scene, time: Option<f32>, path: &Path) -> anyhow::Result<()> {
    if let Some(time) = time {
        ensure!(
            scene.duration().is_some(),
            "--time has no effect, because {} has no keyframes: omit it",
            path.display()
        );
        scene.set_time(time);
    }
    Ok(())
}

/// Returns the representation that the flags ask for. Rejects flags that have no effect on it.
pub(crate) fn representation(
    via: Representation,
    flags: &VolumeArgs,
    engine: &Engine,
) -> anyhow::Result<Representation> {
    if let Some(flag) = idle_flag(via, flags) {
        anyhow::bail!(
            "{flag} has no effect with --via {}: omit it, or choose another --via",
            via.name()
        );
    }
    let of_gpu = [
        ("--fill", flags.fill.is_some()),
        ("--sort", flags.sort.is_some()),
    ];
    if let (Some((flag, _)), None) = (of_gpu.iter().find(|(_, given)| *given), engine.gpu_kind()) {
        anyhow::bail!("{flag} has no effect on the CPU: omit it, or add --device gpu");
    }
    let resolution = flags.resolution.unwrap_or(256);
    let encoding = encoding(via, flags);
    Ok(match via {
        Representation::Field => Representation::Field,
        Representation::Mesh(_) => Representation::Mesh(MeshRenderOptions {
            resolution,
            method: flags.method.unwrap_or_default(),
            flat: flags.flat,
        }),
        Representation::Dense(_) => Representation::Dense(DenseOptions {
            resolution,
            encoding,
            mips: flags.mips,
            fill: flags.fill.unwrap_or_default(),
        }),
        Representation::Bricks(_) => {
            let mut options = BricksOptions {
                resolution,
                voxel_size: flags.voxel_size,
                memory_budget: flags.memory_budget.map(|mib| u64::from(mib) << 20),
                ..BricksOptions::default()
            };
            options.settings.encoding = encoding;
            options.settings.brick_size_voxels =
                flags.brick.unwrap_or(options.settings.brick_size_voxels);
            Representation::Bricks(options)
        }
        Representation::Levels(_) => {
            // The parser gives all representations one resolution, which is far too coarse for levels.
            let defaults = LevelsOptions::default();
            let mut options = LevelsOptions {
                resolution: flags.resolution.unwrap_or(defaults.resolution),
                voxel_size: flags.voxel_size,
                pixel_error: flags.pixel_error.unwrap_or(defaults.pixel_error),
                memory_budget: flags
                    .memory_budget
                    .map_or(defaults.memory_budget, |mib| u64::from(mib) << 20),
                ..defaults
            };
            options.settings.encoding = encoding;
            Representation::Levels(options)
        }
        Representation::Octree(_) => {
            let mut options = OctreeOptions {
                resolution,
                ..OctreeOptions::default()
            };
            let settings = &mut options.settings;
            settings.encoding = encoding;
            settings.brick_size_voxels = flags.brick.unwrap_or(settings.brick_size_voxels);
            settings.depth = flags.depth;
            settings.brick_test = flags.keep.unwrap_or_default();
            options.order = flags.sort.unwrap_or_default();
            Representation::Octree(options)
        }
        other => {
            let mut all = Representation::all(resolution).into_iter();
            all.find(|via| via.name() == other.name()).unwrap_or(other)
        }
    })
}

/// Returns the first flag that is given but has no effect on a representation.
fn idle_flag(via: Representation, flags: &VolumeArgs) -> Option<&'static str> {
    let word = via.name();
    // Each flag, whether it is given, and the representations that use it.
    let volumes = ["dense", "octree", "bricks", "levels"];
    let all: [(&'static str, bool, &[&str]); 16] = [
        (
            "--resolution",
            flags.resolution.is_some(),
            // The field has no resolution, unless it is meshed.
            if via == Representation::Field {
                &[]
            } else {
                &[word]
            },
        ),
        ("--bits", flags.bits.is_some(), &volumes),
        ("--band", flags.band.is_some(), &volumes),
        ("--stride", flags.stride.is_some(), &volumes),
        ("--mips", flags.mips, &["dense"]),
        ("--fill", flags.fill.is_some(), &["dense"]),
        ("--depth", flags.depth.is_some(), &["octree"]),
        ("--keep", flags.keep.is_some(), &["octree"]),
        ("--descent", flags.descent.is_some(), &["octree"]),
        ("--sort", flags.sort.is_some(), &["octree"]),
        ("--brick", flags.brick.is_some(), &["octree", "bricks"]),
        (
            "--memory-budget",
            flags.memory_budget.is_some(),
            &["bricks", "levels"],
        ),
        ("--pixel-error", flags.pixel_error.is_some(), &["levels"]),
        (
            "--voxel-size",
            flags.voxel_size.is_some(),
            &["bricks", "levels"],
        ),
        ("--method", flags.method.is_some(), &["mesh"]),
        ("--flat", flags.flat, &["mesh"]),
    ];
    let idle = all
        .iter()
        .find(|(_, given, of)| *given && !of.contains(&word));
    idle.map(|(flag, ..)| *flag)
}

fn encoding(via: Representation, flags: &VolumeArgs) -> Encoding {
    let usual = match via {
        Representation::Bricks(_) | Representation::Levels(_) => {
            BricksOptions::default().settings.encoding
        }
        _ => Encoding::default(),
    };
    let bits = flags.bits.unwrap_or(usual.format);
    let range = match (flags.band, flags.stride) {
        (Some(voxels), _) => Band::Voxels(voxels),
        (None, Some(stride)) => Band::Stride(stride),
        (None, None) if bits == usual.format => usual.band,
        (None, None) => Band::default(),
    };
    Encoding {
        format: bits,
        band: range,
    }
}

/// Returns a file's path relative to a scene's folder, with `/` as separator.
pub(crate) fn from_folder(file: &Path, scene: &Path) -> anyhow::Result<String> {
    let place = |path: &Path| -> anyhow::Result<PathBuf> {
        let path = if path.as_os_str().is_empty() {
            Path::new(".")
        } else {
            path
        };
        path.canonicalize()
            .with_context(|| path.display().to_string())
    };
    let file = place(file)?;
    let folder = place(scene.parent().unwrap_or(Path::new(".")))?;
    let common = file
        .components()
        .zip(folder.components())
        .take_while(|(a, b)| a == b)
        .count();
    let up = folder.components().skip(common).map(|_| "..".into());
    let down = file.components().skip(common);
    let parts: Vec<String> = up
        .chain(down.map(|part| part.as_os_str().to_string_lossy().into_owned()))
        .collect();
    Ok(parts.join("/"))
}

/// Returns the paths of a scene's meshes relative to another file.
pub(crate) fn moved_meshes(
    scene: &Scene,
    from: &Path,
    to: &Path,
) -> anyhow::Result<BTreeMap<String, String>> {
    let folder = from.parent().unwrap_or(Path::new("."));
    let mut paths = BTreeMap::new();
    for path in scene.mesh_paths() {
        // A volume contains its meshes: if their files do not exist, they keep their names.
        let file = folder.join(&path);
        if file.exists() {
            paths.insert(path, from_folder(&file, to)?);
        }
    }
    Ok(paths)
}
