//! What the conformance tests share: scenes that use every part of the field, points to try them at, and the GPU.
//!
//! The tests stand in `tests/`: each pass's contract, on every back end, at the buffer, with a negative control beside
//! each comparison that shows that it can fail.

mod clay;
mod random;

use argil_abi::Frame;
use argil_field::Program;
use argil_gpu::{Gpu, GpuField};
use argil_math::{Aabb, Ray};
use argil_scene::{
    Brush, Group, Material, MeshGrid, Modifier, NodeId, Outline, Piece, SampledGrid, Scene, Shape,
};
use argil_volume::{Bits, Lattice, Texels};
use glam::Vec3;
use std::sync::Arc;

pub use clay::Clay;
pub use random::random_scene;

/// A scene with a name for messages.
pub struct Case {
    /// What it tries.
    pub name: String,
    /// The scene.
    pub scene: Scene,
}

/// Numbers that look random and are the same each time: a 64-bit linear congruential generator (Knuth's constants).
pub struct Numbers(u64);

impl Numbers {
    /// From a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(2_654_435_761).wrapping_add(1))
    }

    /// From 0 to 1.
    pub fn unit(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    /// From `low` to `high`.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// A point of a cube around the origin.
    pub fn point(&mut self, half: f32) -> Vec3 {
        Vec3::new(
            self.between(-half, half),
            self.between(-half, half),
            self.between(-half, half),
        )
    }
}

/// A closed outline of lines and curves that is neither convex nor monotone.
pub fn vase() -> Outline {
    let line = |to| Piece { control: None, to };
    let curve = |control, to| Piece {
        control: Some(control),
        to,
    };
    Outline {
        start: [0.0, -0.6],
        pieces: vec![
            line([0.35, -0.6]),
            curve([0.85, -0.2], [0.3, 0.25]),
            curve([0.15, 0.45], [0.45, 0.7]),
            line([0.3, 0.7]),
            curve([0.05, 0.4], [0.0, 0.35]),
        ],
    }
}

/// A cut ring between samples, as a mesh of it would be.
pub fn sampled() -> Shape {
    let measure = |points: &[Vec3], out: &mut [f32]| {
        for (p, out) in points.iter().zip(out) {
            let ring = glam::vec2(glam::vec2(p.x, p.z).length() - 0.5, p.y).length() - 0.2;
            *out = ring.max(p.x + 0.2 * p.y - 0.3);
        }
    };
    let solid = Aabb::new(Vec3::new(-0.7, -0.2, -0.7), Vec3::new(0.36, 0.2, 0.7));
    let cells = glam::uvec3(5, 3, 6);
    let grid = SampledGrid::sample(Vec3::new(-0.8, -0.4, -0.8), 0.27, cells, solid, &measure);
    Shape::Mesh {
        path: "cut ring.obj".into(),
        resolution: 48,
        grid: MeshGrid(Some(Arc::new(grid))),
    }
}

/// Ground with a step, a slope and a bump.
pub fn heights() -> Shape {
    let height = |i: u32, k: u32| match (i, k) {
        (0..3, _) => 0.2,
        (_, 5..) => 0.9 - 0.1 * i as f32,
        _ => 0.3 + 0.07 * ((3 * i + 5 * k) % 4) as f32,
    };
    let all: Vec<f32> = (0..63).map(|i| height(i % 9, i / 9)).collect();
    let grid = SampledGrid::of_heights([9, 7], &all).expect("heights from 0 to 1");
    Shape::Heightmap {
        path: "ground.png".into(),
        half_size: [0.8, 0.6],
        height: 0.5,
        base: 0.15,
        resolution: 16,
        grid: MeshGrid(Some(Arc::new(grid))),
    }
}

/// One of each shape, by the table of shapes, and others of those with a special case.
pub fn shapes() -> Vec<(String, Shape)> {
    [examples(), special_shapes()].concat()
}

/// One of each shape.
fn examples() -> Vec<(String, Shape)> {
    let named = |shape: Shape| (format!("{shape:?}"), shape);
    Shape::examples().into_iter().map(named).collect()
}

