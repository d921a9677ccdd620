//! All experiments: the 2023 study's, and others beyond its limits.
//!
//! *Length.* One function per experiment, which lists its cases.

use crate::configuration::{
    BRICKS, Configuration, ConfigurationKind, DENSE, MESH, MIPPED, STUDY_OCTREE,
};
use crate::experiment::{Compared, Experiment, StudyCase};
use crate::hardware;
use crate::plan::{Plan, Preset};
use crate::scenes::OF_THE_STUDY;
use crate::task::{FrameSeries, Look, StudyCamera, Task};
use argil::render::{NormalSource, RenderMode};
use argil::volume::SampleFormat;

/// The experiments, in the order of the report.
pub const ALL: &[Experiment] = &[
    Experiment {
        name: "construction",
        title: "Octree build time",
        question: "How does the build time of an octree grow with the number of bricks, and which stage takes most of it?",
        study: "Figures 21 and 22: spheres in 1 to 512 bricks of 32³, 256³ voxels of 8 bits, mean of 4 runs. All 512 bricks took about 72 µs on a Radeon RX 6800 XT; extrapolated to 1024×1024×512 voxels, 2.3 ms.",
        compared: Compared::All,
        cases: construction,
    },
    Experiment {
        name: "dense-fill",
        title: "Dense fill",
        question: "How long does it take to fill a dense volume, with one thread per workgroup as the study did first, and by tiles?",
        study: "Section 3.4.1: one thread per workgroup was about 130 % slower than tiles, and was dropped.",
        compared: Compared::SameScene,
        cases: dense_fill,
    },
    Experiment {
        name: "bakes",
        title: "Bakes",
        question: "How long does it take to build each volume of four scenes, at which resolution?",
        study: "Not measured. The study extrapolates from 256³ voxels.",
        compared: Compared::SameScene,
        cases: hardware::bakes,
    },
    Experiment {
        name: "frames",
        title: "Frames around five scenes",
        question: "How long does a frame of each representation take, and how much does that vary?",
        study: "Figures 23 and 24: 250 frames of each scene, octree against dense. The octree was slower and varied more. The teapot as a function took 2,405.88 µs on average.",
        compared: Compared::SameScene,
        cases: frames,
    },
    Experiment {
        name: "heat",
        title: "Steps per ray",
        question: "How many steps does a ray take, and which kinds of steps?",
        study: "Figure 25: the maximum was about 128 to 134 steps for both. In dense scenes, the octree took fewer.",
        compared: Compared::Apart,
        cases: heat,
    },
    Experiment {
        name: "fidelity",
        title: "Image error against the field",
        question: "Which image is nearer to the field's: rasterized triangles, or marched distances?",
        study: "Figures 26 to 31, teapot alone: 1,769,333 zero pixels for the marched volume against 1,768,520 for triangles, at 1080p (the text swaps them). The normals made the difference. 68,440 triangles and 205,320 vertices were built in 17.137 ms.",
        compared: Compared::Apart,
        cases: fidelity,
    },
    Experiment {
        name: "convergence",
        title: "Image error by resolution",
        question: "Does the image through sparse bricks converge to the field's as voxels shrink, with normals and with light?",
        study: "Not measured. The study compares images at one resolution, without shadows.",
        compared: Compared::Apart,
        cases: convergence,
    },
    Experiment {
        name: "normals",
        title: "Sources of normals",
        question: "How much does the source of normals change the image?",
        study: "Section 5.4: a change of the normal's bias alone gave smoother images. Figures 8 and 9 show false and true normals of triangles.",
        compared: Compared::Apart,
        cases: normals,
    },
    Experiment {
        name: "strides",
        title: "Range of 8-bit samples",
        question: "How does the length of a quantization step change the error and the image?",
        study: "Section 3.4: a texture stride from 1 to 32, steps of 1/256 to 1/8 of the range between texels.",
        compared: Compared::Apart,
        cases: strides,
    },
    Experiment {
        name: "center",
        title: "Bricks at the center",
        question: "Are the bricks in the right places?",
        study: "Figure 19: an octree with only the 8 central nodes filled.",
        compared: Compared::Apart,
        cases: center,
    },
    Experiment {
        name: "sweep",
        title: "Brick size, depth and branching",
        question: "How much time do bricks and tree each take? A node of an octree has 2³ children, and its depth follows from resolution and brick size. A block of sparse bricks has 4³ cells and no depth.",
        study: "Section 5.4 names this as a limitation: neither could be varied.",
        compared: Compared::SameResolution,
        cases: sweep,
    },
    Experiment {
        name: "cameras",
        title: "From outside, inside and along the surface",
        question: "Are views from inside and along the surface as fast as views from outside?",
        study: "Section 5.4 names this as a limitation: nearly all views were from outside.",
        compared: Compared::SameScene,
        cases: cameras,
    },
    Experiment {
        name: "edits",
        title: "Edits",
        question: "How does the time of an edit depend on the number of brushes, the resolution and the volume that it touches?",
        study: "Edits were not measured. The study concludes that easy edits and fast frames exclude each other.",
        compared: Compared::SameScene,
        cases: edits,
    },
    Experiment {
        name: "memory",
        title: "Memory",
        question: "How much memory does each representation need, tables included, at which resolution?",
        study: "Not measured. The study estimates a saving.",
        compared: Compared::Apart,
        cases: memory,
    },
    Experiment {
        name: "stored",
        title: "Errors of stored distances",
        question: "How far are stored distances from exact ones, within four voxels of the surface?",
        study: "Not measured.",
        compared: Compared::Apart,
        cases: stored,
    },
    Experiment {
        name: "triangles",
        title: "Triangles against the exact surface",
        question: "How far are triangles from the surface, and how much memory do shared vertices save?",
        study: "Section 3.3: triangles without shared vertices, stride 0.05, 100³: 68,440 triangles and 205,320 vertices.",
        compared: Compared::SameScene,
        cases: triangles,
    },
    Experiment {
        name: "pipelines",
        title: "First use of a GPU",
        question: "How much longer does the first use of a GPU take than the second, because pipelines are created?",
        study: "Not measured.",
        compared: Compared::Apart,
        cases: hardware::pipelines,
    },
    Experiment {
        name: "stills",
        title: "Path-traced stills",
        question: "How long do four paths a pixel take, through the field and through bricks?",
        study: "Not measured. The study has no paths of light.",
        compared: Compared::SameScene,
        cases: hardware::stills,
    },
    Experiment {
        name: "peer",
        title: "Frames beside fidget's",
        question: "How long does a frame take, from its submission to its pixels in memory, beside that of fidget-wgpu?",
        study: "Not measured.",
        compared: Compared::SameResolution,
        cases: hardware::peer,
    },
    Experiment {
        name: "lost",
        title: "Lost bricks",
        question: "Does the test of a brick's center lose bricks that contain surface, and does ours?",
        study: "Section 3.5.1: a brick is kept if its center is near the surface. The study does not check this.",
        compared: Compared::Apart,
        cases: lost,
    },
];

