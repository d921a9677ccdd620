//! Histories that are folded into samples: the same solid and the same materials at all samples, however often.

use argil::math::Control;
use argil::scene::{Brush, Edit, HistoryLimit, Material, Scene, Shape};
use argil::volume::SampleFormat;
use argil::{
    Backend, BakeHistoryError, BricksOptions, EditBudget, Engine, Representation, SampleLattice,
    bake_history,
};
use argil_abi::GpuMaterial;
use argil_conformance::RandomTables;
use argil_field::{Evaluator, Program};
use glam::{IVec3, UVec3, Vec3};

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// Half of the box of all scenes here.
const HALF: f32 = 1.5;

/// Iterates over samples within the bounds, in a random order that is always the same.
fn samples(voxel: f32, count: usize) -> impl Iterator<Item = Vec3> {
    let side = (HALF / voxel) as u32 * 2 - 1;
    (0..count as u32).map(move |index| {
        let random = index.wrapping_mul(0x9e37_79b9) >> 3;
        let place = [random, random / side, random / side / side].map(|c| (c % side) as i32);
        (IVec3::from(place) - side as i32 / 2).as_vec3() * voxel
    })
}

/// Returns a point's distance, and its color, roughness and metalness.
fn at(evaluator: &mut Evaluator<'_>, p: Vec3) -> (f32, [f32; 5]) {
    let (mut d, mut material) = ([0.0], [GpuMaterial::default()]);
    evaluator.materials(&[p.x], &[p.y], &[p.z], &mut d, &mut material);
    let [r, g, b, roughness] = material[0].base_roughness;
    (d[0], [r, g, b, roughness, material[0].emission_metallic[3]])
}

/// Gives most nodes of a scene one of ten materials.
fn color(scene: &mut Scene, random: &mut RandomTables) -> Outcome {
    let name = |index: usize| format!("material {index}");
    for index in 0..10 {
        let share = index as f32 / 9.0;
        let material = Material {
            base_color: [share, 1.0 - share, (3.0 * share).fract()],
            roughness: 0.3 + 0.5 * share,
            ..Material::default()
        };
        scene.set_material(name(index), material)?;
    }
    for node in scene.iter().collect::<Vec<_>>() {
        if node != Scene::ROOT && random.chance(0.7) {
            let mut desc = scene.node(node).desc().clone();
            desc.material = Some(name(random.pick(10)));
            scene.apply(Edit::Replace { node, desc })?;
        }
    }
    Ok(())
}

/// Of random scenes of the whole table, samples hold what the field says.
#[test]
fn samples_are_the_fields() -> Outcome {
    let voxel = HALF / 16.0;
    let (mut baked, mut compared, mut painted) = (0, 0, 0);
    for seed in 0..60 {
        let mut random = RandomTables::new(seed);
        let mut scene = random.scene(8);
        color(&mut scene, &mut random)?;
        scene.view.bounds = Some([[-HALF; 3], [HALF; 3]]);
        let count = 1 + random.pick(scene.node(Scene::ROOT).children().len());
        let oldest = scene.oldest_entries(count);
        let Ok(program) = Program::lower(&oldest) else {
            continue;
        };
        if program.max_iterations() > 100 {
            continue;
        }
        let bake = match bake_history(&scene, count, voxel, &Control::default()) {
            Ok(bake) => bake,
            Err(
                BakeHistoryError::Animated(_)
                | BakeHistoryError::Hidden(_)
                | BakeHistoryError::Samples(_),
            ) => continue,
            Err(error) => return Err(format!("seed {seed}: {error}").into()),
        };
        let mut folded = oldest.clone();
        folded.fold_history(&bake)?;
        // What is thinner than a voxel may be in no sample.
        if bake.brushes().is_empty() {
            continue;
        }
        baked += 1;
        painted += usize::from(bake.brushes().len() > 1);
        let after = Program::lower(&folded)?;
        // Outside of its box, a solid is at least as far as its box is.
        let first = folded.node(Scene::ROOT).children()[0];
        let shape = folded.node(first).desc().kind.file();
        let solid = shape.and_then(|(.., grid)| Some(grid.0.as_ref()?.solid()));
        let raised = |p: Vec3, d: f32| match solid.map(|solid| solid.distance(p)) {
            Some(beyond) if beyond > 0.0 => d.max(beyond),
            _ => d,
        };
        // Steeper distances are near the surface in cells that do not look like it.
        let is_exact = program.lipschitz() <= 2.0;
        let [mut old, mut new] = [Evaluator::new(&program), Evaluator::new(&after)];
        for p in samples(voxel, 4000) {
            let ((d, color), (sampled, sampled_color)) = (at(&mut old, p), at(&mut new, p));
            let is_near = d.abs() < voxel;
            if is_near && is_exact {
                let error = (raised(p, d) - sampled).abs();
                assert!(error < 1e-4 * voxel, "seed {seed}, {p}: {sampled}, not {d}");
                compared += 1;
            }
            if d < 0.0 && is_exact && !program.has_textures() {
                let apart = (0..5).map(|k| (color[k] - sampled_color[k]).abs());
                let apart = apart.fold(0.0, f32::max);
                assert!(
                    apart < 0.01,
                    "seed {seed}, {p}: {sampled_color:?}, not {color:?}"
                );
            }
        }
    }
    assert!(
        baked > 20 && compared > 2000 && painted > 3,
        "{baked} scenes, {compared} samples, {painted} with paint"
    );
    Ok(())
}

