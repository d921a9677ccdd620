//! Motion of brushes in frames of a host.

use crate::host_common::{CLEAR, Host, half, odd_view, point_at, representations, target};
use argil::Representation;
use argil::gpu::{HostFrame, HostTargets, wgpu};
use argil::prelude::*;
use argil::render::Projection;
use argil::scene::{Edit, Group, Material, Modifier, NodeId, OperatorKind};
use glam::{Affine3A, Mat4, Quat, Vec2, Vec3};

type Outcome = Result<(), Box<dyn std::error::Error>>;

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg16Float;
/// Nearer than this, a point belongs to a brush. Farther than this, it does not.
const NEAR: [f32; 2] = [0.02, 0.06];

/// A solid that edits move, and how far each edit moves it.
struct Mover {
    node: NodeId,
    by: Modifier,
    map: Affine3A,
}

/// A host with a target for motion.
struct Rig {
    host: Host,
    motion: wgpu::Texture,
}

impl Rig {
    fn new() -> Result<Self, Box<dyn std::error::Error>> {
        let host = Host::new([96, 72])?;
        let motion = target(&host.device, host.size, FORMAT);
        Ok(Self { host, motion })
    }

    fn targets() -> HostTargets {
        HostTargets {
            motion: Some(FORMAT),
            ..Host::targets()
        }
    }

    /// Draws a frame, and returns the point and the motion of each pixel that shows the world.
    fn draw(
        &self,
        world: &World,
        frame: &mut HostFrame,
        view: Mat4,
    ) -> Result<Vec<(Vec3, Vec2)>, Box<dyn std::error::Error>> {
        let host = &self.host;
        let mut encoder = host.device.create_command_encoder(&Default::default());
        host.encode(world, frame, (view, RenderMode::Normal), &mut encoder)?;
        host.pass_with(&[&host.color, &self.motion], frame, 0.0, &mut encoder);
        host.queue.submit([encoder.finish()]);
        let motion = host.pixels(&self.motion)?;
        let all = host.pixels(&host.color)?.into_iter().zip(host.depths()?);
        let all = all.zip(motion).enumerate();
        Ok(all
            .filter(|(_, ((color, _), _))| color[..3] != CLEAR)
            .map(|(i, ((_, depth), motion))| {
                let point = point_at(view, host.size, i, depth.into());
                let [x, y] = [[motion[0], motion[1]], [motion[2], motion[3]]];
                let way = [x, y].map(|bytes| half(u16::from_le_bytes(bytes)));
                (point.as_vec3(), Vec2::from(way))
            })
            .collect())
    }
}

/// How far a point went in the image, if it was elsewhere in the world and in the view before.
fn motion_of(point: Vec3, view: Mat4, place: Vec3, before: Mat4) -> Vec2 {
    let [now, before] = [(view, point), (before, place)]
        .map(|(projection, at)| projection.project_point3(at).truncate());
    (now - before) * Vec2::new(0.5, -0.5)
}

/// A floor with paint, and what moves on it: a ball, a group that turns, a repeated post, and a bite into the floor.
fn scene() -> Result<(Scene, Vec<Mover>), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    let red = Material {
        base_color: [0.9, 0.1, 0.1],
        ..Material::default()
    };
    scene.set_material("red", red)?;
    scene.push(Brush::new(Shape::cuboid([1.4, 0.2, 1.4])).at([0.0, -0.6, 0.0]))?;
    let stain = Brush::new(Shape::sphere(0.5)).with_material("red").paint();
    let stain = scene.push(stain.at([0.8, -0.4, 0.7]))?.node;
    let bite = Brush::new(Shape::sphere(0.25)).at([0.9, -0.4, -0.3]);
    let bite = scene.push(bite.subtract())?.node;
    let ball = scene.push(Shape::sphere(0.3).at([-0.7, 0.1, 0.4]))?.node;
    let pair = Group::new().rotated([0.0, 1.0, 0.0], 20.0).smooth(0.01);
    let pair = scene.push_into(Scene::ROOT, pair)?.node;
    scene.push_into(pair, Shape::cuboid([0.3, 0.1, 0.1]).at([0.3, 0.2, 0.1]))?;
    scene.push_into(pair, Shape::torus(0.15, 0.05).at([0.1, 0.6, -0.3]))?;
    let post = Brush::new(Shape::cylinder(0.06, 0.2)).with_modifier(Modifier::Repeat {
        spacing: [0.0, 0.0, 0.3],
        count: Some([1, 1, 3]),
    });
    let post = scene.push(post.at([-0.2, -0.2, 0.9]))?.node;
    let shift = |node, by: [f32; 3]| Mover {
        node,
        by: Modifier::Translate { by },
        map: Affine3A::from_translation(by.into()),
    };
    let turn = Mover {
        node: pair,
        by: Modifier::Rotate {
            axis: [0.0, 1.0, 0.0],
            degrees: 8.0,
        },
        map: Affine3A::from_quat(Quat::from_rotation_y(8_f32.to_radians())),
    };
    let moves = vec![
        shift(ball, [0.05, 0.03, -0.04]),
        turn,
        shift(post, [-0.05, 0.0, 0.02]),
        shift(stain, [-0.04, 0.0, 0.0]),
        shift(bite, [-0.03, 0.0, 0.04]),
    ];
    Ok((scene, moves))
}

