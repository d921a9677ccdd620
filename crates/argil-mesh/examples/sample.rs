//! How long a mesh file takes to be read, repaired and sampled: `sample FILE RESOLUTION`.
fn main() {
    let mut args = std::env::args().skip(1);
    let path = args.next().expect("a file");
    let resolution = args.next().and_then(|n| n.parse().ok()).unwrap_or(128);
    let start = std::time::Instant::now();
    let mesh = argil_mesh::read(path.as_ref()).expect("a mesh").mesh;
    let read = start.elapsed();
    let solid = argil_mesh::MeshSdf::new(&mesh).expect("a solid");
    let built = start.elapsed();
    let grid = solid.sample(resolution).expect("an inside");
    println!(
        "{} triangles: read {read:.1?}, tree {:.1?}, sampled {:.1?}; {grid:?}, {} fine cells, Lipschitz {:.3}, {:?}",
        solid.triangles(),
        built - read,
        start.elapsed() - built,
        grid.fine_cells(),
        grid.lipschitz(),
        solid.repairs()
    );
}