/// A slab of two materials.
fn arena() -> Result<Scene, argil::scene::EditError> {
    let mut scene = Scene::new();
    for (name, base_color) in [("grass", [0.2, 0.6, 0.1]), ("stone", [0.4, 0.4, 0.45])] {
        let material = Material {
            base_color,
            ..Material::default()
        };
        scene.set_material(name, material)?;
    }
    scene.push(Brush::new(Shape::cuboid([1.3, 0.5, 1.3])).with_material("stone"))?;
    let top = Brush::new(Shape::cuboid([1.4, 0.1, 1.4])).at([0.0, 0.45, 0.0]);
    scene.push(top.paint().with_material("grass"))?;
    scene.view.bounds = Some([[-HALF; 3], [HALF; 3]]);
    Ok(scene)
}

/// Returns the next step of a game: most carve, some fill.
fn step(random: &mut RandomTables, index: usize) -> Brush {
    let [x, y, z] = random.point(1.2);
    let ball = Brush::new(Shape::sphere(0.08 + 0.1 * random.point(1.0)[0].abs()));
    let ball = ball.at([x, 0.4 * y.abs(), z]);
    match index % 4 {
        0 => ball.smooth(0.05).with_material("grass"),
        1 => ball.subtract(),
        _ => ball.subtract().smooth(0.04),
    }
}

/// After many folds, the solid is that of all steps, and the scene is as small as after the first.
#[test]
fn a_thousand_steps_are_those_of_the_whole_history() -> Outcome {
    let voxel = HALF / 32.0;
    let (mut game, mut whole) = (arena()?, arena()?);
    game.set_history_limit(HistoryLimit {
        steps: 8,
        ..HistoryLimit::default()
    });
    let mut random = RandomTables::new(3);
    for index in 0..1000 {
        let step = step(&mut random, index);
        game.push(step.clone())?;
        whole.push(step)?;
        let entries = game.node(Scene::ROOT).children().len();
        if entries > 110 {
            let bake = bake_history(&game, entries - 10, voxel, &Control::default())?;
            assert!(bake.brushes().len() <= 2, "one for each material");
            game.fold_history(&bake)?;
            assert!(game.undo().is_some() && game.redo().is_some());
        }
    }
    assert!(game.brush_count() <= 112);
    let [game, whole] = [Program::lower(&game)?, Program::lower(&whole)?];
    let [mut game, mut whole] = [Evaluator::new(&game), Evaluator::new(&whole)];
    let (mut near, mut colors, mut worst) = (0, 0, 0.0f32);
    for p in samples(voxel, 20_000) {
        let ((d, color), (sampled, sampled_color)) = (at(&mut whole, p), at(&mut game, p));
        if d.abs() < voxel {
            worst = worst.max((d - sampled).abs() / voxel);
            near += 1;
            let apart = (0..5).map(|k| (color[k] - sampled_color[k]).abs());
            colors += usize::from(apart.fold(0.0, f32::max) > 0.05);
        }
    }
    assert!(
        near > 1000 && worst < 0.2,
        "{near} samples, off by {worst} voxels"
    );
    assert!(colors < near / 50, "{colors} of {near} have another color");
    Ok(())
}

/// However often an arena is carved, filled and folded, samples stay as many, and are accurate where brushes meet them.
#[test]
fn samples_do_not_grow_with_folds() -> Outcome {
    let voxel = HALF / 48.0;
    let mut scene = Scene::new();
    scene.push(Shape::cuboid([1.4, 0.5, 1.4]))?;
    let mut random = RandomTables::new(29);
    let mut words = Vec::new();
    let mut solid = Vec3::ZERO;
    for fold in 0..24 {
        for index in 0..50 {
            let [x, y, z] = random.point(1.0);
            let ball = Brush::new(Shape::sphere(0.09)).at([1.3 * x, 0.5 * y, 1.3 * z]);
            let ball = ball.smooth(0.03);
            scene.push(if index % 2 == 0 {
                ball.subtract()
            } else {
                ball
            })?;
        }
        let before = Program::lower(&scene)?;
        let bake = bake_history(&scene, usize::MAX, voxel, &Control::default())?;
        scene.fold_history(&bake)?;
        words.push(words_of(&scene));
        solid = Program::lower(&scene)?.aabb().size();
        if fold % 8 == 7 {
            are_accurate_far_away(&before, &Program::lower(&scene)?, voxel);
        }
    }
    let first = words[3..7].iter().sum::<usize>() as f32;
    let last = words[20..].iter().sum::<usize>() as f32;
    assert!(last < 1.15 * first, "{words:?}");
    // A brush at the side reaches 0.09 out of it, and the smooth seam 0.03.
    let most = 2.0 * (Vec3::new(1.4, 0.5, 1.4) + 0.12);
    assert!(solid.cmple(most).all(), "{solid}");
    Ok(())
}

