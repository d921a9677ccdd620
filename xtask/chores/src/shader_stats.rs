//! The task `shader-stats`: what a hardware compiler makes of our shaders, without the hardware.

mod compiler;
mod table;

use self::compiler::Compiler;
use self::table::{Table, limits};
use anyhow::{Context, bail};
use argil::gpu::{ShaderModule, hardware_modules};
use argil_field::{Interpreter, Program};
use argil_scene::Scene;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use xtask::root;

/// The GPU of the committed table: the Radeon RX 6800 XT of the 2023 study.
const FAMILY: &str = "navi21";
/// GPUs that RADV can stand in for. It ends the process at another name.
const FAMILIES: [&str; 12] = [
    "polaris10",
    "vega10",
    "vega20",
    "raven",
    "renoir",
    "navi10",
    "navi14",
    "navi21",
    "navi22",
    "navi23",
    "vangogh",
    "gfx1100",
];
const PAGE: &str = "docs/shader-stats.md";
/// The scenes of the table.
const SCENES: [&str; 3] = ["csg20", "teapot", "temple"];
/// Folders in which Vulkan drivers are listed.
const DRIVERS: [&str; 3] = [
    "/usr/share/vulkan/icd.d",
    "/usr/local/share/vulkan/icd.d",
    "/etc/vulkan/icd.d",
];

/// Writes the table, or prints it for another GPU.
pub(crate) fn write(family: Option<&str>) -> anyhow::Result<()> {
    let family = family.unwrap_or(FAMILY);
    if !FAMILIES.contains(&family) {
        bail!("unknown GPU {family}: name one of {}", FAMILIES.join(", "));
    }
    let table = measure(family, true)?;
    let text = table.page(family);
    if family == FAMILY {
        std::fs::write(root().join(PAGE), text).with_context(|| PAGE.to_owned())?;
        println!("{PAGE}");
    } else {
        println!("{text}");
    }
    Ok(())
}

/// Compares the committed table with what the compiler says now.
pub(crate) fn check() -> anyhow::Result<()> {
    let text = std::fs::read_to_string(root().join(PAGE)).with_context(|| PAGE.to_owned())?;
    let (now, committed) = (measure(FAMILY, false)?, Table::parse(&text)?);
    let mut faults = limits(&now);
    faults.extend(now.worse_than(&committed));
    if faults.is_empty() {
        println!("{} entry points, on {}", now.rows.len(), now.device);
        return Ok(());
    }
    bail!(
        "{}\nhelp: mend the shader, or write {PAGE} again with `cargo xtask shader-stats` and say why in the commit",
        faults.join("\n")
    )
}

/// Returns RADV's file among the lists of drivers.
fn driver() -> anyhow::Result<PathBuf> {
    let folders = DRIVERS
        .iter()
        .filter_map(|folder| std::fs::read_dir(folder).ok());
    let mut files = folders.flatten().flatten().map(|file| file.path());
    let is_radv = |path: &PathBuf| {
        path.file_name()
            .is_some_and(|name| name.to_string_lossy().starts_with("radeon_icd"))
    };
    files.find(is_radv).context(
        "Mesa's RADV is missing. On Debian and Ubuntu: sudo apt-get install mesa-vulkan-drivers libvulkan1",
    )
}

/// Lets the Vulkan loader of this process find nothing but a GPU that is not there.
fn pretend(family: &str) -> anyhow::Result<()> {
    let variables = [
        ("VK_ICD_FILENAMES", driver()?.into_os_string()),
        ("VK_DRIVER_FILES", driver()?.into_os_string()),
        ("RADV_FORCE_FAMILY", family.into()),
        ("MESA_SHADER_CACHE_DISABLE", "true".into()),
    ];
    for (name, value) in variables {
        // SAFETY: no other thread runs yet.
        unsafe { std::env::set_var(name, value) };
    }
    Ok(())
}

/// An entry point to compile, and the scenes that have it.
struct Work {
    scenes: Vec<&'static str>,
    module: String,
    entry_point: &'static str,
    group: [u32; 3],
    words: Vec<u32>,
    resolved: naga::Module,
}