fn special_shapes() -> Vec<(String, Shape)> {
    let half_size = [0.5, 0.35, 0.4];
    let special = [
        ("sharp box", Shape::cuboid(half_size)),
        (
            "capsule of length 0",
            Shape::capsule([0.1; 3], [0.1; 3], 0.2),
        ),
        (
            "pointed capped cone",
            Shape::CappedCone {
                half_height: 0.5,
                bottom_radius: 0.0,
                top_radius: 0.4,
            },
        ),
        (
            "leaning plane",
            Shape::Plane {
                normal: [1.0, 2.0, -0.5],
                offset: 0.2,
            },
        ),
        (
            "flat pyramid",
            Shape::Pyramid {
                base: 1.2,
                height: 0.2,
            },
        ),
        (
            "cut sphere below",
            Shape::CutSphere {
                radius: 0.6,
                cut: -0.25,
            },
        ),
        (
            "cut hollow sphere below",
            Shape::CutHollowSphere {
                radius: 0.6,
                cut: -0.3,
                thickness: 0.05,
            },
        ),
        (
            "wide solid angle",
            Shape::SolidAngle {
                radius: 0.7,
                half_angle_degrees: 130.0,
            },
        ),
        (
            "rounder rims than edges",
            Shape::ExtrudedRoundedBox {
                half_size,
                corner_radii: [0.1, 0.3, 0.0, 0.2],
                rounding: [0.1, 0.05],
            },
        ),
        ("vase", Shape::Lathe { outline: vase() }),
        ("mesh", sampled()),
        ("heightmap", heights()),
    ];
    let named = |(name, shape): (&str, Shape)| (name.to_owned(), shape);
    special.into_iter().map(named).collect()
}

fn one(name: &str, brush: Brush) -> Case {
    let mut scene = Scene::new();
    push(&mut scene, Scene::ROOT, brush);
    Case {
        name: name.to_owned(),
        scene,
    }
}

fn push(scene: &mut Scene, group: NodeId, entry: impl Into<argil_scene::Entry>) -> NodeId {
    scene.push_into(group, entry).expect("a valid entry").node
}

/// Each shape, moved and turned, and one of each as it is.
pub fn shape_cases() -> Vec<Case> {
    let placed = |(name, shape): (String, Shape)| {
        one(
            &name,
            Brush::new(shape)
                .rotated([0.3, 1.0, 0.2], 25.0)
                .at([0.1, -0.05, 0.07]),
        )
    };
    // A level plane is seen from along it by cameras that look level: where rays end there is as good as open.
    let is_plane = |shape: &Shape| matches!(shape, Shape::Plane { .. });
    let upright = examples().into_iter().filter(|(_, shape)| !is_plane(shape));
    shapes()
        .into_iter()
        .map(placed)
        .chain(upright.map(|(n, s)| one(&n, Brush::new(s))))
        .collect()
}

/// Each operator with each joint, between a ball and a turned box.
pub fn operator_cases() -> Vec<Case> {
    let mut all = Vec::new();
    type Apply = fn(Brush) -> Brush;
    let operators: [(&str, Apply); 5] = [
        ("union", |b| b),
        ("subtract", Brush::subtract),
        ("intersect", Brush::intersect),
        ("paint", Brush::paint),
        ("morph", |b| b.morph(0.3)),
    ];
    for (name, operator) in operators {
        for (joint, k, chamfer) in [
            ("hard", 0.0, false),
            ("smooth", 0.2, false),
            ("chamfer", 0.2, true),
        ] {
            let mut scene = Scene::new();
            scene
                .set_material("red", Material::colored([0.8, 0.1, 0.1]))
                .expect("a valid material");
            scene
                .set_material("blue", Material::colored([0.1, 0.1, 0.8]))
                .expect("a valid material");
            push(
                &mut scene,
                Scene::ROOT,
                Brush::new(Shape::sphere(0.5)).material("red"),
            );
            let second = Brush::new(Shape::cuboid([0.3; 3]))
                .rotated([1.0, 1.0, 0.0], 30.0)
                .at([0.4, 0.2, 0.0]);
            let second = if chamfer {
                second.chamfer(k)
            } else {
                second.blend(k)
            };
            push(&mut scene, Scene::ROOT, operator(second.material("blue")));
            all.push(Case {
                name: format!("{joint} {name}"),
                scene,
            });
        }
    }
    all
}