/// Returns the number of a scene's words of samples.
fn words_of(scene: &Scene) -> usize {
    let files = scene.iter().filter_map(|node| {
        let (.., grid) = scene.node(node).desc().kind.file()?;
        Some(grid.0.as_ref()?.words().len())
    });
    files.sum()
}

/// Asserts that interpolated distances are off by less than 0.6 voxels, or by less than 6 % of them.
fn are_accurate_far_away(field: &Program, sampled: &Program, voxel: f32) {
    let [mut field, mut sampled] = [Evaluator::new(field), Evaluator::new(sampled)];
    // Between samples, too.
    for p in samples(0.37 * voxel, 20_000) {
        let [(d, _), (of_samples, _)] = [at(&mut field, p), at(&mut sampled, p)];
        let tolerance = (0.6 * voxel).max(0.06 * d.abs());
        assert!(
            (d - of_samples).abs() < tolerance,
            "{p}: {of_samples}, not {d}"
        );
    }
}

/// A world on either device follows within its budget, and is then as if it were built from what was folded.
#[test]
fn worlds_follow_a_fold() -> Outcome {
    let on_gpu = Engine::with_backend(Backend::Gpu)?;
    for (engine, resolution) in [(Engine::cpu(), 64), (on_gpu, 32)] {
        let mut scene = arena()?;
        let via = BricksOptions::from(resolution);
        let mut world = engine.build(&scene)?.with_representation(via)?;
        let mut random = RandomTables::new(5);
        for index in 0..60 {
            scene.push(step(&mut random, index))?;
        }
        // The world does not see some of them before they are gone.
        let bake = bake_history(&scene.snapshot(), 50, HALF / 32.0, &Control::default())?;
        scene.push(step(&mut random, 60))?;
        scene.fold_history(&bake)?;
        let start = std::time::Instant::now();
        while world
            .apply_within(&scene, EditBudget::new(1.0))?
            .remaining_blocks
            > 0
        {
            assert!(start.elapsed().as_secs() < 120);
        }
        scene.push(step(&mut random, 61))?;
        world.apply(&scene)?;
        assert_eq!(world.diff_from_rebuild()?, Some(0));
    }
    Ok(())
}

/// Samples where the world has its own are the field's, and edits among them those of a bake.
#[test]
fn edits_among_samples_are_those_of_a_bake() -> Outcome {
    for (brick_size_voxels, format) in [
        (8, SampleFormat::Snorm16),
        (4, SampleFormat::Snorm8),
        (16, SampleFormat::Snorm16),
    ] {
        let mut scene = arena()?;
        let mut via = BricksOptions::from(56);
        via.settings.brick_size_voxels = brick_size_voxels;
        via.settings.encoding.format = format;
        let mut world = Engine::cpu().build(&scene)?.with_representation(via)?;
        let mut random = RandomTables::new(17);
        for index in 0..120 {
            // One to three brushes at once, hard and smooth.
            for one in 0..1 + index % 3 {
                scene.push(step(&mut random, index + one))?;
            }
            if index % 40 == 20 {
                world.apply(&scene)?;
                let lattice = world.sample_lattice().ok_or("samples")?;
                let bake = bake_history(&scene, 30, lattice, &Control::default())?;
                let before = Program::lower(&scene)?;
                scene.fold_history(&bake)?;
                have_same_samples(&before, &Program::lower(&scene)?, lattice);
            }
            world.apply(&scene)?;
            if index % 10 == 9 {
                let differing = world.diff_from_rebuild()?;
                assert_eq!(differing, Some(0), "{brick_size_voxels}, {index}");
            }
        }
    }
    Ok(())
}

