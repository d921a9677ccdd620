//! Tests edits in place: after any sequence of edits, undos and redos, bricks are bit-equal to a fresh bake.
//!
//! *Length.* A test for each kind of edit, with the random sessions that they share.

use argil_conformance::{
    CaseRng, EditRig, Wait, gpu, random_blends, random_scene, shapes, shipped,
};
use argil_gpu::Gpu;
use argil_scene::{
    Brush, Edit, Group, Material, Modifier, NodeDesc, NodeId, NodeKind, Scene, Shape,
};
use argil_volume::{BrickSettings, Encoding, SampleFormat};
use std::sync::Arc;

/// Applies a random edit to a random node, or an undo or redo.
fn disturb(scene: &mut Scene, numbers: &mut CaseRng, materials: &[String]) {
    let nodes: Vec<NodeId> = scene.iter().filter(|&n| n != Scene::ROOT).collect();
    let pick = |numbers: &mut CaseRng, n: usize| (numbers.unit() * n as f32) as usize % n.max(1);
    let Some(&node) = nodes.get(pick(numbers, nodes.len())) else {
        scene.undo();
        return;
    };
    let by = Modifier::Translate {
        by: (numbers.point(1.0) * 0.1).to_array(),
    };
    let size = numbers.between(0.05, 0.25);
    let edit = match pick(numbers, 9) {
        0 => Edit::Remove { node },
        1 | 2 => Edit::Transform { node, by },
        3 => Edit::SetVisible {
            node,
            visible: !scene.node(node).desc().visible,
        },
        4 => {
            let parent = scene.node(node).parent().unwrap_or(Scene::ROOT);
            let count = scene.node(parent).children().len();
            let index = pick(numbers, count);
            Edit::Move {
                node,
                parent,
                index,
            }
        }
        5 | 6 => {
            let mut brush = Brush::new(Shape::rounded_box(
                [size, 0.7 * size, 0.5 * size],
                0.1 * size,
            ))
            .rotated([0.3, 1.0, 0.2], 360.0 * numbers.unit())
            .at(numbers.point(0.8).to_array())
            .smooth(0.2 * size);
            if numbers.unit() < 0.4 {
                brush = brush.subtract();
            }
            if !materials.is_empty() {
                brush = brush.with_material(materials[pick(numbers, materials.len())].clone());
            }
            let children = scene.node(Scene::ROOT).children().len();
            Edit::Insert {
                parent: Scene::ROOT,
                index: pick(numbers, children + 1),
                desc: brush.into(),
            }
        }
        7 => {
            scene.undo();
            return;
        }
        _ => {
            scene.redo();
            return;
        }
    };
    // What is refused changes nothing.
    let _ = scene.apply(edit);
}

/// Sculpts on the CPU. Reports how often the world was rebuilt, because adding or removing copies and chamfers
/// changes bounds of all distances.
fn sculpt(
    name: &str,
    scene: &mut Scene,
    resolution: u32,
    settings: &BrickSettings,
    edits: usize,
) -> usize {
    sculpt_on(None, name, scene, (resolution, settings), edits, 4)
}

/// The same on a GPU, compared with a fresh bake after several edits at a time.
fn sculpt_on(
    gpu: Option<Arc<Gpu>>,
    name: &str,
    scene: &mut Scene,
    (resolution, settings): (u32, &BrickSettings),
    edits: usize,
    period: usize,
) -> usize {
    let mut numbers = CaseRng::new(91);
    let materials: Vec<String> = scene.materials().keys().cloned().collect();
    let mut clay = EditRig::on(gpu, scene, resolution, settings);
    assert_eq!(clay.differing(scene), 0, "{name}");
    for index in 0..edits {
        disturb(scene, &mut numbers, &materials);
        clay.follow(scene);
        if index % period == period - 1 {
            assert_eq!(clay.differing(scene), 0, "{name}, edit {index}");
        }
    }
    // All the way back, and forth again.
    while scene.undo().is_some() {}
    clay.follow(scene);
    assert_eq!(clay.differing(scene), 0, "{name}, undone");
    while scene.redo().is_some() {}
    clay.follow(scene);
    assert_eq!(clay.differing(scene), 0, "{name}, done again");
    clay.trim();
    assert_eq!(clay.differing(scene), 0, "{name}, trimmed");
    clay.rebakes
}

