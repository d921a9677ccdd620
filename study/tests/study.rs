//! Runs a small study from beginning to end: measure, store, resume, report.

use argil::Engine;
use argil_study::{Record, Store, StudyOptions, StudyProgress, findings, report, study};
use std::fs;
use std::path::{Path, PathBuf};

#[derive(Default)]
struct Seen {
    all: usize,
    known: usize,
    cases: Vec<String>,
}

impl StudyProgress for Seen {
    fn started(&mut self, cases: usize, done: usize) {
        (self.all, self.known) = (cases, done);
    }

    fn case(&mut self, _: &str, experiment: &str, case: &str) {
        self.cases.push(format!("{experiment}: {case}"));
    }

    fn done(&mut self, error: Option<&str>) {
        assert_eq!(error, None);
    }
}

fn options(only: &[&str]) -> StudyOptions {
    StudyOptions {
        only: only.iter().map(|name| (*name).to_owned()).collect(),
        ..StudyOptions::default()
    }
}

fn measured(folder: &Path, only: &[&str]) -> Seen {
    let mut seen = Seen::default();
    let summary = study(&[Engine::cpu()], &options(only), folder, &mut seen).expect("a study");
    assert_eq!((summary.failed, summary.broken), (0, 0));
    assert_eq!(summary.done, seen.cases.len());
    seen
}

#[test]
fn a_study_resumes_and_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path().join("out");
    let first = measured(&place, &["center"]);
    assert_eq!((first.all, first.known), (1, 0));
    let second = measured(&place, &["center", "dense-fill"]);
    assert_eq!(second.known, 1);
    assert!(
        second
            .cases
            .iter()
            .all(|case| case.starts_with("dense-fill"))
    );
    let records = Store::read(&place).expect("records");
    assert_eq!(records.len(), second.all);
    let center = &records[0];
    assert_eq!(center.value("bricks"), Some(8.0));
    assert!(center.checks.len() == 1 && center.checks[0].passed);
    assert!(
        place
            .join("pictures")
            .join(&center.pictures["picture"])
            .is_file()
    );
    let build = records.iter().find(|r| r.via == "bricks").expect("a build");
    assert_eq!(build.samples["build_ms"].len(), 4);
    let command = build.command.as_deref().expect("a command");
    assert!(command.starts_with("argil bake scenes/"), "{command}");

    // A line that was cut in the middle is lost alone. The cases of its sitting are measured again.
    let file = place.join("records.jsonl");
    let text = fs::read_to_string(&file).expect("lines");
    fs::write(&file, &text[..text.len() - 30]).expect("a file");
    let third = measured(&place, &["center", "dense-fill"]);
    assert_eq!(third.cases.len(), 3);
    assert_eq!(Store::read(&place).expect("records").len(), second.all);
    // Any other line that is none is told with its place.
    fs::write(&file, format!("{{\n{text}")).expect("a file");
    let error = format!("{:#}", Store::read(&place).expect_err("no record"));
    assert!(error.contains("records.jsonl:1"), "{error}");
    fs::write(&file, &text).expect("a file");

    let page = folder.path().join("report.html");
    report(std::slice::from_ref(&place), &page).expect("a report");
    let page = fs::read_to_string(page).expect("a page");
    for part in [
        "Bricks at the center",
        "Dense fill",
        "data:image/png;base64,",
        "<svg",
        "argil bake scenes/teapot.json",
        "the octree stores 8 bricks",
        "undecided",
    ] {
        assert!(page.contains(part), "{part}");
    }
    // Nothing is fetched.
    assert!(!page.contains("src=\"http") && !page.contains("href=\"http"));
    // Of what was not measured nothing is said.
    assert!(!page.contains("Lost bricks"));
}

#[test]
fn failures_are_reported_in_their_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let lines = [
        Record {
            experiment: "frames".into(),
            case: "teapot/field/frames".into(),
            scene: "teapot".into(),
            via: "field".into(),
            error: Some("no room for <it>".into()),
            ..Record::default()
        },
        Record {
            experiment: "frames".into(),
            case: "teapot/dense/frames".into(),
            scene: "teapot".into(),
            via: "dense".into(),
            samples: [("frame_ms".to_owned(), vec![1.5, 2.5, 3.5])].into(),
            checks: vec![argil_study::Check {
                value: "hit_pixels".into(),
                expected: "from 1 to inf".into(),
                found: None,
                passed: false,
            }],
            ..Record::default()
        },
    ];
    let file = folder.path().join("records.jsonl");
    let text: String = lines
        .iter()
        .map(|r| serde_json::to_string(r).expect("JSON") + "\n")
        .collect();
    fs::write(&file, text).expect("a file");
    let out = folder.path().join("r.html");
    report(&[file], &out).expect("a report");
    let page = fs::read_to_string(out).expect("a page");
    for part in [
        "failed: no room for &lt;it&gt;",
        "1 case failed",
        "hit_pixels is missing, expected from 1 to inf",
        "3 samples, min 1.50",
    ] {
        assert!(page.contains(part), "{part}");
    }
}

