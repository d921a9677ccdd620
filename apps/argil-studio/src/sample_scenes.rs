//! Sample scenes.

use argil::scene::Scene;

/// Names and contents.
pub(crate) const ALL: &[(&str, &str)] = &[
    ("Melting", include_str!("../../../scenes/melting.json")),
    ("Teapot", include_str!("../../../scenes/teapot.json")),
    (
        "Constructive solids",
        include_str!("../../../scenes/csg20.json"),
    ),
    ("Props", include_str!("../../../scenes/props.json")),
    ("Temple", include_str!("../../../scenes/temple.json")),
    ("Edgy cube", include_str!("../../../scenes/edgy-cube.json")),
    ("Morph", include_str!("../../../scenes/morph.json")),
];

/// Returns a sample scene.
pub(crate) fn sample(name: &str) -> Option<Scene> {
    let (_, text) = ALL.iter().find(|(known, _)| *known == name)?;
    Scene::from_json(text, name).ok()
}

/// Returns the scene shown at start.
pub(crate) fn first() -> Scene {
    sample(ALL[0].0).expect("a sample that is compiled in")
}

#[cfg(test)]
mod tests {
    #[test]
    fn all_can_be_read() {
        for (name, _) in super::ALL {
            let scene = super::sample(name).expect("a scene");
            assert!(scene.brush_count() > 0, "{name}");
        }
    }
}
