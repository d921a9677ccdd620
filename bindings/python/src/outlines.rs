//! Letters of a font, and shapes of an image.

use crate::function::named;
use crate::node::Node;
use crate::tree::Tree;
use crate::work;
use argil::glam::{UVec3, Vec2, Vec3};
use argil::math::Aabb;
use argil::scene::{Path2, PathSegment, SAMPLED_SIDE, SampledGrid, nonzero_fill};
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::pen::PathStyle;
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::{FontRef, MetadataProvider};

/// A closed path: its start, and for each segment the control point of a quadratic curve, and the end.
type Path = ([f32; 2], Vec<(Option<[f32; 2]>, [f32; 2])>);

/// Collects paths as they are drawn, from a pen's position.
struct Contours {
    all: Vec<Path2>,
    pen: f32,
}

impl Contours {
    fn put(&mut self, control: Option<[f32; 2]>, to: [f32; 2]) {
        if let Some(path) = self.all.last_mut() {
            path.segments.push(PathSegment { control, to });
        }
    }
}

impl OutlinePen for Contours {
    fn move_to(&mut self, x: f32, y: f32) {
        self.all.push(Path2::new([x + self.pen, y]));
    }
    fn line_to(&mut self, x: f32, y: f32) {
        self.put(None, [x + self.pen, y]);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.put(Some([x1 + self.pen, y1]), [x + self.pen, y]);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        // Two quadratic curves that meet in the middle of the cubic one.
        let from = self.all.last().map_or([x, y], |path| {
            path.segments.last().map_or(path.start, |last| last.to)
        });
        let [a, d] = [Vec2::from(from), Vec2::new(x + self.pen, y)];
        let [b, c] = [Vec2::new(x1 + self.pen, y1), Vec2::new(x2 + self.pen, y2)];
        let middle = 0.125 * (a + 3.0 * b + 3.0 * c + d);
        let (first, second) = (a + 0.75 * (b - a), d + 0.75 * (c - d));
        self.put(Some(first.to_array()), middle.to_array());
        self.put(Some(second.to_array()), d.to_array());
    }
    fn close(&mut self) {}
}

/// Returns the borders of a text's letters, letter by letter, in the font's units: for each path, the number of paths
/// around it. The inside of a path with an odd number is a hole.
#[pyfunction]
pub fn text_outlines(font: &[u8], text: &str) -> PyResult<Vec<Vec<(usize, Path)>>> {
    let face = FontRef::from_index(font, 0)
        .map_err(|error| PyValueError::new_err(format!("the font cannot be read: {error}")))?;
    let (known, outlines) = (face.charmap(), face.outline_glyphs());
    // In the font's units.
    let size = Size::unscaled();
    let widths = face.glyph_metrics(size, LocationRef::default());
    let mut letters = Vec::new();
    let mut pen = 0.0;
    for letter in text.chars() {
        let Some(glyph) = known.map(letter) else {
            return Err(PyValueError::new_err(format!(
                "text: the font has no glyph for {letter:?}"
            )));
        };
        let mut contours = Contours {
            all: Vec::new(),
            pen,
        };
        // A glyph without a path is a space.
        let settings = DrawSettings::unhinted(size, LocationRef::default())
            .with_path_style(PathStyle::HarfBuzz);
        let _ = outlines
            .get(glyph)
            .map(|outline| outline.draw(settings, &mut contours));
        pen += widths.advance_width(glyph).unwrap_or(0.0);
        let border = nonzero_fill(&contours.all).into_iter();
        letters.push(border.map(|path| (path.depth, plain(path.path))).collect());
    }
    Ok(letters)
}

fn plain(path: Path2) -> Path {
    let segments = path.segments.iter();
    let segments = segments.map(|segment| (segment.control, segment.to));
    (path.start, segments.collect())
}

/// Returns the squared distance to the nearest `true` of a row or a column, for distances squared across it.
///
/// The lower envelope of parabolas (Felzenszwalb and Huttenlocher 2012).
fn envelope(
    squares: &mut [f32],
    places: &mut Vec<usize>,
    borders: &mut Vec<f32>,
    out: &mut Vec<f32>,
) {
    places.clear();
    borders.clear();
    for (q, &square) in squares.iter().enumerate() {
        if square == f32::INFINITY {
            continue;
        }
        let mut begin = f32::NEG_INFINITY;
        while let Some(&p) = places.last() {
            let (p1, q1) = (p as f32, q as f32);
            begin = ((square + q1 * q1) - (squares[p] + p1 * p1)) / (2.0 * (q1 - p1));
            if borders.last().is_some_and(|&last| begin <= last) {
                places.pop();
                borders.pop();
                begin = f32::NEG_INFINITY;
            } else {
                break;
            }
        }
        places.push(q);
        borders.push(begin);
    }
    out.clear();
    let mut at = 0;
    for q in 0..squares.len() {
        while at + 1 < places.len() && borders[at + 1] < q as f32 {
            at += 1;
        }
        out.push(places.get(at).map_or(f32::INFINITY, |&p| {
            squares[p] + (q as f32 - p as f32).powi(2)
        }));
    }
    squares.copy_from_slice(out);
}

