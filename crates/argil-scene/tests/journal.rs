//! Recovers a session from its journal after its process was killed at any moment.

use argil_scene::{
    Action, Brush, Edit, Group, Journal, JournalError, Modifier, NodeTree, Scene, Shape,
};
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// The environment variable that makes a process of this program write a journal until it is killed.
const VICTIM: &str = "ARGIL_TEST_JOURNAL";

fn beginning() -> Scene {
    let mut scene = Scene::new();
    scene.name = "two lines\nin a name".into();
    let ball = Brush::new(Shape::sphere(0.5));
    scene.push(ball).expect("a valid brush");
    // As it is read from a file: without a history.
    Scene::from_json(&scene.to_json(), "beginning").expect("a scene")
}

/// Returns line n of a session of insertions, transforms, strokes, undos and redos. It is always the same.
fn line(scene: &Scene, index: u64) -> String {
    let random = index.wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(23);
    let count = scene.node(Scene::ROOT).children().len();
    let node = random as usize % count.max(1);
    let [undos, redos] = [scene.undo_depth(), scene.redo_depth()];
    match random >> 32 & 15 {
        0..=4 => {
            let radius = 0.01 + (random % 97) as f32 * 1e-3;
            format!(
                r#"{{"edit":"insert","index":{node},"entry":{{"shape":{{"type":"sphere","radius":{radius}}}}}}}"#
            )
        }
        5..=8 if count > 0 => format!(
            r#"{{"edit":"transform","node":"brushes[{node}]","by":{{"type":"translate","by":[0.01,0,0]}}}}"#
        ),
        9 if count > 3 => format!(r#"{{"edit":"remove","node":"brushes[{node}]"}}"#),
        10 => r#"{"edit":"begin_stroke"}"#.into(),
        11 => r#"{"edit":"end_stroke"}"#.into(),
        12 | 13 if undos > 0 => r#"{"edit":"undo"}"#.into(),
        14 if redos > 0 => r#"{"edit":"redo"}"#.into(),
        _ => r#"{"edit":"insert","entry":{"shape":{"type":"sphere","radius":0.2}}}"#.into(),
    }
}

/// Not a test: the test below starts and kills this process.
#[test]
fn victim() {
    let Some(path) = std::env::var_os(VICTIM) else {
        return;
    };
    let path = Path::new(&path);
    let mut scene = beginning();
    let mut journal = Journal::create(path, &scene).expect("a journal");
    let mut out = std::io::stdout();
    for index in 0.. {
        let line = line(&scene, index);
        journal.replay(&mut scene, &line).expect("a valid edit");
        // Told only when it is recorded.
        writeln!(out, "recorded {}", index + 1).expect("a pipe");
        out.flush().expect("a pipe");
        if index % 16 == 15 {
            scene
                .save(path.with_extension("json"))
                .expect("a saved scene");
        }
    }
}

#[test]
fn killed_at_any_moment_all_but_the_edit_in_flight_comes_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("session.journal");
    let program = std::env::current_exe().expect("this program");
    let (mut most, mut torn, mut saved) = (0, 0, 0);
    for kill in 0..200u64 {
        let mut victim = Command::new(&program)
            .args(["--exact", "journal::victim", "--nocapture"])
            .env(VICTIM, &path)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("a process");
        // From before it has begun to many edits later.
        let micros = kill.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
        std::thread::sleep(Duration::from_micros(micros % 40_000));
        victim.kill().expect("it can be killed");
        let mut said = String::new();
        let mut out = victim.stdout.take().expect("a pipe");
        out.read_to_string(&mut said).expect("text");
        victim.wait().expect("it is gone");
        let whole = said.split_inclusive('\n').filter(|l| l.ends_with('\n'));
        let recorded = whole
            .filter_map(|l| l.trim().rsplit_once("recorded ")?.1.parse().ok())
            .max()
            .unwrap_or(0usize);

        // The scene's own file is whole, whenever it was saved.
        let scene_path = path.with_extension("json");
        if scene_path.exists() {
            Scene::open(&scene_path).expect("a whole scene");
            std::fs::remove_file(&scene_path).expect("removed");
            saved += 1;
        }
        if !path.exists() {
            assert_eq!(recorded, 0, "edits were recorded nowhere");
            continue;
        }
        let recovered = Journal::recover(&path).expect("a journal");
        assert!(
            (recorded..=recorded + 1).contains(&recovered.edits),
            "{recorded} edits were recorded, {} came back",
            recovered.edits
        );
        most = most.max(recovered.edits);
        torn += usize::from(recovered.torn_bytes > 0);
        let mut expected = beginning();
        for index in 0..recovered.edits as u64 {
            let line = line(&expected, index);
            expected.apply_log_line(&line).expect("a valid edit");
        }
        let mut scene = recovered.scene;
        assert!(scene == expected, "after {} edits", recovered.edits);
        // The history is there to its beginning.
        assert_eq!(
            [scene.undo_depth(), scene.redo_depth()],
            [expected.undo_depth(), expected.redo_depth()]
        );
        while scene.undo().is_some() {}
        assert!(scene == beginning());
        std::fs::remove_file(&path).expect("removed");
    }
    assert!(
        most > 50 && saved > 20,
        "the kills came too early: {most} {saved}"
    );
    println!("{most} edits at most, {torn} torn lines, {saved} saved scenes");
}

