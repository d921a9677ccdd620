//! A valley with a river, forests, a village, caves and a temple.

use crate::world_parts::{Random, instances, lines_of, materials, translate};
use anyhow::Context;
use argil::prelude::*;
use serde_json::{Value, json};
use xtask::root;

/// Half of the valley's side, in meters.
const HALF: f32 = 2048.0;
/// The bed of the river, in x and z.
const RIVER: [[f32; 2]; 9] = [
    [-2100.0, -500.0],
    [-1500.0, -150.0],
    [-900.0, -260.0],
    [-350.0, 60.0],
    [150.0, -40.0],
    [650.0, 180.0],
    [1200.0, 20.0],
    [1700.0, 250.0],
    [2200.0, 100.0],
];
/// The water's level.
const WATER: f32 = -4.0;

fn capsule(a: [f32; 2], b: [f32; 2], y: f32, radius: f32, blend: f32) -> Value {
    json!({
        "operator": "subtract",
        "blend": blend,
        "shape": { "type": "capsule", "from": [a[0], y, a[1]], "to": [b[0], y, b[1]], "radius": radius },
    })
}

fn displace(amplitude: f32, frequency: f32, octaves: u32, seed: u32) -> Value {
    json!({ "type": "displace", "amplitude": amplitude, "frequency": frequency, "octaves": octaves, "seed": seed })
}

/// Returns a plateau of noise with the river's valley, cliffs that hang over, and caves.
fn land(random: &mut Random) -> Vec<Value> {
    let mut parts = vec![
        json!({ "name": "plateau", "shape": { "type": "plane", "normal": [0, 1, 0], "offset": 140 } }),
    ];
    for (y, radius, blend) in [(175.0, 190.0, 120.0), (9.0, 18.0, 30.0)] {
        let pairs = RIVER.windows(2);
        parts.extend(pairs.map(|pair| capsule(pair[0], pair[1], y, radius, blend)));
    }
    let mut all = vec![json!({
        "name": "land",
        "material": "grass",
        "modifiers": [displace(45.0, 0.0025, 2, 5), displace(0.5, 0.08, 2, 9)],
        "brushes": parts,
    })];
    // Rocks that stick out of the slopes, and caves below them.
    let (mut rocks, mut caves) = (Vec::new(), Vec::new());
    for pair in RIVER.windows(2) {
        for side in [-1.0, 1.0] {
            let share = random.next();
            let at =
                [0, 1].map(|axis: usize| pair[0][axis] + share * (pair[1][axis] - pair[0][axis]));
            let z = at[1] + side * random.within(185.0, 225.0);
            let y = random.within(60.0, 90.0);
            let inward = at[1] + side * 330.0;
            rocks.push(json!({
                "blend": 14,
                "shape": { "type": "ellipsoid", "radii": [random.within(30.0, 60.0), random.within(9.0, 16.0), random.within(30.0, 50.0)] },
                "modifiers": [displace(2.0, 0.08, 2, 31), translate([at[0], y, z])],
            }));
            caves.push(json!({
                "operator": "subtract",
                "blend": 4,
                "material": "rock",
                "shape": { "type": "round_cone", "bottom_radius": 13, "top_radius": 5, "height": 150 },
                "modifiers": [
                    { "type": "rotate", "axis": [1, 0, 0], "degrees": 80.0 * side },
                    displace(1.2, 0.1, 2, 17),
                    translate([at[0], y - 22.0, z.min(inward).max(-inward.abs())]),
                ],
            }));
        }
    }
    all.push(json!({ "name": "cliffs", "material": "rock", "blend": 12, "brushes": rocks }));
    all.extend(caves);
    all
}

/// Returns a tree of some brushes. The origin is where its trunk leaves the ground.
fn tree(kind: u32, random: &mut Random) -> Vec<Value> {
    let mut parts = vec![json!({
        "material": "bark",
        "shape": { "type": "round_cone", "bottom_radius": 0.28, "top_radius": 0.09, "height": 5 },
        "modifiers": [translate([0.0, -0.3, 0.0])],
    })];
    for i in 0..6u8 {
        let share = f32::from(i) / 5.0;
        let (shape, at) = if kind == 0 {
            let radius = 1.7 - 1.3 * share;
            let cone = json!({ "type": "round_cone", "bottom_radius": radius, "top_radius": 0.1, "height": 2 });
            (cone, [0.0, 1.6 + 5.0 * share, 0.0])
        } else {
            let radius = random.within(0.8, 1.3);
            let angle = 6.3 * random.next();
            let far = 1.1 * (1.0 - share);
            let at = [far * angle.cos(), 3.4 + 2.6 * share, far * angle.sin()];
            (json!({ "type": "sphere", "radius": radius }), at)
        };
        let material = if kind == 0 { "needles" } else { "leaf" };
        parts.push(json!({ "material": material, "blend": 0.25, "shape": shape, "modifiers": [translate(at)] }));
    }
    parts
}