fn construction(plan: &Plan) -> Vec<StudyCase> {
    let runs = plan.pick(1, 4, 8);
    let all_sides = &[1, 2, 3, 4, 5, 6, 7, 8][..];
    let mut sides = plan.pick(&[1, 3, 6][..], all_sides, all_sides);
    if plan.preset == Preset::Hardware && plan.is_software_gpu {
        sides = &all_sides[..1];
    }
    // The study's 32³ or, where 256³ voxels take minutes, as many smaller bricks.
    let brick = plan.pick(16, 32, 32);
    let resolution = 8 * brick;
    let mut all = Vec::new();
    for &side in sides {
        let side: u32 = side;
        let count = f64::from(side.pow(3));
        let scene = format!("spheres-{side}");
        // A band of half a brick, which the centers around a sphere are not in.
        let stride = 512 / brick;
        let sorts = plan.is_gpu.then_some(true);
        for enumerated in [false].into_iter().chain(sorts) {
            let kind = ConfigurationKind::Octree {
                brick,
                center: true,
                path: false,
                enumerated,
            };
            let way = Configuration::of(kind, resolution).stride(stride);
            let case = StudyCase::new(&scene, way, Task::Build(runs));
            all.push(case.expect("bricks", count, count));
        }
        let way = Configuration::of(BRICKS, resolution);
        all.push(StudyCase::new(&scene, way, Task::Build(runs)));
    }
    let dense = Configuration::of(DENSE, resolution);
    let last = sides.last().copied().unwrap_or(8);
    all.push(StudyCase::new(
        format!("spheres-{last}"),
        dense,
        Task::Build(runs),
    ));
    all
}