/// Compiles every compute entry point of the scenes, each distinct one once.
fn measure(family: &str, counts_loads: bool) -> anyhow::Result<Table> {
    pretend(family)?;
    let compiler = Compiler::open(counts_loads)?;
    let mut modules: Vec<(ShaderModule, Vec<&'static str>)> = Vec::new();
    let mut slots = Vec::new();
    for scene in SCENES {
        let path = format!("scenes/{scene}.json");
        let program = program_of(&root().join(&path)).with_context(|| path.clone())?;
        slots.push((scene, Interpreter::full(&program).stack_slots()));
        for module in hardware_modules(&program) {
            let is_same =
                |other: &ShaderModule| other.name == module.name && other.source == module.source;
            match modules.iter_mut().find(|(other, _)| is_same(other)) {
                Some((_, scenes)) => scenes.push(scene),
                None => modules.push((module, vec![scene])),
            }
        }
    }
    let all = translated(&modules)?;
    let rows = compiled(&compiler, &all)?;
    Ok(Table {
        device: compiler.name.clone(),
        slots,
        rows,
    })
}

fn program_of(path: &Path) -> anyhow::Result<Program> {
    let scene = Scene::from_json(&std::fs::read_to_string(path)?, path)?;
    Ok(Program::lower(&scene)?)
}

/// Translates modules on all cores. Returns each distinct entry point once, in order.
fn translated(modules: &[(ShaderModule, Vec<&'static str>)]) -> anyhow::Result<Vec<Work>> {
    let translate = |index: usize| {
        let (module, scenes) = &modules[index];
        works(module, scenes).with_context(|| module.name.clone())
    };
    let mut all: Vec<Work> = Vec::new();
    // Equal entry points of a name belong to different scenes.
    let mut known: HashMap<(String, &'static str, Vec<u32>), usize> = HashMap::new();
    for works in on_all_cores(modules.len(), translate) {
        for work in works? {
            let key = (work.module.clone(), work.entry_point, work.words.clone());
            match known.get(&key) {
                Some(&index) => all[index].scenes.extend(work.scenes),
                None => {
                    known.insert(key, all.len());
                    all.push(work);
                }
            }
        }
    }
    Ok(all)
}

/// Runs a function for each index below a count. Returns the results in order.
fn on_all_cores<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let results: Mutex<Vec<(usize, T)>> = Mutex::default();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= count {
                        break;
                    }
                    let result = work(index);
                    let mut results = results.lock().unwrap_or_else(PoisonError::into_inner);
                    results.push((index, result));
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// Compiles on all cores. Returns one row per entry point, in order. Modules that share a pass share its statistics.
fn compiled(compiler: &Compiler, all: &[Work]) -> anyhow::Result<Vec<table::Row>> {
    let mut distinct: HashMap<&[u32], usize> = HashMap::new();
    let mut first = Vec::new();
    for (index, work) in all.iter().enumerate() {
        distinct.entry(&work.words).or_insert_with(|| {
            first.push(index);
            first.len() - 1
        });
    }
    let statistics = |index: usize| {
        let work = &all[first[index]];
        let name = || format!("{} {}", work.module, work.entry_point);
        let statistics = compiler.compile(&work.words, &work.resolved, work.entry_point);
        statistics.with_context(name)
    };
    let statistics = on_all_cores(first.len(), statistics).into_iter();
    let statistics: Vec<_> = statistics.collect::<anyhow::Result<_>>()?;
    let row = |work: &Work| table::Row {
        scenes: work.scenes.join(" "),
        module: work.module.clone(),
        entry_point: work.entry_point.to_owned(),
        group: work.group,
        statistics: statistics[distinct[&work.words[..]]].clone(),
    };
    Ok(all.iter().map(row).collect())
}

/// Returns the SPIR-V of each entry point of a module, with the checks that wgpu asks naga for.
fn works(module: &ShaderModule, scenes: &[&'static str]) -> anyhow::Result<Vec<Work>> {
    use naga::back::{pipeline_constants::process_overrides, spv};
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    let parsed = naga::front::wgsl::parse_str(&module.source)
        .map_err(|error| anyhow::anyhow!(error.emit_to_string(&module.source)))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&parsed)?;
    let options = spv::Options {
        lang_version: (1, 5),
        flags: spv::WriterFlags::empty(),
        bounds_check_policies: naga::proc::BoundsCheckPolicies {
            index: naga::proc::BoundsCheckPolicy::Restrict,
            buffer: naga::proc::BoundsCheckPolicy::Unchecked,
            ..Default::default()
        },
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::Native,
        ..Default::default()
    };
    let mut all = Vec::new();
    for entry_of_module in &module.entry_points {
        let constants = entry_of_module.constants.iter();
        let constants = constants
            .map(|&(name, value)| (name.to_owned(), value))
            .collect();
        let which = (naga::ShaderStage::Compute, entry_of_module.name);
        let (resolved, info) = process_overrides(&parsed, &info, Some(which), &constants)?;
        let pipeline = spv::PipelineOptions {
            shader_stage: naga::ShaderStage::Compute,
            entry_point: entry_of_module.name.to_owned(),
        };
        let words = spv::write_vec(&resolved, &info, &options, Some(&pipeline))?;
        let mut entries = resolved.entry_points.iter();
        let entry = entries.find(|entry| entry.name == entry_of_module.name);
        all.push(Work {
            scenes: scenes.to_vec(),
            module: module.name.clone(),
            entry_point: entry_of_module.name,
            group: entry.map_or([0; 3], |entry| entry.workgroup_size),
            words,
            resolved: resolved.into_owned(),
        });
    }
    Ok(all)
}
