//! Warnings about work that will take long.

use argil::Representation;
use argil::field::Program;
use std::path::Path;

/// Number of brushes above which an image or a volume takes seconds.
const MANY_BRUSHES: usize = 200_000;

/// Number of copies per point above which evaluation is slow.
const MANY_COPIES: u64 = 64;

/// Warns about properties of a scene that make a representation slow.
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
            Representation::Field => ". Bricks render faster once they are baked (--via bricks)",
            _ => "",
        };
        all.push(format!(
            "this will be slow: the scene has {brushes} brushes{remedy}"
        ));
    }
    let copies = program.max_copies();
    if copies > MANY_COPIES {
        all.push(format!(
            "this will be slow: each point evaluates {copies} copies of a brush. Increase the spacing, or nest fewer repeats"
        ));
    }
    all
}