fn dense_fill(plan: &Plan) -> Vec<StudyCase> {
    let runs = plan.pick(1, 4, 8);
    let resolution = plan.pick(64, 256, 256);
    let mut all = Vec::new();
    let scenes = ["brick", "teapot"];
    let is_small = plan.preset == Preset::Hardware && plan.is_software_gpu;
    for &scene in if is_small { &scenes[..1] } else { &scenes[..] } {
        let ways: &[bool] = if plan.is_gpu {
            &[false, true]
        } else {
            &[false]
        };
        for &naive in ways {
            let way =
                Configuration::of(ConfigurationKind::Dense { mips: false, naive }, resolution);
            all.push(StudyCase::new(scene, way, Task::Build(runs)));
        }
        all.push(StudyCase::new(
            scene,
            Configuration::of(STUDY_OCTREE, resolution),
            Task::Build(runs),
        ));
        all.push(StudyCase::new(
            scene,
            Configuration::of(BRICKS, resolution),
            Task::Build(runs),
        ));
    }
    all
}

/// Returns frames with normals from a camera.
fn frames_from(eye: StudyCamera, count: u32) -> Task {
    Task::Frames(FrameSeries {
        count,
        eye,
        ..FrameSeries::default()
    })
}

/// Returns the configurations whose frames are compared.
fn ways(resolution: u32) -> Vec<Configuration> {
    let all = [
        ConfigurationKind::Field,
        DENSE,
        MIPPED,
        STUDY_OCTREE,
        BRICKS,
        MESH,
    ];
    all.map(|kind| Configuration::of(kind, resolution)).to_vec()
}

fn scenes(plan: &Plan) -> Vec<&'static str> {
    // On a software GPU, the last one takes minutes to build.
    plan.pick(
        OF_THE_STUDY[..4].to_vec(),
        OF_THE_STUDY.to_vec(),
        [&OF_THE_STUDY[..], &["csg20", "props", "temple", "trees"]].concat(),
    )
}

fn frames(plan: &Plan) -> Vec<StudyCase> {
    if plan.preset == Preset::Hardware {
        return hardware::frames(plan);
    }
    let mut all = Vec::new();
    for scene in scenes(plan) {
        for way in ways(plan.resolution()) {
            let case = StudyCase::new(scene, way, frames_from(StudyCamera::Outside, plan.frames()));
            all.push(case.expect("hit_pixels", 1.0, f64::INFINITY));
        }
        // The study's functional renderer compiled its scene into the shader.
        if plan.is_gpu && scene == "teapot" {
            let way = Configuration::of(ConfigurationKind::Compiled, plan.resolution());
            all.push(StudyCase::new(
                scene,
                way,
                frames_from(StudyCamera::Outside, plan.frames()),
            ));
        }
    }
    all
}

fn heat(plan: &Plan) -> Vec<StudyCase> {
    let look = Look {
        show: RenderMode::Heat,
        is_compared: false,
        ..Look::default()
    };
    let kinds = [DENSE, MIPPED, STUDY_OCTREE, BRICKS];
    let mut all = Vec::new();
    for scene in OF_THE_STUDY.into_iter().take(plan.pick(3, 5, 5)) {
        for kind in kinds {
            let way = Configuration::of(kind, plan.resolution());
            all.push(StudyCase::new(scene, way, Task::Picture(look)));
        }
    }
    all
}

fn fidelity(plan: &Plan) -> Vec<StudyCase> {
    let mut all = Vec::new();
    let normal = Task::Picture(Look::default());
    for scene in scenes(plan) {
        let resolution = plan.resolution();
        let flat = ConfigurationKind::Mesh {
            dual: false,
            flat: true,
        };
        let dual = ConfigurationKind::Mesh {
            dual: true,
            flat: false,
        };
        all.extend([
            StudyCase::new(
                scene,
                Configuration::of(ConfigurationKind::Field, 0),
                normal,
            ),
            StudyCase::new(scene, Configuration::of(DENSE, resolution), normal),
            StudyCase::new(
                scene,
                Configuration::of(DENSE, resolution).bits(SampleFormat::Snorm16),
                normal,
            ),
            StudyCase::new(scene, Configuration::of(STUDY_OCTREE, resolution), normal),
            StudyCase::new(scene, Configuration::of(BRICKS, resolution), normal),
            // The study's 100³ with face normals, then the volume's resolution.
            StudyCase::new(
                scene,
                Configuration::of(flat, plan.pick(48, 100, 100)),
                normal,
            ),
            StudyCase::new(scene, Configuration::of(flat, resolution), normal),
            StudyCase::new(scene, Configuration::of(MESH, resolution), normal),
            StudyCase::new(scene, Configuration::of(dual, resolution), normal),
            StudyCase::new(
                scene,
                Configuration::of(ConfigurationKind::MeshAsLarge, resolution),
                normal,
            ),
        ]);
    }
    all
}