/// Each modifier, on a brush and on a blended group, moved, turned and scaled around it.
pub fn modifier_cases() -> Vec<Case> {
    let modifiers: Vec<(&str, Modifier)> = vec![
        (
            "translate",
            Modifier::Translate {
                by: [0.2, -0.1, 0.3],
            },
        ),
        (
            "rotate",
            Modifier::Rotate {
                axis: [1.0, 0.5, -0.2],
                degrees: 40.0,
            },
        ),
        ("scale", Modifier::Scale { by: 0.6 }),
        (
            "stretch",
            Modifier::Stretch {
                by: [1.4, 0.6, 0.9],
            },
        ),
        (
            "mirror",
            Modifier::Mirror {
                axes: [true, false, true],
            },
        ),
        (
            "repeat",
            Modifier::Repeat {
                spacing: [0.9, 0.7, 1.0],
                count: Some([3, 2, 4]),
            },
        ),
        (
            "repeat along x",
            Modifier::Repeat {
                spacing: [0.9, 0.0, 0.0],
                count: Some([3, 1, 1]),
            },
        ),
        (
            "endless repeat",
            Modifier::Repeat {
                spacing: [1.1, 0.0, 1.3],
                count: None,
            },
        ),
        (
            "overlapping repeat",
            Modifier::Repeat {
                spacing: [0.4, 0.0, 0.0],
                count: Some([4, 1, 1]),
            },
        ),
        (
            "elongate",
            Modifier::Elongate {
                by: [0.2, 0.0, 0.1],
            },
        ),
        ("round", Modifier::Round { radius: 0.08 }),
        ("shell", Modifier::Shell { thickness: 0.04 }),
        (
            "twist",
            Modifier::Twist {
                degrees_per_unit: 110.0,
            },
        ),
        (
            "bend",
            Modifier::Bend {
                degrees_per_unit: 50.0,
            },
        ),
        (
            "displace",
            Modifier::Displace {
                amplitude: 0.05,
                frequency: 4.0,
                seed: 7,
                octaves: 3,
            },
        ),
    ];
    let mut all = Vec::new();
    let body = || Brush::new(Shape::rounded_box([0.3, 0.2, 0.25], 0.05)).at([0.06, 0.04, -0.03]);
    for (name, modifier) in modifiers {
        all.push(one(name, body().modify(modifier.clone())));
        let around = body()
            .modify(modifier.clone())
            .rotated([0.0, 1.0, 0.3], 35.0)
            .scaled(1.3)
            .at([0.1, 0.2, 0.0]);
        all.push(one(&format!("{name}, placed"), around));
        let mut scene = Scene::new();
        let group = Group::new()
            .modify(modifier)
            .rotated([1.0, 0.0, 0.3], 20.0)
            .scaled(0.8);
        let group = push(&mut scene, Scene::ROOT, group);
        push(&mut scene, group, body());
        push(
            &mut scene,
            group,
            Brush::new(Shape::sphere(0.18))
                .at([0.15, 0.15, 0.1])
                .blend(0.1),
        );
        all.push(Case {
            name: format!("{name}, group"),
            scene,
        });
    }
    for (name, count, x) in [
        ("ring", 7, 0.7),
        ("ring around the axis", 5, 0.1),
        ("ring of one", 1, 0.5),
        ("ring of two", 2, 0.6),
    ] {
        let spoke = Brush::new(Shape::cuboid([0.2, 0.15, 0.12]))
            .rotated([0.0, 1.0, 0.0], 15.0)
            .at([x, 0.0, 0.05]);
        all.push(one(
            name,
            spoke
                .modify(Modifier::RadialRepeat { count })
                .at([0.1, 0.0, 0.2]),
        ));
    }
    all
}