/// An image counts only if its error falls with each doubling.
#[test]
fn images_that_converge_are_counted() {
    let record = |(scene, resolution, flip): &(&str, u32, f64)| Record {
        experiment: "convergence".into(),
        case: format!("{scene}/bricks-{resolution}/picture"),
        scene: (*scene).into(),
        via: "bricks".into(),
        parameters: [
            ("resolution".to_owned(), (*resolution).into()),
            ("show".to_owned(), "shaded".into()),
        ]
        .into(),
        values: [("flip_mean".to_owned(), *flip)].into(),
        ..Record::default()
    };
    let cases = [
        ("teapot", 512, 0.01),
        ("teapot", 128, 0.04),
        ("teapot", 256, 0.02),
        ("props", 128, 0.04),
        ("props", 256, 0.01),
        ("props", 512, 0.02),
    ];
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("records.jsonl");
    let line = |case| serde_json::to_string(&record(case)).expect("JSON") + "\n";
    fs::write(&file, cases.iter().map(line).collect::<String>()).expect("a file");
    let out = folder.path().join("findings.md");
    findings(&[file], &out).expect("findings");
    let page = fs::read_to_string(out).expect("a page");
    assert!(page.contains("resolution in 1 of 2 images"), "{page}");
}

#[test]
fn impossible_studies_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let wrong = study(
        &[Engine::cpu()],
        &options(&["nonsense"]),
        folder.path(),
        &mut Seen::default(),
    );
    let error = format!("{:#}", wrong.expect_err("no experiment"));
    assert!(
        error.contains("nonsense") && error.contains("construction"),
        "{error}"
    );
    let out = folder.path().join("r.html");
    let error = format!(
        "{:#}",
        report(&["gone".into()], &out).expect_err("no records")
    );
    assert!(error.contains("gone"), "{error}");
    fs::write(folder.path().join("records.jsonl"), "").expect("a file");
    assert!(report(&[folder.path().into()], &out).is_err() && !out.exists());
}

/// `docs/findings.md` is generated from the committed records.
#[test]
fn the_findings_are_up_to_date() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut places: Vec<PathBuf> = fs::read_dir(root.join("records"))
        .expect("records")
        .map(|entry| entry.expect("an entry").path())
        .collect();
    places.sort();
    assert!(!places.is_empty());
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("findings.md");
    findings(&places, &out).expect("findings");
    let committed = fs::read_to_string(root.join("../docs/findings.md")).expect("a page");
    let made = fs::read_to_string(out).expect("a page");
    assert!(
        committed == made,
        "run `cargo run --release -- study findings study/records/* -o docs/findings.md`"
    );
}

/// Every CPU is named `cpu`. Records of two machines are not mixed.
#[test]
fn machines_are_distinguished() {
    let folder = tempfile::tempdir().expect("a folder");
    let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
    measured(&a, &["center"]);
    let mut record: Record = Store::read(&a).expect("records").remove(0);
    record.machine.processor = "another".into();
    fs::create_dir_all(&b).expect("a folder");
    let line = serde_json::to_string(&record).expect("text") + "\n";
    fs::write(b.join("records.jsonl"), line).expect("a file");
    let page = folder.path().join("both.html");
    // The same folder twice is that folder.
    report(&[a.clone(), b, a.clone()], &page).expect("a page");
    let text = fs::read_to_string(&page).expect("a page");
    assert!(text.contains("cpu (another)"), "the other is named");
    // The other's picture was not copied, and the first one's is not its.
    assert_eq!(text.matches("data:image/png").count(), 1);
    assert_eq!(text.matches("the image file is missing").count(), 1);
    assert!(text.contains("All rows (2)"), "a row each");
    // Records are no place for a report.
    let input = a.join("records.jsonl");
    let before = fs::read(&input).expect("records");
    assert!(report(&[a], &input).is_err());
    assert_eq!(fs::read(&input).expect("records"), before);
}

/// Times of a hardware GPU are compared at one clock only. The findings say what was left out.
#[test]
fn clocks_decide_what_is_compared() {
    let record = |(via, ms, clock): (&str, f64, f64)| {
        let mut record = Record {
            experiment: "frames".into(),
            case: format!("teapot/{via}/frames"),
            scene: "teapot".into(),
            via: via.into(),
            sitting: Some(argil_study::Sitting {
                id: 7,
                cases: 2,
                attempts: 3,
                alone_because: None,
            }),
            ..Record::default()
        };
        record.machine.device = "NVIDIA H100 80GB HBM3".into();
        record.machine.driver = "NVIDIA 580, vulkan".into();
        record.samples.insert("frame_ms".into(), vec![ms]);
        for (name, mhz) in [
            ("gpu_clock_mhz", clock),
            ("gpu_clock_min_mhz", clock),
            ("gpu_clock_max_mhz", clock),
            ("gpu_clock_limit_mhz", 1980.0),
        ] {
            record.values.insert(name.into(), mhz);
        }
        serde_json::to_string(&record).expect("JSON") + "\n"
    };
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("records.jsonl");
    let found = |clocks: [f64; 2]| {
        let cases = [("octree", 1.48, clocks[0]), ("dense", 1.0, clocks[1])];
        fs::write(&file, cases.map(record).concat()).expect("a file");
        let out = folder.path().join("findings.md");
        findings(std::slice::from_ref(&file), &out).expect("findings");
        fs::read_to_string(out).expect("a page")
    };
    let page = found([1980.0, 1950.0]);
    assert!(
        page.contains("**confirmed**: frame time of the octree"),
        "{page}"
    );
    assert!(page.contains("1.48 (1 of 1 agree)"), "{page}");
    assert!(
        page.contains("1950 to 1980 of 1980 MHz while measured"),
        "{page}"
    );
    assert!(!page.contains("no record of a hardware GPU"), "{page}");
    let page = found([1980.0, 1500.0]);
    let left_out = "no pair is compared; 1 pair left out: clocks differ by more than 3 %";
    assert!(page.contains(left_out) && !page.contains("1.48"), "{page}");
    // A GPU that was asleep has no times at all.
    let page = found([345.0, 345.0]);
    assert!(
        !page.contains("1.48") && page.contains("have no times"),
        "{page}"
    );
    assert!(page.contains("no record of a hardware GPU at full clock yet"));
}