/// Edits with the limits and texture formats of every WebGPU device, as in a browser.
#[test]
fn edits_are_the_same_on_the_least_device() {
    let gpu = Arc::new(Gpu::open_portable().wait().expect("a device"));
    for bits in [SampleFormat::Snorm8, SampleFormat::Snorm16] {
        let mut case = random_blends(71, 20);
        let usual = BrickSettings::default();
        let settings = BrickSettings {
            encoding: Encoding {
                format: bits,
                ..usual.encoding
            },
            ..usual
        };
        let on = Some(gpu.clone());
        sculpt_on(on, &case.name, &mut case.scene, (64, &settings), 16, 4);
    }
}

#[test]
fn edited_bricks_equal_a_fresh_bake() {
    let (mut edits, mut rebakes) = (0, 0);
    for (i, mut case) in shipped().into_iter().enumerate() {
        let settings = BrickSettings {
            brick_size_voxels: [8, 4, 16][i % 3],
            ..BrickSettings::default()
        };
        rebakes += sculpt(&case.name, &mut case.scene, 96, &settings, 24);
        edits += 24;
    }
    for seed in 60..66 {
        let mut case = random_blends(seed, 30);
        let mut settings = BrickSettings::default();
        if seed % 2 == 0 {
            settings.encoding = Encoding::default();
        }
        rebakes += sculpt(&case.name, &mut case.scene, 128, &settings, 40);
        edits += 40;
    }
    // Hardly any makes everything again.
    println!("{rebakes} of {edits} edits caused a rebuild");
    assert!(50 * rebakes <= edits, "{rebakes} of {edits}");
}

#[test]
fn many_small_brushes_and_groups_are_edited_in_place() {
    let mut scene = random_scene(600, 5);
    let group = scene.push(Group::new().smooth(0.05)).expect("a group").node;
    for i in 0..5 {
        let ball: NodeDesc = Brush::new(Shape::sphere(0.1))
            .at([0.1 * i as f32 - 0.2, 0.9, 0.0])
            .smooth(0.04)
            .into();
        scene.push_into(group, ball).expect("a valid brush");
    }
    let settings = BrickSettings::default();
    assert!(sculpt("six hundred", &mut scene, 160, &settings, 60) <= 3);
}

/// Brushes of all shapes are appended, one or several per edit. The samples of bricks tell where they can matter.
#[test]
fn appended_brushes_are_followed() {
    for seed in 0..6u64 {
        let mut numbers = CaseRng::new(300 + seed);
        let mut scene = random_blends(80 + seed, 12).scene;
        let usual = BrickSettings::default();
        let settings = BrickSettings {
            brick_size_voxels: [8, 4, 16][seed as usize % 3],
            encoding: [Encoding::default(), usual.encoding][seed as usize / 3],
        };
        let mut clay = EditRig::of(&mut scene, 80, &settings);
        let shapes = shapes();
        for index in 0..36 {
            for _ in 0..1 + index % 3 {
                let (_, shape) = &shapes[(numbers.unit() * shapes.len() as f32) as usize];
                let mut brush = Brush::new(shape.clone())
                    .scaled(numbers.between(0.1, 0.5))
                    .rotated([0.3, 1.0, 0.2], 360.0 * numbers.unit())
                    .at(numbers.point(1.0).to_array())
                    .smooth(numbers.between(-0.02, 0.1).max(0.0));
                if numbers.unit() < 0.6 {
                    brush = brush.subtract();
                }
                // What is refused changes nothing.
                let _ = scene.push(brush);
            }
            clay.follow(&mut scene);
            if index % 6 == 5 {
                assert_eq!(clay.differing(&scene), 0, "seed {seed}, edit {index}");
            }
        }
    }
}

