//! Digs for hours: what is older than the newest carves becomes samples, so that an edit costs no more than early on.
//! `cargo run --release -p argil --example dig`

use argil::bake_history;
use argil::math::Control;
use argil::prelude::*;
use std::thread::JoinHandle;

/// Brushes that stay, to be undone, and how many may be there.
const NEWEST: usize = 16;
const MOST: usize = 160;
const RESOLUTION: u32 = 192;

/// Numbers from -1 to 1 that look random.
fn random(n: u32, axis: u32) -> f32 {
    let hash = (n * 4 + axis).wrapping_mul(0x9e37_79b9);
    let hash = (hash ^ (hash >> 15)).wrapping_mul(0x85eb_ca6b);
    (hash >> 8) as f32 / (1 << 23) as f32 - 1.0
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    let material = |base_color| Material {
        base_color,
        ..Material::default()
    };
    scene.set_material("rock", material([0.3, 0.26, 0.22]))?;
    scene.set_material("grass", material([0.2, 0.4, 0.1]))?;
    scene.push(Brush::new(Shape::cuboid([1.4, 0.5, 1.4])).with_material("rock"))?;
    let turf = Brush::new(Shape::cuboid([1.5, 0.08, 1.5])).at([0.0, 0.5, 0.0]);
    scene.push(turf.paint().with_material("grass"))?;
    let mut world = Engine::cpu().build(&scene)?.bricks(RESOLUTION)?;
    let mut bake: Option<JoinHandle<Result<argil::scene::HistoryBake, _>>> = None;
    for n in 0..400 {
        let height = 0.35 + 0.35 * random(n, 1);
        let place = [1.3 * random(n, 0), height, 1.3 * random(n, 2)];
        let ball = Brush::new(Shape::sphere(0.1 + 0.05 * random(n, 3))).smooth(0.03);
        scene.push(ball.at(place).subtract())?;
        let report = world.apply_within(&scene, EditBudget::new(2.0).near(place))?;
        let entries = scene.node(Scene::ROOT).children().len();
        if n % 50 == 49 {
            println!("carve {n}: {entries} entries, {:.1} ms", report.duration_ms);
        }
        // A game goes on while another thread takes the samples, and folds them when it has them.
        if let Some(done) = bake.take_if(|bake| bake.is_finished() || entries > 2 * MOST) {
            scene.fold_history(&done.join().map_err(|_| "the bake failed")??)?;
        }
        if bake.is_none() && scene.node(Scene::ROOT).children().len() > MOST {
            let samples = world.sample_lattice().ok_or("no samples")?;
            let snapshot = scene.snapshot();
            let count = snapshot.node(Scene::ROOT).children().len() - NEWEST;
            let work = move || bake_history(&snapshot, count, samples, &Control::default());
            bake = Some(std::thread::spawn(work));
        }
    }
    world.flush()?;
    world.render_view([640, 360])?.save("dig.png")?;
    Ok(())
}
