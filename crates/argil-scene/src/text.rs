//! Text as paths, from the letters of a font.

use crate::validation::ValidationError;
use crate::{Path2, PathSegment, nonzero_fill};
use argil_math::Aabb;
use glam::Vec2;
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::pen::PathStyle;
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::{FontRef, GlyphId, MetadataProvider};
use std::sync::LazyLock;

/// Maximum characters of a text, and maximum segments of their paths. Each segment costs every evaluation of its
/// shape.
const MAX_CHARACTERS: usize = 64;
const MAX_TEXT_PIECES: usize = 1024;

/// The built-in font: Ubuntu Light, under the Ubuntu Font License 1.0.
static FONT: LazyLock<FontRef<'static>> =
    LazyLock::new(|| FontRef::new(epaint_default_fonts::UBUNTU_LIGHT).expect("the font is one"));

/// Lengths are in the font's units.
fn unscaled() -> Size {
    Size::unscaled()
}

/// Checks that the font has the characters, that there are not too many, and that something is visible.
pub(crate) fn letters(path: &str, text: &str) -> Result<(), ValidationError> {
    let count = text.chars().count();
    if count > MAX_CHARACTERS {
        let reason = format!("{count} characters are more than the limit, {MAX_CHARACTERS}");
        return Err(ValidationError::new(path, reason));
    }
    let known = FONT.charmap();
    let has = |c: char| !c.is_control() && known.map(c).is_some();
    let unknown = |&c: &char| c != '\n' && !has(c);
    if let Some(unknown) = text.chars().find(unknown) {
        let reason = format!("the font has no glyph for {unknown:?}");
        return Err(ValidationError::new(path, reason));
    }
    if text_bounds(text, 1.0, 1.0).is_empty() {
        return Err(ValidationError::new(
            path,
            "the text has no visible characters",
        ));
    }
    let outlines = text_outlines(text, 1.0);
    let pieces: usize = outlines.iter().map(|outline| outline.segments.len()).sum();
    if pieces > MAX_TEXT_PIECES {
        let reason = format!(
            "its letters have {pieces} lines and curves, more than the limit, {MAX_TEXT_PIECES}: write it as several brushes"
        );
        return Err(ValidationError::new(path, reason));
    }
    Ok(())
}

/// Iterates over the glyphs of a text, with the pen's position in the font's units.
fn glyphs(text: &str) -> impl Iterator<Item = (GlyphId, Vec2)> + '_ {
    let (known, widths) = (
        FONT.charmap(),
        FONT.glyph_metrics(unscaled(), LocationRef::default()),
    );
    let about = FONT.metrics(unscaled(), LocationRef::default());
    let line_height = about.ascent - about.descent + about.leading;
    text.lines().enumerate().flat_map(move |(index, line)| {
        let glyph_ids: Vec<GlyphId> = line.chars().filter_map(|c| known.map(c)).collect();
        let advance = |glyph: GlyphId| widths.advance_width(glyph).unwrap_or(0.0);
        let length: f32 = glyph_ids.iter().map(|&glyph| advance(glyph)).sum();
        let mut pen = Vec2::new(-0.5 * length, -line_height * index as f32);
        let placed = glyph_ids.into_iter().map(|glyph| {
            let at = pen;
            pen.x += advance(glyph);
            (glyph, at)
        });
        placed.collect::<Vec<_>>()
    })
}

fn scale_of(size: f32) -> f32 {
    size / f32::from(
        FONT.metrics(unscaled(), LocationRef::default())
            .units_per_em,
    )
}

/// Returns the closed paths of a text in the x–y plane, including holes, without overlaps. The first line stands on the
/// x axis, each line is centered, and an em is `size` high. Characters that the font lacks are skipped.
#[doc(hidden)]
pub fn text_outlines(text: &str, size: f32) -> Vec<Path2> {
    let mut all = Vec::new();
    let outlines = FONT.outline_glyphs();
    for (glyph, pen) in glyphs(text) {
        let mut contours = Contours { all: &mut all, pen };
        let settings = DrawSettings::unhinted(unscaled(), LocationRef::default())
            .with_path_style(PathStyle::HarfBuzz);
        // A glyph without a path is a space.
        let _ = outlines
            .get(glyph)
            .map(|outline| outline.draw(settings, &mut contours));
    }
    let scale = scale_of(size);
    let border = nonzero_fill(&all).into_iter();
    border.map(|nested| nested.path.scaled(scale)).collect()
}

/// Returns the box of a text, extruded along z: the union of its letters' boxes.
pub(crate) fn text_bounds(text: &str, size: f32, half_depth: f32) -> Aabb {
    let scale = scale_of(size);
    let boxes = FONT.glyph_metrics(unscaled(), LocationRef::default());
    let glyph_bounds = glyphs(text).filter_map(|(glyph, pen)| {
        let bounds = boxes
            .bounds(glyph)
            .filter(|bounds| bounds.x_min < bounds.x_max)?;
        let corner = |x: f32, y: f32, z: f32| ((pen + Vec2::new(x, y)) * scale).extend(z);
        Some(Aabb::new(
            corner(bounds.x_min, bounds.y_min, -half_depth),
            corner(bounds.x_max, bounds.y_max, half_depth),
        ))
    });
    glyph_bounds.fold(Aabb::EMPTY, |all, bounds| all.union(bounds))
}

/// Collects paths as they are drawn, from a pen's position, in the font's units.
struct Contours<'a> {
    all: &'a mut Vec<Path2>,
    pen: Vec2,
}

impl Contours<'_> {
    fn at(&self, x: f32, y: f32) -> [f32; 2] {
        (self.pen + Vec2::new(x, y)).to_array()
    }

    fn put(&mut self, control: Option<[f32; 2]>, to: [f32; 2]) {
        if let Some(last) = self.all.last_mut() {
            last.segments.push(PathSegment { control, to });
        }
    }
}

impl OutlinePen for Contours<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        let start = self.at(x, y);
        self.all.push(Path2::new(start));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let to = self.at(x, y);
        self.put(None, to);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (control, to) = (self.at(x1, y1), self.at(x, y));
        self.put(Some(control), to);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        // For fonts with cubic curves: the quadratic curve with nearly the same tangents.
        self.quad_to(0.5 * (x1 + x2), 0.5 * (y1 + y2), x, y);
    }

    fn close(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_that_cannot_be_shown_are_refused() {
        for (text, reason) in [
            ("", "no visible characters"),
            ("  \n ", "no visible characters"),
            ("a\tb", "no glyph for '\\t'"),
            ("漢", "no glyph for '漢'"),
            (&"x".repeat(65), "65 characters"),
            (&"@".repeat(40), "lines and curves"),
        ] {
            let fault = letters("text", text).expect_err(text);
            assert!(fault.reason.contains(reason), "{fault}");
        }
        assert_eq!(letters("text", "Wörter\n& more"), Ok(()));
    }

    #[test]
    fn outlines_lie_in_their_box_and_lines_are_centered() {
        let bounds = text_bounds("Ag\nworld", 2.0, 0.1);
        let outlines = text_outlines("Ag\nworld", 2.0);
        assert!(outlines.len() >= 9, "{}", outlines.len());
        for outline in &outlines {
            for (from, _, to) in outline.segments() {
                for [x, y] in [from, to] {
                    assert!(bounds.grown(1e-4).contains([x, y, 0.0].into()), "{x} {y}");
                }
            }
        }
        let middle = bounds.center();
        assert!(middle.x.abs() < 0.1 && middle.y < 0.0, "{middle}");
    }
}