/// Where there are many brushes, cells near the surface depend on nearby brushes, up to the depth of a carve, which
/// can exceed all earlier depths.
#[test]
fn appended_brushes_among_many_are_followed() {
    for seed in 0..3u64 {
        let mut numbers = CaseRng::new(500 + seed);
        let mut scene = Scene::new();
        for (name, color) in [("red", [0.8, 0.1, 0.1]), ("blue", [0.1, 0.1, 0.8])] {
            scene
                .set_material(name, Material::colored(color))
                .expect("a material");
        }
        let arena = Shape::rounded_box([1.0, 0.6, 1.0], 0.0);
        scene.push(Brush::new(arena)).expect("a brush");
        let put = |scene: &mut Scene, numbers: &mut CaseRng, least: f32, most: f32| {
            let size = numbers.between(least, most);
            let shape = if numbers.unit() < 0.7 {
                Shape::sphere(size)
            } else {
                Shape::rounded_box([size, 0.5 * size, 1.5 * size], 0.2 * size)
            };
            let mut brush = Brush::new(shape)
                .at(numbers.point(1.0).to_array())
                .smooth(numbers.between(-0.002, 0.003).max(0.0));
            if numbers.unit() < 0.6 {
                brush = brush.with_material(["red", "blue"][usize::from(numbers.unit() < 0.5)]);
            }
            if numbers.unit() < 0.8 {
                brush = brush.subtract();
            }
            scene.push(brush).expect("a brush");
        };
        for _ in 0..700 {
            put(&mut scene, &mut numbers, 0.04, 0.1);
        }
        let settings = BrickSettings {
            brick_size_voxels: [8, 4, 16][seed as usize],
            ..BrickSettings::default()
        };
        let mut clay = EditRig::of(&mut scene, 96, &settings);
        for index in 0..24 {
            for _ in 0..1 + index % 3 {
                put(&mut scene, &mut numbers, 0.03, 0.4);
            }
            clay.follow(&mut scene);
            if index % 4 == 3 {
                assert_eq!(clay.differing(&scene), 0, "seed {seed}, edit {index}");
            }
        }
    }
}

/// A subtraction, and a later brush that fills exactly the same region. Without the first, the second is hidden.
#[test]
fn a_brush_in_a_hole_appears_with_the_hole() {
    for gpu in [None, Some(gpu())] {
        let mut scene = Scene::new();
        let solid = scene.push(Brush::new(Shape::rounded_box([1.0; 3], 0.0)));
        let solid = solid.expect("a brush").node;
        let inner = Brush::new(Shape::sphere(0.15)).at([0.0, 0.0, 0.7]);
        scene.push(inner).expect("a brush");
        let settings = BrickSettings {
            brick_size_voxels: 4,
            ..BrickSettings::default()
        };
        let resolution = if gpu.is_some() { 192 } else { 256 };
        let mut clay = EditRig::on(gpu, &mut scene, resolution, &settings);
        let by = Modifier::Translate {
            by: [0.0, 0.01, 0.0],
        };
        let nudge = Edit::Transform { node: solid, by };
        scene.apply(nudge).expect("an edit");
        clay.follow(&mut scene);
        let hole = Brush::new(Shape::sphere(0.7)).at([0.0, 0.0, 1.0]);
        let insert = Edit::Insert {
            parent: Scene::ROOT,
            index: 1,
            desc: hole.subtract().into(),
        };
        scene.apply(insert).expect("an edit");
        for round in 0..2 {
            clay.follow(&mut scene);
            assert_eq!(
                clay.differing(&scene),
                0,
                "{round}, done {:?}",
                clay.rebakes
            );
            assert!(scene.undo().is_some());
            clay.follow(&mut scene);
            assert_eq!(
                clay.differing(&scene),
                0,
                "{round}, undone {:?}",
                clay.rebakes
            );
            assert!(scene.redo().is_some());
        }
    }
}

/// The same on the GPU, which takes bricks from the pool and returns them without the CPU.
#[test]
fn gpu_edits_equal_a_fresh_bake() {
    let gpu = gpu();
    // A software device runs every case of an interpreter for every sample: these have few.
    let names = ["csg20", "props", "teapot"];
    let cases = shipped().into_iter().filter(|c| names.contains(&&*c.name));
    let cases = cases.chain((70..72).map(|seed| random_blends(seed, 12)));
    for (i, mut case) in cases.enumerate() {
        let mut settings = BrickSettings {
            brick_size_voxels: [8, 4, 16][i % 3],
            ..BrickSettings::default()
        };
        if i % 2 == 1 {
            settings.encoding = Encoding::default();
        }
        let gpu = Some(gpu.clone());
        // Among so many cells there are edits for which it is counted first what they need.
        let resolution = if settings.brick_size_voxels == 4 {
            96
        } else {
            64
        };
        let how = (resolution, &settings);
        sculpt_on(gpu, &case.name, &mut case.scene, how, 16, 8);
    }
}

/// Returns a random brush: mostly unions and subtractions, and sometimes one that affects everything or jumps.
fn piece(numbers: &mut CaseRng) -> Brush {
    let size = numbers.between(0.04, 0.12);
    let shape = match (3.0 * numbers.unit()) as u32 {
        0 => Shape::sphere(size),
        1 => Shape::torus(size, 0.3 * size),
        _ => Shape::rounded_box([size, 0.6 * size, 0.8 * size], 0.1 * size),
    };
    let mut brush = Brush::new(shape)
        .rotated([0.2, 1.0, 0.4], 360.0 * numbers.unit())
        .at((0.9 * numbers.point(1.0)).to_array())
        .smooth(0.1 * size * numbers.unit());
    match (20.0 * numbers.unit()) as u32 {
        0..5 => brush = brush.subtract(),
        5 => brush = brush.paint(),
        6 => brush = brush.intersect().scaled(4.0),
        7 => brush = brush.chamfer(0.2 * size),
        8 => brush = brush.with_modifier(Modifier::RadialRepeat { count: 7 }),
        9 => brush = brush.with_material("red"),
        _ => {}
    }
    brush
}