fn convergence(plan: &Plan) -> Vec<StudyCase> {
    let mut all = Vec::new();
    let few = ["csg20", "teapot", "trees"];
    let many = [
        "csg20",
        "teapot",
        "trees",
        "temple",
        "melting",
        "edgy-cube",
        "props",
        "dense-edgy-cubes",
    ];
    let resolutions: &[u32] = plan.pick(&[32, 64], &[128, 256, 512], &[128, 256, 512, 1024]);
    for show in [RenderMode::Shaded, RenderMode::Normal] {
        for scene in plan.pick(&few[..1], &few[..], &many[..]) {
            for &resolution in resolutions {
                let look = Look {
                    show,
                    is_close: true,
                    ..Look::default()
                };
                let way = Configuration::of(BRICKS, resolution);
                all.push(StudyCase::new(*scene, way, Task::Picture(look)));
            }
        }
    }
    all
}

fn normals(plan: &Plan) -> Vec<StudyCase> {
    let mut all = Vec::new();
    let resolution = plan.resolution();
    let biases: &[f32] = plan.pick(
        &[1.0],
        &[0.25, 0.5, 1.0, 2.0],
        &[0.1, 0.25, 0.5, 1.0, 2.0, 4.0],
    );
    for &bias in biases {
        let look = Look {
            bias_voxels: Some(bias),
            ..Look::default()
        };
        all.push(StudyCase::new(
            "teapot",
            Configuration::of(DENSE, resolution),
            Task::Picture(look),
        ));
    }
    for normals in [
        NormalSource::Voxel,
        NormalSource::Smooth,
        NormalSource::Field,
    ] {
        let look = Look {
            normals,
            ..Look::default()
        };
        all.push(StudyCase::new(
            "teapot",
            Configuration::of(BRICKS, resolution),
            Task::Picture(look),
        ));
    }
    // The study's strides of 0.05 and 0.01 in its box of size 5.
    let sizes: &[u32] = plan.pick(&[48], &[100, 500], &[100, 500]);
    for &resolution in sizes {
        for flat in [false, true] {
            let way = Configuration::of(ConfigurationKind::Mesh { dual: false, flat }, resolution);
            all.push(StudyCase::new(
                "teapot",
                way,
                Task::Picture(Look::default()),
            ));
        }
    }
    all
}

fn strides(plan: &Plan) -> Vec<StudyCase> {
    let mut all = Vec::new();
    for stride in [1, 2, 4, 8, 16, 32] {
        let way = Configuration::of(DENSE, plan.resolution()).stride(stride);
        all.push(StudyCase::new(
            "teapot",
            way,
            Task::Picture(Look::default()),
        ));
        if !plan.is_gpu {
            all.push(StudyCase::new("teapot", way, Task::Stored(400_000)));
        }
    }
    all
}

fn center(plan: &Plan) -> Vec<StudyCase> {
    let look = Look {
        show: RenderMode::Bricks,
        is_compared: false,
        ..Look::default()
    };
    let way = Configuration::of(STUDY_OCTREE, plan.pick(128, 256, 256));
    let count = plan.pick(8.0, 8.0, 8.0);
    let case = StudyCase::new("center", way, Task::Picture(look));
    vec![case.expect("bricks", count, count)]
}

fn sweep(plan: &Plan) -> Vec<StudyCase> {
    let mut all = Vec::new();
    let resolutions: &[u32] = plan.pick(&[64], &[128, 256], &[128, 256, 512]);
    for &resolution in resolutions {
        for brick in [8, 16, 32] {
            for path in [false, true] {
                let kind = ConfigurationKind::Octree {
                    brick,
                    center: false,
                    path,
                    enumerated: false,
                };
                let way = Configuration::of(kind, resolution);
                let task = frames_from(StudyCamera::Outside, plan.pick(3, 8, 20));
                all.push(StudyCase::new("teapot", way, task));
            }
        }
        for brick in [4, 8, 16] {
            let way = Configuration::of(ConfigurationKind::Bricks { brick }, resolution);
            let task = frames_from(StudyCamera::Outside, plan.pick(3, 8, 20));
            all.push(StudyCase::new("teapot", way, task));
        }
    }
    all
}

fn cameras(plan: &Plan) -> Vec<StudyCase> {
    let mut all = Vec::new();
    for scene in plan.pick(
        vec!["teapot"],
        vec!["teapot", "props"],
        vec!["teapot", "props", "temple"],
    ) {
        for eye in [
            StudyCamera::Outside,
            StudyCamera::Inside,
            StudyCamera::Grazing,
        ] {
            for kind in [ConfigurationKind::Field, MIPPED, STUDY_OCTREE, BRICKS] {
                let way = Configuration::of(kind, plan.resolution());
                let task = frames_from(eye, plan.pick(3, 8, 20));
                all.push(StudyCase::new(scene, way, task));
            }
            let way = Configuration::of(BRICKS, plan.resolution());
            let look = Look {
                eye,
                ..Look::default()
            };
            all.push(StudyCase::new(scene, way, Task::Picture(look)));
        }
    }
    all
}

