//! Folds of a scene's history: what can be undone, what is refused, and what a journal restores.

use argil_scene::{
    Brush, Edit, FoldError, HistoryBake, Journal, JournalError, Modifier, NodeId, SampledGrid,
    Scene, Shape,
};

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn ball(radius: f32) -> Brush {
    Brush::new(Shape::sphere(radius))
}

/// Returns a brush of samples.
fn sampled(name: &str, radius: f32) -> Brush {
    let distance = move |[x, y, z]: [f32; 3]| (x * x + y * y + z * z).sqrt() - radius;
    let grid = SampledGrid::from_fn([[-radius; 3], [radius; 3]], 16, distance);
    Brush::new(Shape::sampled(name, grid.expect("a ball")))
}

/// Returns a scene of balls, their ids, and a bake of the first `count`.
fn balls(total: usize, count: usize) -> (Scene, Vec<NodeId>, HistoryBake) {
    let mut scene = Scene::new();
    let ids = (0..total)
        .map(|index| scene.push(ball(0.1 + index as f32)).expect("a ball").node)
        .collect();
    let bake = HistoryBake::new(scene.oldest_entries(count), vec![sampled("old", 1.0)]);
    (scene, ids, bake)
}

#[test]
fn undo_ends_at_the_fold() -> Outcome {
    let (mut scene, ids, bake) = balls(6, 3);
    let by = Modifier::Scale { by: 2.0 };
    scene.apply(Edit::Transform { node: ids[4], by })?;
    let to_front = Edit::Move {
        node: ids[5],
        parent: Scene::ROOT,
        index: 3,
    };
    scene.apply(to_front)?;
    let before = scene.clone();
    scene.fold_history(&bake)?;
    let entries = scene.node(Scene::ROOT).children().to_vec();
    assert_eq!(entries[1..], [ids[5], ids[3], ids[4]]);
    assert_eq!(
        scene.changes_since(before.change_count()).map(<[_]>::len),
        Some(1)
    );
    // The move, the scale and the three last balls, and no more.
    assert_eq!(scene.undo_depth(), 5);
    assert!(scene.undo().is_some());
    assert_eq!(scene.node(Scene::ROOT).children()[1..], ids[3..]);
    while scene.undo().is_some() {}
    assert_eq!(scene.node(Scene::ROOT).children(), [entries[0]]);
    while scene.redo().is_some() {}
    assert_eq!(scene.node(Scene::ROOT).children(), entries);
    assert!(scene.get(ids[0]).is_none(), "what was folded is gone");
    Ok(())
}

/// A step that touches what was folded ends undo, even if later entries have steps before it.
#[test]
fn steps_of_folded_entries_are_gone() -> Outcome {
    for edit in [
        |id| Edit::Transform {
            node: id,
            by: Modifier::Scale { by: 2.0 },
        },
        |id| Edit::SetVisible {
            node: id,
            visible: true,
        },
    ] {
        let (mut scene, ids, _) = balls(4, 2);
        scene.apply(edit(ids[1]))?;
        scene.push(ball(9.0))?;
        let bake = HistoryBake::new(scene.oldest_entries(2), vec![sampled("old", 1.0)]);
        scene.fold_history(&bake)?;
        assert_eq!(scene.undo_depth(), 1);
    }
    // An entry that was before them once cannot return there.
    let (mut scene, ids, _) = balls(4, 2);
    let index = 3;
    scene.apply(Edit::Move {
        node: ids[0],
        parent: Scene::ROOT,
        index,
    })?;
    let bake = HistoryBake::new(scene.oldest_entries(2), vec![sampled("old", 1.0)]);
    scene.fold_history(&bake)?;
    assert_eq!(scene.undo_depth(), 0);
    Ok(())
}

/// Changes a scene, given the ids of its balls.
type Change = fn(&mut Scene, &[NodeId]) -> Result<(), argil_scene::EditError>;

#[test]
fn what_changed_since_the_bake_is_not_folded() -> Outcome {
    let changes: [Change; 4] = [
        |scene, ids| {
            let by = Modifier::Scale { by: 2.0 };
            scene
                .apply(Edit::Transform { node: ids[1], by })
                .map(|_| ())
        },
        |scene, ids| scene.apply(Edit::Remove { node: ids[1] }).map(|_| ()),
        |scene, _| {
            let desc = ball(3.0).into();
            let edit = Edit::Insert {
                parent: Scene::ROOT,
                index: 0,
                desc,
            };
            scene.apply(edit).map(|_| ())
        },
        // The same name, and other samples.
        |scene, ids| {
            let desc = sampled("first", 0.7).into();
            scene
                .apply(Edit::Replace { node: ids[0], desc })
                .map(|_| ())
        },
    ];
    for change in changes {
        let (mut scene, ids, _) = balls(5, 3);
        let desc = sampled("first", 0.5).into();
        scene.apply(Edit::Replace { node: ids[0], desc })?;
        let bake = HistoryBake::new(scene.oldest_entries(3), vec![sampled("old", 1.0)]);
        change(&mut scene, &ids)?;
        let before = scene.clone();
        let refused = scene.fold_history(&bake);
        assert!(matches!(refused, Err(FoldError::Changed(_))), "{refused:?}");
        assert_eq!(scene, before);
        assert!(scene.undo().is_some(), "the history stays");
    }
    let (mut scene, _, bake) = balls(5, 3);
    scene.fold_history(&bake)?;
    assert!(scene.fold_history(&bake).is_err(), "a second time");
    Ok(())
}