/// Applies a random edit to a node in a group, or to a group.
fn disturb_groups(scene: &mut Scene, numbers: &mut CaseRng) {
    let nodes: Vec<NodeId> = scene.iter().filter(|&n| n != Scene::ROOT).collect();
    let is_group = |n: &NodeId| matches!(scene.node(*n).desc().kind, NodeKind::Group);
    let groups: Vec<NodeId> = scene.iter().filter(is_group).collect();
    let pick = |numbers: &mut CaseRng, n: usize| (numbers.unit() * n as f32) as usize % n.max(1);
    let node = nodes[pick(numbers, nodes.len())];
    let parent = groups[pick(numbers, groups.len())];
    let index = pick(numbers, scene.node(parent).children().len() + 1);
    let edit = match pick(numbers, 12) {
        0 => Edit::Remove { node },
        1..4 => Edit::Transform {
            node,
            by: Modifier::Translate {
                by: (numbers.point(1.0) * 0.1).to_array(),
            },
        },
        4 => Edit::Transform {
            node,
            by: Modifier::Scale {
                by: numbers.between(0.8, 1.25),
            },
        },
        5 => Edit::SetVisible {
            node,
            visible: !scene.node(node).desc().visible,
        },
        6 | 7 => Edit::Move {
            node,
            parent,
            index,
        },
        8 => Edit::Insert {
            parent,
            index,
            desc: Group::new().smooth(0.01 * numbers.unit()).into(),
        },
        9 => {
            // What a group does to what it holds.
            let mut group = Group::new().smooth(0.01 * numbers.unit());
            match pick(numbers, 6) {
                0 => group = group.subtract(),
                1 => {
                    group = group.with_modifier(Modifier::Mirror {
                        axes: [true, false, false],
                    })
                }
                2 => group = group.with_modifier(Modifier::Round { radius: 0.01 }),
                3 => group = group.with_material("red"),
                _ => group = group.rotated([0.0, 1.0, 0.0], 30.0),
            }
            Edit::Replace {
                node: parent,
                desc: group.into(),
            }
        }
        _ => Edit::Insert {
            parent,
            index,
            desc: piece(numbers).into(),
        },
    };
    // What is refused changes nothing.
    let _ = scene.apply(edit);
}

/// Nested groups that open and close, move and subtract: after any edits in them, bricks equal a fresh bake.
#[test]
fn contents_of_groups_are_edited_in_place() {
    let (mut edits, mut rebakes) = (0, 0);
    for seed in 0..4 {
        let mut numbers = CaseRng::new(700 + seed);
        let mut scene = Scene::new();
        let red = Material {
            base_color: [1.0, 0.0, 0.0],
            ..Material::default()
        };
        scene.set_material("red", red).expect("a material");
        let mut group = Scene::ROOT;
        for depth in 0..6 {
            for _ in 0..5 {
                let brush = piece(&mut numbers);
                scene.push_into(group, brush).expect("a brush");
            }
            let inner = Group::new()
                .rotated([0.3, 0.9, 0.1], 25.0 * depth as f32)
                .scaled([0.7, 1.3][depth % 2])
                .at([1.4, -0.9, 0.6])
                .smooth(0.005);
            group = scene.push_into(group, inner).expect("a group").node;
        }
        let settings = BrickSettings {
            brick_size_voxels: 4,
            ..BrickSettings::default()
        };
        // A list is of a part of 64 voxels.
        let mut clay = EditRig::on(None, &mut scene, 512, &settings);
        for index in 0..40 {
            for _ in 0..=index % 3 {
                disturb_groups(&mut scene, &mut numbers);
                edits += 1;
            }
            clay.follow(&mut scene);
            assert_eq!(clay.differing(&scene), 0, "seed {seed}, edit {index}");
        }
        while scene.undo().is_some() {}
        clay.follow(&mut scene);
        assert_eq!(clay.differing(&scene), 0, "seed {seed}, undone");
        rebakes += clay.rebakes;
    }
    println!("{rebakes} of {edits} edits caused a rebuild");
}