/// Returns a scene with one node alone, as a solid.
fn alone(scene: &Scene, node: NodeId) -> Result<World, Box<dyn std::error::Error>> {
    let mut reduced = scene.snapshot();
    for &other in scene.node(Scene::ROOT).children() {
        if other != node {
            reduced.apply(Edit::Remove { node: other })?;
        }
    }
    let mut desc = reduced.node(node).desc().clone();
    desc.operator.kind = OperatorKind::Union;
    reduced.apply(Edit::Replace { node, desc })?;
    Ok(Engine::cpu().build(&reduced)?.field())
}

/// Points of brushes that edits moved have their motion, and others only the camera's: after one edit and after two, where the map of
/// each edit is known.
#[test]
fn brushes_that_edits_move_have_motion() -> Outcome {
    let rig = Rig::new()?;
    let (_, engine) = rig.host.engine()?;
    for representation in representations() {
        let follows = matches!(
            representation,
            Representation::Bricks(_) | Representation::Levels(_)
        );
        let (mut scene, moves) = scene()?;
        let mut world = engine.build(&scene)?.with_representation(representation)?;
        let mut frame = world.host_frame(&Rig::targets())?;
        let mut views = [odd_view(); 2];
        rig.draw(&world, &mut frame, views[0])?;
        for edits in [0_i32, 1, 2] {
            for _ in 0..edits {
                for step in &moves {
                    let (node, by) = (step.node, step.by.clone());
                    scene.apply(Edit::Transform { node, by })?;
                }
                world.apply(&scene)?;
            }
            views = [views[0] * Mat4::from_rotation_y(0.02), views[0]];
            refine(&mut world, views[0])?;
            let pixels = rig.draw(&world, &mut frame, views[0])?;
            let mut counts = vec![0; 1 + moves.len()];
            let floor = scene.node(Scene::ROOT).children()[0];
            let mut others = vec![(alone(&scene, floor)?, Affine3A::IDENTITY)];
            for step in &moves {
                let all = (0..edits).fold(Affine3A::IDENTITY, |all, _| step.map * all);
                others.push((alone(&scene, step.node)?, all.inverse()));
            }
            for (point, found) in pixels {
                // A page of levels that is too coarse ends rays before the surface.
                if world.distance(point.into()).abs() > NEAR[0] {
                    continue;
                }
                let gaps: Vec<f32> = others
                    .iter()
                    .map(|(other, _)| other.distance(point.into()).abs())
                    .collect();
                let owner = gaps.iter().position(|gap| *gap < NEAR[0]);
                // Where two are near, either may win. Paint is no surface.
                let is_clear = |owner: usize| {
                    let mut others = gaps.iter().enumerate();
                    others.all(|(index, gap)| index == owner || index == 4 || *gap > NEAR[1])
                };
                let Some(owner) = owner.filter(|&owner| is_clear(owner) && owner != 4) else {
                    continue;
                };
                counts[owner] += 1;
                let place = match follows {
                    true => others[owner].1.transform_point3(point),
                    false => point,
                };
                let expected = motion_of(point, views[0], place, views[1]);
                assert!(
                    found.distance(expected) < 2e-4,
                    "{}, {edits} edits: {owner} at {point} moved {found}, not {expected}: {gaps:?}",
                    representation.name()
                );
            }
            let seen = counts
                .iter()
                .enumerate()
                .all(|(index, count)| index == 4 || *count > 8);
            assert!(seen, "{representation:?}: {counts:?}");
        }
    }
    Ok(())
}