/// A game folds whenever samples are ready, also while somebody draws.
#[test]
fn strokes_go_on_after_a_fold() -> Outcome {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("game.journal");
    let mut scene = Scene::new();
    let mut journal = Journal::create(&path, &scene)?;
    let insert = r#"{"edit":"insert","entry":{"shape":{"type":"sphere","radius":0.1}}}"#;
    for line in [insert, insert, r#"{"edit":"begin_stroke"}"#, insert] {
        journal.replay(&mut scene, line)?;
    }
    let bake = HistoryBake::new(scene.oldest_entries(2), vec![sampled("old", 1.0)]);
    journal.fold_history(&mut scene, &bake)?;
    for line in [insert, insert, r#"{"edit":"end_stroke"}"#, insert] {
        journal.replay(&mut scene, line)?;
    }
    let mut recovered = Journal::recover(&path)?.scene;
    for scene in [&mut scene, &mut recovered] {
        assert_eq!((scene.undo_depth(), scene.brush_count()), (2, 5));
        scene.undo();
        scene.undo();
        assert_eq!(
            scene.brush_count(),
            2,
            "the fold, and what was drawn before it"
        );
    }
    Ok(())
}

#[test]
fn a_journal_holds_what_was_folded() -> Outcome {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("game.journal");
    let mut scene = Scene::new();
    let mut journal = Journal::create(&path, &scene)?;
    let insert = |scene: &Scene, brush: Brush| Edit::Insert {
        parent: Scene::ROOT,
        index: scene.node(Scene::ROOT).children().len(),
        desc: brush.into(),
    };
    for step in 0..40 {
        let edit = insert(&scene, ball(0.1 + 0.01 * step as f32));
        journal.apply(&mut scene, edit)?;
    }
    let bytes = std::fs::metadata(&path)?.len();
    let bake = HistoryBake::new(scene.oldest_entries(30), vec![sampled("old", 1.0)]);
    journal.fold_history(&mut scene, &bake)?;
    // Its lines are gone, its samples are there.
    let samples = bake.brushes().len() as u64 * 400_000;
    assert!(std::fs::metadata(&path)?.len() < bytes + samples);
    assert_eq!(scene.undo_depth(), 0, "as a recovered scene has it");
    // Another one of the same name, and undo.
    for radius in [0.4, 0.5] {
        let edit = insert(&scene, sampled("later", radius));
        journal.apply(&mut scene, edit)?;
        if radius == 0.4 {
            journal.replay(&mut scene, r#"{"edit":"undo"}"#)?;
        }
    }
    let node = *scene
        .node(Scene::ROOT)
        .children()
        .last()
        .ok_or("an entry")?;
    let desc = sampled("later", 0.45).into();
    journal.apply(&mut scene, Edit::Replace { node, desc })?;
    let edit = insert(&scene, ball(0.7));
    journal.apply(&mut scene, edit)?;
    let recovered = Journal::recover(&path)?;
    assert_eq!((recovered.edits, recovered.torn_bytes), (5, 0));
    assert_eq!(recovered.scene, scene);
    let grids = |scene: &Scene| {
        let meshes = scene.loaded_meshes().into_iter();
        let grids = meshes.map(|(name, _, grid)| (name.to_owned(), grid.to_bytes()));
        grids.collect::<Vec<_>>()
    };
    assert_eq!(grids(&recovered.scene).len(), 2);
    assert!(
        grids(&recovered.scene) == grids(&scene),
        "samples to the bit"
    );
    // What changed is not folded, and the journal stays.
    let before = std::fs::read(&path)?;
    let refused = journal.fold_history(&mut scene, &bake);
    assert!(matches!(refused, Err(JournalError::Fold(_))), "{refused:?}");
    assert!(std::fs::read(&path)? == before);
    // Damaged samples are told from their end of the file.
    let text = String::from_utf8(before)?.replacen("\"samples\":\"", "\"samples\":\"!", 1);
    std::fs::write(&path, text)?;
    assert!(Journal::recover(&path).is_err());
    Ok(())
}