/// Returns the distance of each pixel to the nearest one that is set, in pixels.
fn distance_transform(mask: &[bool], width: usize) -> Vec<f32> {
    let height = mask.len() / width;
    let mut squares: Vec<f32> = mask
        .iter()
        .map(|&set| if set { 0.0 } else { f32::INFINITY })
        .collect();
    let buffers = || (Vec::new(), Vec::new(), Vec::new());
    squares
        .par_chunks_mut(width)
        .for_each_init(buffers, |(a, b, c), row| envelope(row, a, b, c));
    let columns: Vec<Vec<f32>> = (0..width)
        .into_par_iter()
        .map_init(buffers, |(a, b, c), x| {
            let mut column: Vec<f32> = (0..height).map(|y| squares[y * width + x]).collect();
            envelope(&mut column, a, b, c);
            column
        })
        .collect();
    (0..mask.len())
        .map(|i| columns[i % width][i / width].sqrt())
        .collect()
}

/// Returns a profile from the pixels that are set, `width` wide around the origin. The first row is at the top.
#[pyfunction]
pub fn image_profile(
    py: Python<'_>,
    mask: PyReadonlyArray2<'_, bool>,
    width: f32,
) -> PyResult<Node> {
    let shape = mask.shape();
    let (rows, columns) = (shape[0], shape[1]);
    let pixels = mask
        .as_slice()
        .map_err(|error| PyValueError::new_err(error.to_string()))?;
    if rows < 2 || columns < 2 || !pixels.contains(&true) || !pixels.contains(&false) {
        return Err(PyValueError::new_err(format!(
            "image: {columns} × {rows} pixels of one color have no shape"
        )));
    }
    let grid = work::run(py, None, |_| {
        let inverse: Vec<bool> = pixels.iter().map(|set| !set).collect();
        let (outside, inside) = (
            distance_transform(pixels, columns),
            distance_transform(&inverse, columns),
        );
        // The border lies between pixels.
        let signed = |i: usize| {
            if pixels[i] {
                0.5 - inside[i]
            } else {
                outside[i] - 0.5
            }
        };
        let distances: Vec<f32> = (0..pixels.len()).map(signed).collect();
        let pixel = width / columns as f32;
        let half = 0.5 * Vec2::new(columns as f32, rows as f32);
        let value = |p: Vec3| {
            let at = Vec2::new(p.x, -p.y) / pixel + half - 0.5;
            let held = at.clamp(Vec2::ZERO, 2.0 * half - 1.0);
            let low = held.floor().min(2.0 * half - 2.0);
            let t = held - low;
            let sample =
                |x: f32, y: f32| distances[(low.y + y) as usize * columns + (low.x + x) as usize];
            let along = |y: f32| sample(0.0, y) + (sample(1.0, y) - sample(0.0, y)) * t.x;
            let distance = along(0.0) + (along(1.0) - along(0.0)) * t.y;
            // Cut off at the image's border.
            let beyond = (at - half + 0.5).abs() - half;
            let of_border = beyond.max(Vec2::ZERO).length() + beyond.max_element().min(0.0);
            pixel * distance.max(of_border)
        };
        // A layer around z = 0, which the section is taken of.
        let longest = half.max_element() * 2.0 * pixel;
        let spacing = longest / (half.max_element() * 2.0).clamp(16.0, 2000.0);
        let cell = spacing * SAMPLED_SIDE as f32;
        let solid = box_of_set(pixels, columns, pixel, 0.5 * cell);
        let region = Aabb::centered((half * pixel + 2.0 * spacing).extend(0.5 * cell));
        let cells = (region.size() / cell - 1e-3)
            .ceil()
            .as_uvec3()
            .max(UVec3::ONE);
        let corner = region.center() - 0.5 * cell * cells.as_vec3();
        let sampler = |points: &[Vec3], out: &mut [f32]| {
            for (point, out) in points.iter().zip(out) {
                *out = value(*point);
            }
        };
        SampledGrid::sample(corner, cell, cells, solid, &sampler)
    })?;
    grid.check()
        .map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(Node::new(Tree::Shape(named(grid))))
}

/// Returns the box of the pixels that are set, with half a pixel of room, as far as the image goes.
fn box_of_set(pixels: &[bool], columns: usize, pixel: f32, half_depth: f32) -> Aabb {
    let size = Vec2::new(columns as f32, (pixels.len() / columns) as f32);
    let set = (0..pixels.len()).filter(|&i| pixels[i]);
    let (low, high) = set.fold((size, Vec2::ZERO), |(low, high), i| {
        let at = Vec2::new((i % columns) as f32, (i / columns) as f32);
        (low.min(at), high.max(at + 1.0))
    });
    let (low, high) = ((low - 0.5).max(Vec2::ZERO), (high + 0.5).min(size));
    // Rows run downward.
    let [left, right] = [low.x, high.x].map(|x| (x - 0.5 * size.x) * pixel);
    let [bottom, top] = [high.y, low.y].map(|y| (0.5 * size.y - y) * pixel);
    Aabb::new(
        Vec3::new(left, bottom, -half_depth),
        Vec3::new(right, top, half_depth),
    )
}
