//! Writes a seeded random scene to the standard output: `cargo run --release -p argil-conformance --example random_scene --
//! 10000 > random.json`.

fn main() {
    let brushes = std::env::args().nth(1).and_then(|n| n.parse().ok());
    let Some(brushes) = brushes else {
        eprintln!("usage: random_scene BRUSHES");
        std::process::exit(2);
    };
    println!("{}", argil_conformance::random_scene(brushes, 1).to_json());
}