/// Orders, nesting, cuts of nothing, things unseen.
pub fn structure_cases() -> Vec<Case> {
    let ball = |x: f32, r: f32| Brush::new(Shape::sphere(r)).at([x, 0.0, 0.0]);
    let mut all = vec![Case {
        name: "nothing".into(),
        scene: Scene::new(),
    }];
    all.push(one("a cut of nothing", ball(0.0, 0.5).subtract()));
    all.push(one("a hidden ball", ball(0.0, 0.5).hidden()));

    let mut scene = Scene::new();
    push(&mut scene, Scene::ROOT, ball(0.9, 0.3).subtract());
    push(&mut scene, Scene::ROOT, ball(0.0, 0.5));
    push(
        &mut scene,
        Scene::ROOT,
        ball(0.2, 0.4).intersect().blend(0.1),
    );
    push(&mut scene, Scene::ROOT, Group::new());
    push(&mut scene, Scene::ROOT, Group::new().subtract());
    all.push(Case {
        name: "a cut first, empty groups last".into(),
        scene,
    });

    // A right-deep chain: each group's second operand is a group. The needier operand goes first.
    let mut scene = Scene::new();
    let mut group = Scene::ROOT;
    for depth in 0..40 {
        let angle = depth as f32 * 0.7;
        let at = [
            0.6 * angle.cos(),
            0.02 * depth as f32 - 0.4,
            0.6 * angle.sin(),
        ];
        push(&mut scene, group, Brush::new(Shape::sphere(0.12)).at(at));
        let next = match depth % 4 {
            0 => Group::new().blend(0.05),
            1 => Group::new().subtract().blend(0.03),
            2 => Group::new().chamfer(0.04),
            _ => Group::new().morph(0.9),
        };
        group = push(&mut scene, group, next.rotated([0.0, 1.0, 0.0], 3.0));
    }
    push(&mut scene, group, ball(0.1, 0.2));
    all.push(Case {
        name: "a chain of forty groups".into(),
        scene,
    });

    // Loops in loops under deformations.
    let mut scene = Scene::new();
    let outer = Group::new()
        .modify(Modifier::Repeat {
            spacing: [0.8, 0.0, 0.0],
            count: Some([2, 1, 1]),
        })
        .modify(Modifier::Twist {
            degrees_per_unit: 40.0,
        })
        .modify(Modifier::Shell { thickness: 0.03 });
    let outer = push(&mut scene, Scene::ROOT, outer);
    let ring = push(
        &mut scene,
        outer,
        Group::new().modify(Modifier::RadialRepeat { count: 5 }),
    );
    push(
        &mut scene,
        ring,
        Brush::new(Shape::rounded_box([0.1, 0.2, 0.05], 0.02)).at([0.22, 0.0, 0.0]),
    );
    push(
        &mut scene,
        outer,
        Brush::new(Shape::sphere(0.15))
            .at([0.0, 0.2, 0.0])
            .blend(0.05),
    );
    push(
        &mut scene,
        Scene::ROOT,
        ball(0.0, 0.3)
            .subtract()
            .blend(0.05)
            .modify(Modifier::Round { radius: 0.02 }),
    );
    all.push(Case {
        name: "loops in loops".into(),
        scene,
    });

    // Inside its own cut, a curve is as near as what it is cut from, though its box is 0 away.
    let mut scene = Scene::new();
    let lathe = || Brush::new(Shape::Lathe { outline: vase() });
    push(&mut scene, Scene::ROOT, lathe());
    for _ in 0..2 {
        push(&mut scene, Scene::ROOT, lathe().subtract().blend(0.05));
    }
    all.push(Case {
        name: "a curve cut from itself twice".into(),
        scene,
    });
    all
}

/// Random boxes and capsules, turned and blended: what loses bricks where bounds are not conservative.
pub fn random_blends(seed: u64, brushes: usize) -> Case {
    let mut numbers = Numbers::new(seed);
    let mut scene = Scene::new();
    for i in 0..brushes {
        let size = [
            numbers.between(0.03, 0.3),
            numbers.between(0.02, 0.2),
            numbers.between(0.01, 0.2),
        ];
        let shape = match i % 3 {
            0 => Shape::rounded_box(size, 0.3 * size[0].min(size[1]).min(size[2])),
            1 => Shape::capsule([0.0; 3], [size[0], size[0], 0.0], size[2]),
            _ => Shape::torus(size[0], 0.4 * size[0].min(size[1])),
        };
        let axis = numbers.point(1.0).to_array();
        let turned = Brush::new(shape)
            .rotated(axis, numbers.between(0.0, 360.0))
            .at(numbers.point(0.6).to_array())
            .blend(numbers.between(0.0, 0.15));
        let brush = if i % 5 == 4 {
            turned.subtract()
        } else {
            turned
        };
        push(&mut scene, Scene::ROOT, brush);
    }
    Case {
        name: format!("random blends {seed}"),
        scene,
    }
}

/// The scenes that ship with the project.
pub fn shipped() -> Vec<Case> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes");
    [
        "brick",
        "csg20",
        "dense-edgy-cubes",
        "dense-spheres",
        "edgy-cube",
        "props",
        "melting",
        "morph",
        "teapot",
        "temple",
        "trees",
    ]
    .into_iter()
    .map(|name| Case {
        name: name.into(),
        scene: Scene::open(format!("{folder}/{name}.json")).expect("a scene"),
    })
    .collect()
}

