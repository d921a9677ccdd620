//! Writes one brush per line, with groups indented.

use super::document::Head;
use crate::{NodeId, NodeKind, Scene};
use std::io::{self, Write};

pub(super) fn write(scene: &Scene, out: &mut impl Write) -> io::Result<()> {
    write!(out, "{{\n  \"argil\": {},\n", super::FORMAT_VERSION)?;
    for (key, text) in [("name", &scene.name), ("credit", &scene.credit)] {
        if !text.is_empty() {
            writeln!(out, "  \"{key}\": {},", serde_json::to_string(text)?)?;
        }
    }
    writeln!(out, "  \"view\": {},", serde_json::to_string(&scene.view)?)?;
    if !scene.materials.is_empty() {
        out.write_all(b"  \"materials\": {\n")?;
        for (i, (name, material)) in scene.materials.iter().enumerate() {
            let comma = if i + 1 < scene.materials.len() {
                ","
            } else {
                ""
            };
            writeln!(
                out,
                "    {}: {}{comma}",
                serde_json::to_string(name)?,
                serde_json::to_string(material)?
            )?;
        }
        out.write_all(b"  },\n")?;
    }
    out.write_all(b"  \"brushes\": [")?;
    write_items(scene, out)?;
    out.write_all(b"\n  ]\n}\n")
}

/// The lists, innermost last, each with what remains of it.
pub(super) fn write_items(scene: &Scene, out: &mut impl Write) -> io::Result<()> {
    let mut open: Vec<(&[NodeId], bool)> = vec![(scene.node(Scene::ROOT).children(), true)];
    while let Some((rest, first)) = open.last_mut() {
        let Some((&id, tail)) = rest.split_first() else {
            open.pop();
            if !open.is_empty() {
                out.write_all(b"]}")?;
            }
            continue;
        };
        let comma = if std::mem::take(first) { "" } else { "," };
        *rest = tail;
        // Indentation stops growing, because a tree a thousand levels deep would be mostly white space.
        let indent = 2 + 2 * open.len().min(16);
        write!(out, "{comma}\n{:indent$}", "")?;

        let entry = scene.node(id).desc();
        let head = serde_json::to_string(&Head::of(entry))?;
        match entry.kind {
            NodeKind::Shape(_) => out.write_all(head.as_bytes())?,
            NodeKind::Group => {
                let separator = if head.len() > 2 { ", " } else { "" };
                write!(out, "{}{separator}\"brushes\": [", &head[..head.len() - 1])?;
                open.push((scene.node(id).children(), true));
            }
        }
    }
    Ok(())
}