/// Bakes what a view of levels needs, which frames of a host do not ask for.
fn refine(world: &mut World, view: Mat4) -> Outcome {
    let camera = Projection::from_matrix(view.to_cols_array_2d(), true);
    let camera = camera.ok_or("no projection")?.camera();
    let settings = world.render_settings([200, 200], RenderMode::Normal);
    world.refine(&camera, &settings)?;
    Ok(())
}

/// A frame that waited for too long, one of another world, and one after the whole world was built again show the camera's motion
/// alone.
#[test]
fn motion_that_is_not_known_is_the_cameras() -> Outcome {
    let rig = Rig::new()?;
    let (_, engine) = rig.host.engine()?;
    let view = odd_view();
    let mut scene = Scene::new();
    let ball = scene.push(Shape::sphere(0.6))?.node;
    let mut world = engine.build(&scene)?.bricks(48)?;
    let mut frame = world.host_frame(&Rig::targets())?;
    let mut go = |world: &mut World, count: usize| -> Outcome {
        for _ in 0..count {
            let by = Modifier::Translate {
                by: [0.002, 0.0, 0.0],
            };
            scene.apply(Edit::Transform { node: ball, by })?;
            world.apply(&scene)?;
        }
        Ok(())
    };
    let mut seen = Vec::new();
    let mut look = |world: &World, frame: &mut HostFrame| -> Outcome {
        let all = rig.draw(world, frame, view)?;
        seen.push(all.iter().map(|(_, way)| way.length()).fold(0.0, f32::max));
        Ok(())
    };
    look(&world, &mut frame)?;
    go(&mut world, 1)?;
    look(&world, &mut frame)?;
    look(&world, &mut frame)?;
    go(&mut world, 100)?;
    look(&world, &mut frame)?;
    go(&mut world, 1)?;
    look(&world, &mut frame)?;
    // Another world, of another scene.
    let other = engine.build(&Scene::new())?.bricks(32)?;
    look(&other, &mut frame)?;
    go(&mut world, 1)?;
    look(&world, &mut frame)?;
    let is_moved: Vec<bool> = seen.iter().map(|way| *way > 1e-5).collect();
    assert_eq!(
        is_moved,
        [false, true, false, false, true, false, false],
        "{seen:?}"
    );
    Ok(())
}

/// Frames with motion create nothing after the first edits, and submit nothing.
#[test]
fn motion_creates_nothing_later() -> Outcome {
    let rig = Rig::new()?;
    let (gpu, engine) = rig.host.engine()?;
    let (mut scene, moves) = scene()?;
    let mut world = engine.build(&scene)?.bricks(64)?;
    let mut frame = world.host_frame(&Rig::targets())?;
    let mut last = Default::default();
    for _ in 0..6 {
        let step = &moves[0];
        scene.apply(Edit::Transform {
            node: step.node,
            by: step.by.clone(),
        })?;
        let before = gpu.counters();
        let mut encoder = rig.host.device.create_command_encoder(&Default::default());
        let report = world.encode_edits(&scene, &mut encoder)?;
        assert!(!report.rebuilt);
        let look = (odd_view(), RenderMode::Normal);
        rig.host.encode(&world, &mut frame, look, &mut encoder)?;
        last = gpu.counters().since(before);
        let targets = [&rig.host.color, &rig.motion];
        rig.host.pass_with(&targets, &frame, 0.0, &mut encoder);
        rig.host.queue.submit([encoder.finish()]);
        // A device that lags behind by many frames needs more memory.
        rig.host.device.poll(wgpu::PollType::wait_indefinitely())?;
    }
    assert_eq!(last, Default::default());
    Ok(())
}
