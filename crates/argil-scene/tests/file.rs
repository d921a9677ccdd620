//! Tests scene files: round trips, errors with line and column, and hostile input.

use argil_scene::{Brush, FileError, Group, Material, Modifier, Path2, PathSegment, Scene, Shape};

fn parse(json: &str) -> Result<Scene, String> {
    Scene::from_json(json, "s.json").map_err(|e| e.to_string())
}

#[test]
fn a_scene_with_everything_survives_a_round_trip_bit_for_bit() {
    let mut scene = Scene::new();
    scene.name = "all \"sorts\"\n".into();
    scene
        .set_material(
            "glaze",
            Material {
                roughness: 0.1,
                ..Material::default()
            },
        )
        .unwrap();
    let outline = Path2 {
        start: [0.0, 0.0],
        segments: vec![
            PathSegment {
                control: None,
                to: [1.0, 0.0],
            },
            PathSegment {
                control: Some([1.0, 1.0]),
                to: [0.0, 0.1],
            },
        ],
    };
    scene
        .push(
            Brush::new(Shape::Lathe { outline })
                .with_material("glaze")
                .with_name("pot"),
        )
        .unwrap();
    let group = scene
        .push(Group::new().with_modifier(Modifier::Mirror {
            axes: [true, false, false],
        }))
        .unwrap()
        .node;
    // A decimal that has no short form, a denormal and a negative zero.
    let odd = [0.1f32 + 0.2, f32::from_bits(3), -0.0];
    scene
        .push_into(
            group,
            Brush::new(Shape::sphere(1.0 / 3.0))
                .at(odd)
                .chamfer(0.7)
                .hidden(),
        )
        .unwrap();
    scene
        .push(Brush::new(Shape::sphere(1.0)).morph(0.25))
        .unwrap();
    let mut locked: argil_scene::NodeDesc = Brush::new(Shape::sphere(2.0)).into();
    locked.locked = true;
    scene.push(locked).unwrap();
    let text = scene.to_json();
    let again = parse(&text).unwrap();
    assert_eq!(scene, again);
    assert_eq!(text, again.to_json());
    let group = again.node_by_path(&scene.path(group)).expect("the group");
    let Modifier::Translate { by } =
        again.node(again.node(group).children()[0]).desc().modifiers[0]
    else {
        panic!("no translation")
    };
    assert_eq!(by.map(f32::to_bits), odd.map(f32::to_bits));
    // Negative control: another radius is another scene.
    assert_ne!(
        scene,
        parse(&text.replace("0.33333334", "0.33333337")).unwrap()
    );
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of files")]
fn errors_name_line_column_path_and_reason() {
    let brush = |b: &str| {
        format!(
            "{{\"argil\": 1, \"brushes\": [\n{{\"shape\": {{\"type\": \"sphere\", \"radius\": 1}}}},\n{b}\n]}}"
        )
    };
    let sphere = "\"shape\": {\"type\": \"sphere\", \"radius\": 1}";
    let lit = |light: &str| {
        let point = r#"{"type": "point", "at": [0, 0, 0], "intensity": [1, 1, 1]}"#;
        format!(r#"{{"argil": 1, "view": {{"lights": [{point}, {light}]}}, "brushes": []}}"#)
    };
    let textured = |texture: &str| {
        format!(
            r#"{{"argil": 1, "materials": {{"a": {{"textures": {{"bump": {texture}}}}}}}, "brushes": []}}"#
        )
    };
    for (json, message) in [
        (
            lit(r#"{"type": "point", "at": [0, 0, 0], "intensity": [1, 1, 1], "radius": "wide"}"#),
            "view.lights[1].radius: invalid type: string \"wide\"",
        ),
        (
            lit(r#"{"type": "point", "at": [0, 0, 0]}"#),
            "view.lights[1]: missing field `intensity`",
        ),
        (
            textured(r#"{"pattern": {"type": "perlin"}}"#),
            "materials.a.textures.bump.pattern.type: unknown variant `perlin`",
        ),
        (
            textured(r#"{"pattern": "wood"}"#),
            "materials.a.textures.bump.pattern: invalid type: string \"wood\", expected an object with a \"type\"",
        ),
        (
            brush(r#"{"shape": {"type": "sphere", "radius": -1}}"#),
            "s.json:3:40: brushes[1].shape.radius: -1 is not positive",
        ),
        (
            brush(r#"{"shape": {"type": "sphere", "radius": "big"}}"#),
            "s.json:3:40: brushes[1].shape.radius: invalid type: string \"big\", expected f32",
        ),
        (
            brush(r#"{"shape": {"type": "sphere", "radius": 1e39}}"#),
            "s.json:3:40: brushes[1].shape.radius: inf is not a number from −1000000 to 1000000",
        ),
        (
            brush(r#"{"shape": {"type": "ball", "radius": 1}}"#),
            "s.json:3:20: brushes[1].shape.type: unknown variant `ball`",
        ),
        (
            brush(r#"{"shape": {"type": "sphere", "radius": 1, "size": 2}}"#),
            "s.json:3:43: brushes[1].shape.size: unknown field `size`",
        ),
        (
            brush(r#"{"shape": {"type": "sphere"}}"#),
            "brushes[1].shape: missing field `radius`",
        ),
        (brush(&format!("{{{sphere}, \"color\": 1}}")), "s.json:3:"),
        (
            brush(&format!("{{{sphere}, \"blend\": -0.5}}")),
            "brushes[1].blend: -0.5 is negative",
        ),
        (
            brush(&format!("{{{sphere}, \"material\": \"tin\"}}")),
            "brushes[1].material: the scene has no material \"tin\"",
        ),
        (
            brush(&format!("{{{sphere}, \"brushes\": []}}")),
            "this has both",
        ),
        (
            brush("{}"),
            "s.json:3:1: brushes[1]: neither a \"shape\" (a brush) nor \"brushes\"",
        ),
        (
            brush(&format!(
                "{{{sphere}, \"modifiers\": [{{\"type\": \"scale\", \"by\": 0}}]}}"
            )),
            "brushes[1].modifiers[0].by: 0 is not from",
        ),
        (
            brush(&format!(
                "{{{sphere}, \"modifiers\": [{{\"type\": \"scale\", \"by\": 2, \"to\": 0}}]}}"
            )),
            "brushes[1].modifiers[0].to: unknown field `to`",
        ),
        (
            brush("{\"shape\": {\"type\": \"sphere\", \"raduis\": 1}}"),
            "s.json:3:30: brushes[1].shape.raduis: unknown field `raduis`, expected `radius`; did you mean `radius`?",
        ),
        (
            brush("{\"shape\": {\"type\": \"spehre\", \"radius\": 1}}"),
            "did you mean `sphere`?",
        ),
        (
            brush(&format!("{{{sphere}, \"materail\": \"a\"}}")),
            "brushes[1].materail: unknown field `materail`, expected one of `name`",
        ),
        (
            brush(&format!("{{{sphere}, \"operator\": \"substract\"}}")),
            "did you mean `subtract`?",
        ),
        (
            brush(&format!(
                "{{{sphere}, \"modifiers\": [{{\"type\": \"translate\", \"by\": [1, 2, 3]}}, {{\"type\": \"twist\", \"degree\": 1}}]}}"
            )),
            "brushes[1].modifiers[1].degree: unknown field `degree`",
        ),
        (
            "{\"argil\": 1, \"brushs\": []}".into(),
            "s.json:1:14: brushs: unknown field `brushs`, expected one of `$schema`",
        ),
        (
            "{\"argil\": 1,\n \"view\": {\"grond\": true}, \"brushes\": []}".into(),
            "s.json:2:11: view.grond: unknown field `grond`",
        ),
        (
            "{\"argil\": 1, \"materials\": {\"a\": {\"base_colors\": [1, 1, 1]}}, \"brushes\": []}"
                .into(),
            "did you mean `base_color`?",
        ),
        (
            "{\"argil\": 1, // one\n \"brushes\": []}".into(),
            "s.json:1:14: JSON has no comments",
        ),
        (
            "{\"argil\": 1, \"brushes\": [],}".into(),
            "no comma after the last value",
        ),
        (
            brush(&format!("{{{sphere}, \"material\": \"none\"}}")),
            "brushes[1].material: the scene has no material \"none\"",
        ),
        (
            brush(&format!("{{\"brushes\": [{{{sphere}, \"amount\": 2}}]}}")),
            "brushes[1].brushes[0].amount: 2 is not from 0 to 1",
        ),
        (
            brush(&format!("{{{sphere}, \"blend\": 1, \"blend\": 2}}")),
            "s.json:3:53: brushes[1].blend: duplicate field",
        ),
        (
            "{\"argil\": 1, \"brushes\": []} x".into(),
            "unexpected data",
        ),
        ("{\"argil\": 1}".into(), "the field \"brushes\" is missing"),
        ("{\"argil\": 1, \"brushes\": [".into(), "truncated"),
        (
            "{\"argil\": 0, \"brushes\": []}".into(),
            "0 is not a version",
        ),
        (
            "{\"brushes\": []}".into(),
            "the field \"argil\": 1, the version of the format, is missing",
        ),
        ("[]".into(), "one JSON object"),
        ("".into(), "truncated"),
        ("\u{0}\u{0}garbage".into(), "invalid JSON"),
        (
            "{\"argil\": 1, \"materials\": {\"a\": {\"roughness\": 2}}, \"brushes\": []}".into(),
            "materials.a.roughness: 2 is not from 0 to 1",
        ),
        (
            "{\"argil\": 1, \"view\": {\"camera\": {\"orbit\": [0, 91, 1]}}, \"brushes\": []}"
                .into(),
            "view.camera.orbit[1]: 91",
        ),
    ] {
        let error = parse(&json).expect_err(&json);
        assert!(
            error.contains(message),
            "{json}\n  gave {error}\n  not  {message}"
        );
    }
    assert!(matches!(
        Scene::from_json("{\"argil\": 2, \"what\": 0}", "s"),
        Err(FileError::Newer { found: 2, .. })
    ));
    // Also where what is unknown comes first.
    assert!(matches!(
        Scene::from_json("{\"what\": 0, \"argil\": 2}", "s"),
        Err(FileError::Newer { found: 2, .. })
    ));
}

/// Tools sort keys, and editors add the address of a schema.
#[test]
fn fields_have_any_order() {
    let sphere = "{\"shape\": {\"type\": \"sphere\", \"radius\": 1}, \"material\": \"red\"}";
    let red = "\"materials\": {\"red\": {\"base_color\": [1, 0, 0]}}";
    let usual = format!("{{\"argil\": 1, {red}, \"brushes\": [{sphere}]}}");
    let sorted =
        format!("{{\"$schema\": \"x.json\", \"brushes\": [{sphere}], {red}, \"argil\": 1}}");
    assert_eq!(parse(&sorted).unwrap(), parse(&usual).unwrap());
    // The other reader takes it, too.
    let deep = format!(
        "{}{sphere}{}",
        "{\"brushes\": [".repeat(40),
        "]}".repeat(40)
    );
    let text = format!("{{\"brushes\": [{deep}], {red}, \"argil\": 1, \"$schema\": \"x\"}}");
    assert_eq!(parse(&text).unwrap().brush_count(), 1);
}

#[test]
fn groups_ten_thousand_levels_deep_are_read_and_written() {
    let depth = 10_000;
    let json = format!(
        "{{\"argil\": 1, \"brushes\": [{}{{\"shape\": {{\"type\": \"sphere\", \"radius\": 1}}}}{}]}}",
        "{\"brushes\": [".repeat(depth),
        "]}".repeat(depth)
    );
    let scene = parse(&json).unwrap();
    assert_eq!(scene.iter().count(), depth + 2);
    assert_eq!(parse(&scene.to_json()).unwrap(), scene);
    // The path of a fault at the bottom is found without a deep stack as well.
    let error = parse(&json.replace("\"radius\": 1", "\"radius\": 0")).unwrap_err();
    assert!(error.ends_with("shape.radius: 0 is not positive"));
}

#[test]
fn deep_and_long_parts_are_refused() {
    let deep = format!(
        "{{\"argil\": 1, \"brushes\": [{{\"shape\": {}",
        "[".repeat(100_000)
    );
    assert!(parse(&deep).is_err());
    let long = format!("{{\"argil\": 1, \"name\": \"{}\"", "x".repeat(65 << 20));
    assert!(parse(&long).unwrap_err().contains("longer than the limit"));
    let bottomless =
        "{\"argil\": 1, \"brushes\": [".to_owned() + &"{\"brushes\": [".repeat(300_000);
    assert!(
        parse(&bottomless)
            .unwrap_err()
            .contains("deeper than the limit")
    );
}

#[test]
fn a_truncated_file_is_refused_at_every_length() {
    let mut scene = Scene::new();
    scene
        .push(Brush::new(Shape::sphere(1.0)).at([1.0, 2.0, 3.0]))
        .unwrap();
    let text = scene.to_json();
    for length in 0..text.trim_end().len() {
        assert!(parse(&text[..length]).is_err(), "{length}");
    }
}

#[test]
fn the_committed_schema_is_up_to_date() {
    let committed = include_str!("../../../scenes/argil.schema.json");
    assert!(
        committed == argil_scene::schema(),
        "run `cargo xtask generate`"
    );
}

#[test]
fn keys_of_earlier_versions_are_read() {
    let now = r#"{"argil": 1, "view": {"camera": {"look_at": {"eye": [0, 0, 5], "target": [0, 0, 0]}}, "bounds": [[-1, -1, -1], [1, 1, 1]]}, "brushes": [
        {"shape": {"type": "box_frame", "half_size": [1, 1, 1], "half_thickness": 0.1}},
        {"shape": {"type": "cut_hollow_sphere", "radius": 1, "cut": 0.1, "half_thickness": 0.1}},
        {"shape": {"type": "sphere", "radius": 1}, "modifiers": [{"type": "shell", "half_thickness": 0.1}]},
        {"shape": {"type": "extrusion", "outline": {"start": [0, 0], "segments": [{"to": [1, 0]}, {"to": [0, 1]}]}, "half_depth": 1}}]}"#;
    let earlier = now
        .replace("look_at", "look")
        .replace("bounds", "frame")
        .replace("half_thickness", "thickness")
        .replace("segments", "pieces");
    assert_ne!(now, earlier);
    let [now, earlier] = [now, &earlier].map(|json| parse(json).expect("a scene"));
    assert_eq!(now.to_json(), earlier.to_json());
}