/// Returns a house of stone with a tiled roof, a door and windows.
fn house() -> Vec<Value> {
    let window = |x: f32, z: f32| {
        json!({
            "operator": "subtract",
            "material": "bark",
            "shape": { "type": "box", "half_size": [0.5, 0.6, 0.3] },
            "modifiers": [translate([x, 2.2, z])],
        })
    };
    let mut parts = vec![
        json!({ "material": "plaster", "shape": { "type": "box", "half_size": [4, 3.5, 3] }, "modifiers": [translate([0.0, 1.5, 0.0])] }),
        json!({
            "material": "tile",
            "shape": { "type": "tri_prism", "half_side": 3.9, "half_depth": 4.4 },
            "modifiers": [{ "type": "rotate", "axis": [0, 1, 0], "degrees": 90 }, translate([0.0, 6.0, 0.0])],
        }),
        json!({ "material": "plaster", "shape": { "type": "box", "half_size": [0.4, 1.6, 0.4] }, "modifiers": [translate([2.2, 7.5, 0.8])] }),
        json!({ "operator": "subtract", "material": "bark", "shape": { "type": "box", "half_size": [0.6, 1.1, 0.3] }, "modifiers": [translate([0.0, 1.1, 3.0])] }),
    ];
    for x in [-2.4, 2.4] {
        parts.extend([window(x, 3.0), window(x, -3.0)]);
    }
    parts
}

/// Returns the poses of instances that stand on the ground: where the slope and the height suit.
fn scattered(
    ground: &World,
    random: &mut Random,
    (count, scales): (usize, &[f32]),
    mut place: impl FnMut(&mut Random) -> [f32; 2],
    suits: impl Fn([f32; 3], f32) -> bool,
) -> Vec<[f32; 5]> {
    let query = ground.query();
    let mut poses = Vec::with_capacity(count);
    for _ in 0..20 * count {
        if poses.len() == count {
            break;
        }
        let [x, z] = place(random);
        let (degrees, scale) = (random.within(0.0, 360.0), random.choice(scales));
        let Some(hit) = query.cast_ray([x, 380.0, z], [0.0, -1.0, 0.0], 600.0) else {
            continue;
        };
        if suits(hit.point, hit.normal[1]) {
            let round = |v: f32| (v * 100.0).round() / 100.0;
            poses.push([
                round(x),
                round(hit.point[1]),
                round(z),
                degrees.round(),
                scale,
            ]);
        }
    }
    poses
}

/// Returns the height of the ground at a place.
fn height(ground: &World, x: f32, z: f32) -> anyhow::Result<f32> {
    let hit = ground
        .query()
        .cast_ray([x, 380.0, z], [0.0, -1.0, 0.0], 600.0);
    Ok(hit.context("the ground")?.point[1])
}

/// Returns the cameras' paths: a walk of 90 s at walking speed, a flight at 30 m/s, and a fall from 20 km.
fn paths(ground: &World) -> anyhow::Result<Value> {
    let point = |time: f32, [x, z]: [f32; 2], up: f32, ahead: [f32; 3]| -> anyhow::Result<Value> {
        let y = height(ground, x, z)?.max(WATER) + up;
        let target = [x + ahead[0], y + ahead[1], z + ahead[2]];
        Ok(json!({ "time": time, "eye": [x, y, z], "target": target }))
    };
    let mut walk = Vec::new();
    for i in 0..10u8 {
        let t = f32::from(i);
        walk.push(point(
            10.0 * t,
            [200.0 + 10.0 * t, 48.0 + 1.5 * t],
            1.7,
            [30.0, -3.0, 6.0],
        )?);
    }
    let mut flight = Vec::new();
    let mut time = 0.0;
    for pair in RIVER.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let (dx, dz) = (b[0] - a[0], b[1] - a[1]);
        let length = dx.hypot(dz);
        flight.push(point(
            time,
            [a[0].max(-1990.0), a[1]],
            45.0,
            [dx / length * 100.0, -14.0, dz / length * 100.0],
        )?);
        time += length / 30.0;
    }
    let [x, z] = [230.0, 56.0];
    let floor = height(ground, x, z)?.max(WATER);
    let fall: Vec<Value> = [(0.0, 20_000.0), (4.0, 4000.0), (8.0, 600.0), (11.0, 60.0), (13.0, 1.7)]
        .into_iter()
        .map(|(time, up)| {
            let ahead = 0.2 * up + 4.0;
            json!({ "time": time, "eye": [x, floor + up, z], "target": [x + ahead, floor + 0.6 * up.min(3.0), z - 0.5 * ahead] })
        })
        .collect();
    Ok(json!({ "walk": walk, "flight": flight, "fall": fall }))
}

