//! How worlds are seen at first: grounds touch, and cameras show the whole surface.

use argil::prelude::*;

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// Solids whose known boxes are larger than their surfaces.
fn solids() -> Result<Vec<(&'static str, Scene)>, Box<dyn std::error::Error>> {
    let mut turned = Scene::new();
    let plank = Brush::new(Shape::cuboid([1.0, 0.05, 0.3])).rotated([0.3, 0.2, 1.0], 40.0);
    turned.push(plank)?;
    let mut carved = Scene::new();
    carved.push(Shape::sphere(1.0))?;
    carved.push(
        Brush::new(Shape::cuboid([2.0, 0.6, 2.0]))
            .at([0.0, -1.0, 0.0])
            .subtract(),
    )?;
    let mut ball = Scene::new();
    ball.push(Brush::new(Shape::sphere(0.3)).at([7.0, -2.0, 1.0]))?;
    let mut bent = Scene::new();
    let bar = Brush::new(Shape::cuboid([1.0, 0.1, 0.1])).with_modifier(Modifier::Bend {
        degrees_per_unit: 60.0,
    });
    bent.push(bar)?;
    let mut common = Scene::new();
    common.push(Brush::new(Shape::sphere(0.5)).at([-0.3, 0.0, 0.0]))?;
    common.push(
        Brush::new(Shape::sphere(0.5))
            .at([0.3, 0.1, 0.0])
            .intersect(),
    )?;
    let mut blended = Scene::new();
    for i in 0..6 {
        let place = [0.4 * i as f32, 0.1 * (i % 3) as f32, 0.0];
        blended.push(Brush::new(Shape::sphere(0.25)).at(place).smooth(0.3))?;
    }
    Ok(vec![
        ("turned", turned),
        ("carved", carved),
        ("ball", ball),
        ("bent", bent),
        ("common", common),
        ("blended", blended),
    ])
}

/// All shapes and all modifiers of the tables whose solids are finite, turned, and the scenes that come with Argil. A new row
/// takes part by being a row.
fn rows() -> Result<Vec<(String, Scene)>, Box<dyn std::error::Error>> {
    let mut all = Vec::new();
    let mut add = |name: String, brush: Brush| {
        let mut scene = Scene::new();
        let is_there = scene.push(brush.rotated([0.3, 0.5, 1.0], 35.0)).is_ok();
        let finite = |scene: &Scene| {
            let program = argil::field::Program::lower(scene);
            program
                .is_ok_and(|program| program.aabb().is_finite() && program.max_iterations() < 500)
        };
        if is_there && finite(&scene) {
            all.push((name, scene));
        }
    };
    for shape in Shape::examples() {
        if shape.file().is_none() {
            add(format!("{shape:?}"), Brush::new(shape));
        }
    }
    for modifier in Modifier::examples() {
        let bar = Brush::new(Shape::cuboid([0.4, 0.15, 0.2]));
        add(format!("{modifier:?}"), bar.with_modifier(modifier));
    }
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
    for name in ["brick", "csg20", "edgy-cube", "props", "temple", "trees"] {
        let mut scene = Scene::open(format!("{folder}/{name}.json"))?;
        scene.view = argil::scene::View::default();
        all.push((name.to_owned(), scene));
    }
    Ok(all)
}

/// Imported meshes: triangles of the first rows, as files that a user has.
fn imported() -> Result<Vec<(String, Scene)>, Box<dyn std::error::Error>> {
    let mut all = Vec::new();
    for (name, solid) in rows()?.into_iter().take(20) {
        let options = MeshOptions {
            resolution: 32,
            ..MeshOptions::default()
        };
        let mesh = Engine::cpu().build(&solid)?.field().mesh(&options)?.mesh;
        let mut file = String::new();
        for p in &mesh.positions {
            file += &format!("v {} {} {}\n", p.x, p.y, p.z);
        }
        for [a, b, c] in &mesh.triangles {
            file += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
        }
        let mut scene = Scene::new();
        let mut shape = Shape::from_file("own.obj");
        if let Some((_, resolution, _)) = shape.file_mut() {
            *resolution = 48;
        }
        scene.push(Brush::new(shape))?;
        argil::load_meshes_from_bytes(&mut scene, &[("own.obj".into(), file.into())])?;
        all.push((format!("imported {name}"), scene));
    }
    Ok(all)
}