#[test]
fn a_truncated_journal_gives_all_complete_lines() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cut.journal");
    let mut scene = beginning();
    let mut states = vec![scene.clone()];
    let mut journal = Journal::create(&path, &scene).expect("a journal");
    let head = std::fs::metadata(&path).expect("a file").len() as usize;
    for index in 0..6 {
        let line = line(&scene, index);
        journal.replay(&mut scene, &line).expect("a valid edit");
        states.push(scene.clone());
    }
    let bytes = std::fs::read(&path).expect("a file");
    for length in 0..bytes.len() {
        std::fs::write(&path, &bytes[..length]).expect("written");
        match Journal::recover(&path) {
            Ok(recovered) => {
                assert!(length >= head);
                assert!(recovered.scene == states[recovered.edits], "{length}");
                // It goes on after the cut.
                let (mut scene, mut journal) = recovered.resume().expect("a journal");
                let node = scene.node(Scene::ROOT).children()[0];
                let by = Modifier::Scale { by: 2.0 };
                let edit = Edit::Transform { node, by };
                journal.apply(&mut scene, edit).expect("an edit");
                let again = Journal::recover(&path).expect("a journal");
                assert!(again.scene == scene && again.torn_bytes == 0);
            }
            Err(JournalError::Empty(_)) => assert_eq!(length, 0),
            Err(JournalError::NoJournal(_)) => assert!((1..head).contains(&length), "{length}"),
            Err(other) => panic!("{length}: {other}"),
        }
    }
    // Damage is told, and nothing is cut off; at the end it is a torn line.
    let last = bytes[..bytes.len() - 1].iter().rposition(|&b| b == b'\n');
    for at in (head..bytes.len()).step_by(7) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1;
        std::fs::write(&path, &damaged).expect("written");
        let recovered = match Journal::recover(&path) {
            Ok(recovered) => recovered,
            Err(JournalError::Damaged { .. }) => {
                assert!(Some(at) <= last);
                assert_eq!(std::fs::read(&path).expect("a file"), damaged);
                continue;
            }
            Err(other) => panic!("{at}: {other}"),
        };
        assert!(Some(at) > last, "{at}");
        assert!(
            recovered.scene == states[recovered.edits] && recovered.torn_bytes > 0,
            "{at}"
        );
    }
}

#[test]
fn refused_edits_are_not_recorded() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("refused.journal");
    let mut scene = beginning();
    let mut journal = Journal::create(&path, &scene).expect("a journal");
    let root = Edit::Remove { node: Scene::ROOT };
    assert!(matches!(
        journal.apply(&mut scene, root),
        Err(JournalError::Edit(_))
    ));
    for line in ["", "{", r#"{"edit":"redo"}"#] {
        let refused = journal.replay(&mut scene, line);
        assert!(matches!(refused, Err(JournalError::Replay(_))), "{line}");
    }
    assert_eq!(Journal::recover(&path).expect("a journal").edits, 0);
    journal.remove().expect("removed");
    scene.push(Brush::new(Shape::sphere(0.1))).expect("an edit");
    let late = Journal::create(&path, &scene);
    assert!(matches!(late, Err(JournalError::HistoryNotEmpty(1))));
    assert!(matches!(
        Journal::recover(&path),
        Err(JournalError::Io { .. })
    ));
}

/// Whatever can be inserted is recorded so that it can be read again, and does not take what was recorded before it along.
#[test]
fn groups_of_any_depth_are_recovered() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("deep.journal");
    for depth in [40, 49, 50, 63, 70, 130, 5_000] {
        let mut scene = beginning();
        let mut journal = Journal::create(&path, &scene).expect("a journal");
        let ball: NodeTree = Brush::new(Shape::sphere(0.1)).with_name("a\nb").into();
        let tree = (0..depth).fold(ball, |inner, _| {
            let mut group: NodeTree = Group::new().at([0.01, 0.0, 0.0]).into();
            group.children.push(inner);
            group
        });
        assert_eq!(tree.clone().depth(), depth + 1);
        let insert = Action::InsertTree {
            parent: Scene::ROOT,
            index: 1,
            tree,
        };
        let (before, line) = (line(&scene, 1), scene.action_line(&insert));
        journal.replay(&mut scene, &before).expect("an edit");
        journal.replay(&mut scene, &line).expect("a deep edit");
        assert!(scene.brush_count() >= 2);
        let recovered = Journal::recover(&path).expect("a journal");
        assert!(recovered.edits == 2 && recovered.scene == scene, "{depth}");
    }
}

/// A file of no bytes is what is left of a session that ended before its first edit.
#[test]
fn empty_journals_hold_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("empty.journal");
    std::fs::write(&path, "").expect("a file");
    let error = Journal::recover(&path).expect_err("nothing");
    assert!(matches!(error, JournalError::Empty(_)), "{error}");
    // It is nobody's, and others are kept.
    let scene = beginning();
    drop(Journal::create_new(&path, &scene).expect("a journal"));
    assert!(Journal::recover(&path).expect("a journal").scene == scene);
    let error = Journal::create_new(&path, &scene).expect_err("it is there");
    assert!(matches!(error, JournalError::Exists(_)), "{error}");
}