/// Returns the temple's brushes and materials. Its unit becomes 14 meters.
fn temple(ground: &World, materials: &mut Value) -> anyhow::Result<Value> {
    let text = std::fs::read_to_string(root().join("scenes/temple.json")).context("the temple")?;
    // Chamfers would make all distances of the world steeper.
    let text = text.replace("\"profile\": \"chamfer\"", "\"profile\": \"smooth\"");
    let parsed: Value = serde_json::from_str(&text).context("the temple")?;
    if let (Some(all), Some(parsed)) = (materials.as_object_mut(), parsed["materials"].as_object())
    {
        for (name, material) in parsed {
            all.entry(name.clone()).or_insert_with(|| material.clone());
        }
    }
    let [x, z] = [60.0, 70.0];
    let y = height(ground, x, z)? + 14.0;
    let modifiers = json!([{ "type": "scale", "by": 14 }, translate([x, y, z])]);
    Ok(json!({ "name": "temple", "brushes": parsed["brushes"], "modifiers": modifiers }))
}

pub(crate) fn valley() -> anyhow::Result<Value> {
    let mut random = Random(20_261_125);
    let bounds = [[-HALF, -120.0, -HALF], [HALF, 420.0, HALF]];
    let mut brushes = land(&mut random);
    let mut materials = materials();
    let bare = json!({ "argil": 1, "name": "land", "view": { "bounds": bounds }, "materials": materials, "brushes": brushes });
    let bare = Scene::from_json(&lines_of(&bare), "land")?;
    let ground = Engine::cpu().build(&bare)?.field();

    brushes.push(json!({
        "name": "river",
        "material": "water",
        "shape": { "type": "box", "half_size": [HALF + 60.0, 30, 1000] },
        "modifiers": [translate([0.0, WATER - 30.0, 0.0])],
    }));
    let anywhere =
        |random: &mut Random| [random.within(-2000.0, 2000.0), random.within(-900.0, 900.0)];
    let in_valley =
        |random: &mut Random| [random.within(-700.0, 700.0), random.within(-160.0, 260.0)];
    let village = |random: &mut Random| [random.within(190.0, 330.0), random.within(66.0, 125.0)];
    let near_path = |random: &mut Random| [random.within(195.0, 310.0), random.within(36.0, 66.0)];
    let is_dry = |[_, y, _]: [f32; 3], up: f32| y > WATER + 1.5 && up > 0.75;
    let is_level = |[_, y, _]: [f32; 3], up: f32| y > WATER + 2.5 && up > 0.9;
    for (kind, name, count) in [(0, "firs", 5000), (1, "oaks", 3000), (1, "birches", 2000)] {
        let parts = tree(kind, &mut random);
        let scales = [0.8, 1.0, 1.3, 1.7];
        let mut poses = scattered(&ground, &mut random, (count, &scales), anywhere, is_dry);
        poses.extend(scattered(
            &ground,
            &mut random,
            (count / 5, &scales),
            in_valley,
            is_dry,
        ));
        brushes.push(instances(name, parts, &poses));
    }
    let poses = scattered(&ground, &mut random, (40, &[0.9, 1.1]), village, is_level);
    brushes.push(instances("village", house(), &poses));
    brushes.push(temple(&ground, &mut materials)?);
    for (name, radii, count) in [
        ("pebbles", [0.05, 0.03, 0.04], 500),
        ("stones", [0.4, 0.25, 0.3], 150),
    ] {
        let stone = json!({
            "material": "rock",
            "shape": { "type": "ellipsoid", "radii": radii },
            "modifiers": [displace(0.2 * radii[1], 0.4 / radii[0], 1, 3)],
        });
        let poses = scattered(
            &ground,
            &mut random,
            (count, &[0.7, 1.0, 1.6]),
            near_path,
            is_dry,
        );
        brushes.push(instances(name, vec![stone], &poses));
    }
    let paths = paths(&ground)?;
    let start = paths["walk"][0].clone();
    Ok(json!({
        "argil": 1,
        "name": "valley",
        "view": {
            "camera": { "look_at": { "eye": start["eye"], "target": start["target"] } },
            "field_of_view_degrees": 60,
            "sun_degrees": [60, 42],
            "bounds": bounds,
            "paths": paths,
        },
        "materials": materials,
        "brushes": brushes,
    }))
}