/// The primary ray of a pixel, worked out once more for the tests.
pub fn primary_ray(frame: &Frame, x: u32, y: u32) -> Ray {
    let u = (x as f32 + frame.jitter_x) / frame.width as f32 * 2.0 - 1.0;
    let v = 1.0 - (y as f32 + frame.jitter_y) / frame.height as f32 * 2.0;
    let axis = Vec3::from;
    Ray {
        origin: axis(frame.eye),
        direction: (axis(frame.forward) + axis(frame.right) * u + axis(frame.up) * v).normalize(),
    }
}

/// What texels hold.
pub fn stored_integers(texels: &Texels) -> Vec<i32> {
    match texels.bits() {
        Bits::Eight => texels.bytes().iter().map(|&b| i32::from(b as i8)).collect(),
        Bits::Sixteen => {
            let (pairs, _) = texels.bytes().as_chunks::<2>();
            pairs
                .iter()
                .map(|&b| i32::from(i16::from_le_bytes(b)))
                .collect()
        }
    }
}

/// The lattice of a case's volume.
pub fn lattice(scene: &Scene, program: &Program, resolution: u32) -> Lattice {
    let frame = scene
        .view
        .frame
        .map(|[min, max]| Aabb::new(min.into(), max.into()));
    Lattice::holding(program.aabb(), frame, resolution).expect("a lattice")
}

/// Everything above.
pub fn all_cases() -> Vec<Case> {
    [
        shape_cases(),
        operator_cases(),
        modifier_cases(),
        structure_cases(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// One scene with every opcode, for a GPU field that is compiled once and then runs any case.
pub fn universal() -> Scene {
    let mut scene = Scene::new();
    for case in all_cases() {
        for &child in case.scene.node(Scene::ROOT).children() {
            copy(&case.scene, child, &mut scene, Scene::ROOT);
        }
    }
    scene
}

fn copy(from: &Scene, id: NodeId, to: &mut Scene, group: NodeId) {
    let mut entry = from.node(id).entry().clone();
    entry.material = None;
    let copied = push(to, group, entry);
    for &child in from.node(id).children() {
        copy(from, child, to, copied);
    }
}

/// Points in and around the cases, those on their planes of symmetry, and values that break arithmetic.
pub fn points(count: usize, seed: u64) -> Vec<[f32; 3]> {
    let mut numbers = Numbers::new(seed);
    let mut all: Vec<[f32; 3]> = (0..count)
        .map(|i| numbers.point(if i % 8 == 0 { 6.0 } else { 1.2 }).to_array())
        .collect();
    // Values on which the code's own thresholds lie.
    let marks = [
        0.0,
        -0.0,
        0.5,
        -0.5,
        0.35,
        0.6,
        0.7,
        1e-7,
        f32::MIN_POSITIVE,
        f32::from_bits(1),
    ];
    for (i, &x) in marks.iter().enumerate() {
        for (j, &y) in marks.iter().enumerate() {
            all.push([x, y, marks[(i + 3 * j) % marks.len()]]);
        }
    }
    all
}

/// Points that are not in the world.
pub fn poison() -> Vec<[f32; 3]> {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e8, -3e38];
    bad.into_iter()
        .flat_map(|v| [[v, 0.0, 0.0], [0.0, v, 0.1], [0.2, 0.0, v], [v, v, v]])
        .collect()
}

/// Waiting for what a device does, in place.
pub trait Wait: Future + Sized {
    /// What comes of it.
    fn wait(self) -> Self::Output {
        pollster::block_on(self)
    }
}

impl<F: Future> Wait for F {}

/// The GPU that tests run on. There is always one: `cargo xtask test` installs a software device where it can.
pub fn gpu() -> Arc<Gpu> {
    Arc::new(
        Gpu::open()
            .wait()
            .expect("a GPU, or Mesa's lavapipe: `cargo xtask test` says how to get it"),
    )
}

/// A field on the GPU that can run every case.
pub fn gpu_field() -> GpuField {
    let program = Program::lower(&universal()).expect("every case can be lowered");
    GpuField::new(gpu(), &program, false).expect("every case fits the GPU")
}

/// What rounding may add to a distance at a point of a case: 96 units in the last place of the greatest length that
/// enters. A distance here takes no more than 40 roundings of values of that size, curves' Newton steps included, whose
/// errors shrink quadratically; twice that for both sides.
pub fn rounding(point: [f32; 3]) -> f32 {
    let length = Vec3::from(point).length() + 2.0;
    96.0 * f32::EPSILON * length
}