/// Returns the height of the lowest vertex of a mesh, and its voxel.
fn lowest(scene: &Scene, resolution: u32) -> Result<[f32; 2], Box<dyn std::error::Error>> {
    let options = MeshOptions {
        resolution,
        ..MeshOptions::default()
    };
    let output = Engine::cpu().build(scene)?.field().mesh(&options)?;
    let heights = output.mesh.positions.iter().map(|p| p.y);
    let lowest = heights.reduce(f32::min).ok_or("no mesh")?;
    Ok([lowest, output.voxel_grid.voxel_size])
}

/// The ground is at the lowest vertex of a fine mesh, also after edits in place, from below and above.
#[test]
fn grounds_touch_what_stands_on_them() -> Outcome {
    for (name, scene) in solids()? {
        for representation in [Representation::Field, BricksOptions::from(64).into()] {
            let mut scene = scene.clone();
            let build = Engine::cpu().build(&scene)?;
            let mut world = build.with_representation(representation)?;
            let [before, _] = lowest(&scene, 128)?;
            let bite = Brush::new(Shape::cuboid([20.0, 1.0, 20.0])).at([0.0, before - 0.95, 0.0]);
            let ball = Brush::new(Shape::sphere(0.2)).at([0.0, before - 0.5, 0.0]);
            for edit in [None, Some(bite.subtract()), Some(ball)] {
                if let Some(brush) = edit {
                    scene.push(brush)?;
                    world.apply(&scene)?;
                }
                let [expected, voxel] = lowest(&scene, 128)?;
                let off = (world.ground_height() - expected) / voxel;
                assert!(off.abs() < 1.0, "{name}: {representation:?}: {off} voxels");
            }
            let mut view = Box::new(scene.view.clone());
            view.ground_height = Some(-3.5);
            scene.apply(Edit::SetView { view })?;
            world.apply(&scene)?;
            assert_eq!(world.ground_height(), -3.5);
        }
    }
    Ok(())
}

/// Between the ground and the lowest vertex of each row is less than a voxel.
#[test]
fn grounds_touch_all_rows() -> Outcome {
    let mut count = 0;
    for (name, scene) in rows()?.into_iter().chain(imported()?) {
        let [expected, voxel] = lowest(&scene, 64)?;
        let world = Engine::cpu().build(&scene)?.field();
        let off = (world.ground_height() - expected) / voxel;
        assert!(off.abs() < 1.0, "{name}: {off} voxels");
        count += 1;
    }
    assert!(count >= 60, "{count} rows");
    Ok(())
}

/// Where a view says neither where the camera is nor what it shows, the surface fills 60 to 80 % of the image's shorter side.
#[test]
fn surfaces_fill_the_image() -> Outcome {
    let [width, height] = [160, 120];
    let solids = solids()?.into_iter();
    let solids = solids.map(|(name, scene)| (name.to_owned(), scene));
    for (name, scene) in solids.chain(rows()?).chain(imported()?) {
        let world = Engine::cpu().build(&scene)?.field();
        let settings = world.render_settings([width, height], RenderMode::Normal);
        let lengths = world.ray_distances(&world.camera(), &settings)?;
        let hits = (0..lengths.len()).filter(|&i| lengths[i].is_finite());
        let places = hits.map(|i| [i % width as usize, i / width as usize]);
        let ends = places.fold([[usize::MAX, 0]; 2], |ends, place| {
            [0, 1].map(|k| [ends[k][0].min(place[k]), ends[k][1].max(place[k])])
        });
        let [across, high] = ends.map(|[low, high]| (high + 1 - low) as f64);
        let filled = across.max(high) / f64::from(height);
        assert!((0.6..=0.8).contains(&filled), "{name}: {filled}");
        let [columns, rows] = ends;
        assert!(columns[0] > 0 && columns[1] + 1 < width as usize, "{name}");
        assert!(rows[0] > 0 && rows[1] + 1 < height as usize, "{name}");
        // The middle of what is seen is in the middle.
        let middle = [columns, rows].map(|[low, high]| 0.5 * (low + high) as f64);
        let off = [middle[0] - 79.5, middle[1] - 59.5].map(f64::abs);
        assert!(off.into_iter().all(|off| off < 12.0), "{name}: {off:?}");
    }
    Ok(())
}