/// Asserts that two programs have the same distances near the surface, at places of a lattice of 56 voxels.
fn have_same_samples(before: &Program, after: &Program, lattice: SampleLattice) {
    let [mut before, mut after] = [Evaluator::new(before), Evaluator::new(after)];
    let mut near = 0;
    for index in 0..56 * 56 * 28u32 {
        let place = UVec3::new(index % 56, index / 56 % 28, index / 56 / 28);
        let p = lattice.origin + lattice.voxel_size * place.as_vec3();
        let [(d, _), (sampled, _)] = [at(&mut before, p), at(&mut after, p)];
        if d.abs() < lattice.voxel_size {
            assert!((d - sampled).abs() < 1e-6, "{p}: {sampled}, not {d}");
            near += 1;
        }
    }
    assert!(near > 1000, "{near} places");
}

/// Of each representation with samples, the lattice is where these are.
#[test]
fn lattices_are_where_samples_are() -> Outcome {
    let mut scene = Scene::new();
    scene.push(Shape::sphere(1.0))?;
    let mut measured = Vec::new();
    for via in Representation::all(32) {
        let name = via.name();
        let world = Engine::cpu().build(&scene)?.with_representation(via)?;
        let Some(lattice) = world.sample_lattice() else {
            assert!(["field", "mesh"].contains(&name), "{name}");
            continue;
        };
        // An octree has no queries, and levels answer from coarse ones, too.
        let Some(volume) = world.query_volume().filter(|_| name != "levels") else {
            continue;
        };
        measured.push(name);
        let mut errors = [0.0f32; 2];
        for index in 0..200u32 {
            let place = UVec3::new(9 + index % 7, 10 + index / 7 % 6, index % 5).as_vec3();
            for (error, off) in errors.iter_mut().zip([0.0, 0.5]) {
                let p = lattice.origin + lattice.voxel_size * (place + off);
                let stored = volume.distance(p.to_array());
                if stored.abs() < lattice.voxel_size {
                    *error = error.max((stored - (p.length() - 1.0)).abs());
                }
            }
        }
        // Between samples, interpolation adds to the error of codes.
        assert!(errors[1] > 1.5 * errors[0], "{name}: {errors:?}");
    }
    Ok(())
}

#[test]
fn what_samples_cannot_hold_is_refused() -> Outcome {
    let control = Control::default();
    let mut scene = arena()?;
    scene.push(Brush::new(Shape::sphere(0.2)).hidden())?;
    let error = |scene: &Scene, count, voxel| {
        let error = bake_history(scene, count, voxel, &control).expect_err("a refusal");
        error.to_string()
    };
    assert!(error(&scene, 3, 0.1).starts_with("brushes[2] is hidden"));
    assert!(bake_history(&scene, 2, 0.1, &control).is_ok());
    for voxel in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(error(&scene, 2, voxel).contains("above 0"), "{voxel}");
    }
    assert!(error(&scene, 2, 1e-5).contains("at least"));
    for far in [f32::NAN, f32::INFINITY, -1e9] {
        for axis in 0..3 {
            let mut lattice = SampleLattice::from(0.1);
            lattice.origin[axis] = far;
            let error = bake_history(&scene, 2, lattice, &control).expect_err("a refusal");
            assert!(error.to_string().contains("finite place"), "{error}");
        }
    }
    let mut endless = Scene::new();
    endless.push(Shape::Plane {
        normal: [0.0, 1.0, 0.0],
        offset: 0.0,
    })?;
    assert!(error(&endless, 1, 0.1).contains("infinite"));
    endless.view.bounds = Some([[-1.0; 3], [1.0; 3]]);
    let bake = bake_history(&endless, 1, 1.0 / 64.0, &control)?;
    endless.fold_history(&bake)?;
    let cut = Program::lower(&endless)?;
    assert!(cut.lipschitz() < 2.0, "{}", cut.lipschitz());
    for (p, d) in [
        ([0.0, 0.25, 0.0], 0.25),
        ([0.0, -0.75, 0.0], -0.25),
        ([1.5, -0.5, 0.0], 0.5),
    ] {
        assert!((cut.distance(p.into()) - d).abs() < 0.01, "{p:?}");
    }
    // What is finite is not cut.
    let mut wide = arena()?;
    wide.view.bounds = Some([[-0.5; 3], [0.5; 3]]);
    wide.fold_history(&bake_history(&wide, 2, 1.0 / 16.0, &control)?)?;
    assert!(Program::lower(&wide)?.distance([1.25, 0.0, 1.25].into()) < 0.0);
    let mut none = Scene::new();
    none.push(Shape::sphere(0.5))?;
    none.push(Brush::new(Shape::sphere(1.0)).subtract())?;
    let bake = bake_history(&none, 2, 0.1, &control)?;
    assert!(bake.brushes().is_empty(), "nothing is left of it");
    none.fold_history(&bake)?;
    assert_eq!(none.brush_count(), 0);
    let cancelled = Control::new();
    cancelled.cancel();
    let refused = bake_history(&scene, 2, 0.1, &cancelled);
    assert!(matches!(refused, Err(BakeHistoryError::Cancelled)));
    Ok(())
}
