//! Why work will take long, said before it begins.

use argil::Representation;
use argil::field::Program;
use std::path::Path;

/// Of more brushes a picture or a volume takes seconds.
const MANY_BRUSHES: usize = 200_000;

/// Of more copies around a point, each point takes as long as in a scene of so many brushes in one place.
const MANY_COPIES: u64 = 64;

/// Warn of what makes a scene slow that is kept in some way.
pub(crate) fn warn(program: &Program, via: Representation, path: &Path) {
    for reason in reasons(program, via) {
        eprintln!("warning: {}: {reason}", path.display());
    }
}

fn reasons(program: &Program, via: Representation) -> Vec<String> {
    let mut all = Vec::new();
    let brushes = program.brush_count();
    if brushes > MANY_BRUSHES {
        let remedy = match via {
            Representation::Field => {
                "; a picture of bricks is drawn sooner, once they are baked (--via bricks)"
            }
            _ => "",
        };
        all.push(format!(
            "this takes long, as the scene has {brushes} brushes{remedy}"
        ));
    }
    let copies = program.max_copies();
    if copies > MANY_COPIES {
        all.push(format!(
            "this takes long, as {copies} copies of a brush are measured around each point: copies that overlap reach far, and \
             repeats within repeats multiply; a wider spacing needs fewer"
        ));
    }
    all
}
