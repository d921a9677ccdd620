//! Asks a world what rays, spheres, points and boxes meet: `cargo run --release -p argil --example query`.

use argil::{BoxPosition, prelude::*};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    scene.push(Shape::cuboid([4.0, 0.1, 4.0]).with_name("floor"))?;
    scene.push(Shape::cylinder(0.5, 1.0).at([0.0, 1.0, 0.0]).smooth(0.2))?;
    let world = Engine::cpu().build(&scene)?.bricks(128)?;
    let query = world.query();

    // A shot: origin, direction, maximum distance.
    let hit = query
        .cast_ray([0.0, 1.0, 5.0], [0.0, 0.0, -1.0], 100.0)
        .ok_or("no hit")?;
    println!(
        "the ray hits {:?} after {:.3}, normal {:?}",
        hit.point, hit.distance, hit.normal
    );

    // A character of radius 0.3 that walks toward the pillar.
    let hit = query
        .cast_sphere([3.0, 0.5, 0.0], [-1.0, 0.0, 0.0], 0.3, 10.0)
        .ok_or("no hit")?;
    println!("the character stops after {:.3}", hit.distance);

    // The nearest point of the surface, at most 10 away.
    let nearest = query
        .closest_point([2.0, 2.0, 0.0], 10.0)
        .ok_or("no surface")?;
    println!(
        "the nearest point is {:?}, {:.3} away",
        nearest.point, nearest.distance
    );

    // A trigger volume.
    let position = query.classify_box([-0.2, 0.5, -0.2], [0.2, 0.8, 0.2], 0.01);
    assert_eq!(position, BoxPosition::Inside);

    world.render_view([640, 480])?.save("query.png")?;
    Ok(())
}