fn edits(plan: &Plan) -> Vec<StudyCase> {
    if plan.preset == Preset::Hardware {
        return hardware::edits(plan);
    }
    let mut all = Vec::new();
    let count = plan.pick(4, 40, 200);
    let mut add = |scene: &str, kind: ConfigurationKind, resolution: u32, radius: f32| {
        let count = if kind == BRICKS { count } else { count.min(5) };
        let task = Task::Edits(count, radius);
        all.push(StudyCase::new(
            scene,
            Configuration::of(kind, resolution),
            task,
        ));
    };
    let crowds: &[&str] = plan.pick(
        &["crowd-10"],
        &["crowd-100", "crowd-1000", "crowd-10000"],
        &["crowd-100", "crowd-1000", "crowd-10000", "crowd-100000"],
    );
    for scene in crowds {
        add(scene, BRICKS, plan.pick(64, 256, 512), 0.02);
    }
    let resolutions: &[u32] = plan.pick(&[64], &[128, 256, 512], &[128, 256, 512, 1024]);
    for &resolution in resolutions {
        add("csg20", BRICKS, resolution, 0.02);
    }
    for radius in [0.01, 0.04, 0.08] {
        add("csg20", BRICKS, plan.resolution(), radius);
    }
    for kind in [STUDY_OCTREE, DENSE] {
        add("csg20", kind, plan.resolution(), 0.02);
    }
    all
}

fn memory(plan: &Plan) -> Vec<StudyCase> {
    if plan.preset == Preset::Hardware {
        return hardware::memory(plan);
    }
    let mut all = Vec::new();
    let resolutions: &[u32] = plan.pick(&[64], &[256, 512], &[256, 512, 1024]);
    for scene in ["teapot", "csg20"] {
        for &resolution in resolutions {
            for kind in [DENSE, MIPPED, STUDY_OCTREE, BRICKS] {
                all.push(StudyCase::new(
                    scene,
                    Configuration::of(kind, resolution),
                    Task::Build(1),
                ));
            }
            let eight = Configuration::of(BRICKS, resolution).bits(SampleFormat::Snorm8);
            all.push(StudyCase::new(scene, eight, Task::Build(1)));
        }
    }
    all
}

fn stored(plan: &Plan) -> Vec<StudyCase> {
    let mut all = Vec::new();
    if plan.is_gpu {
        return all;
    }
    for scene in ["teapot", "csg20", "edgy-cube"] {
        for kind in [DENSE, BRICKS] {
            for bits in [SampleFormat::Snorm8, SampleFormat::Snorm16] {
                let way = Configuration::of(kind, plan.resolution()).bits(bits);
                all.push(StudyCase::new(scene, way, Task::Stored(1_000_000)));
            }
        }
    }
    all
}

fn triangles(plan: &Plan) -> Vec<StudyCase> {
    if plan.preset == Preset::Hardware {
        return hardware::triangles(plan);
    }
    let mut all = Vec::new();
    if plan.is_software_gpu {
        return all;
    }
    let resolutions: &[u32] = plan.pick(&[48], &[50, 100, 200], &[50, 100, 200, 400]);
    for scene in ["teapot", "csg20", "edgy-cube"] {
        for &resolution in resolutions {
            for (dual, flat) in [(false, false), (false, true), (true, false)] {
                let way = Configuration::of(ConfigurationKind::Mesh { dual, flat }, resolution);
                all.push(StudyCase::new(scene, way, Task::Surface(20_000)));
            }
        }
    }
    all
}

fn lost(plan: &Plan) -> Vec<StudyCase> {
    let mut all = Vec::new();
    if plan.is_gpu {
        return all;
    }
    for scene in scenes(plan) {
        for center in [false, true] {
            let kind = ConfigurationKind::Octree {
                brick: 32,
                center,
                path: false,
                enumerated: false,
            };
            let case = StudyCase::new(scene, Configuration::of(kind, 256), Task::CountLostBricks);
            all.push(if center {
                case
            } else {
                case.expect("lost_bricks", 0.0, 0.0)
            });
        }
        let case = StudyCase::new(scene, Configuration::of(BRICKS, 256), Task::CountLostBricks);
        all.push(case.expect("lost_bricks", 0.0, 0.0));
    }
    all
}
