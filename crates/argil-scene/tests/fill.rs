//! Paths by the nonzero winding rule, against winding numbers of finely sampled curves.

use argil_scene::{Path2, nonzero_fill, text_outlines};
use glam::DVec2;

/// Lines per curve of the winding number, and how far from the border points are compared.
const SAMPLES: usize = 32;
const MARGIN: f64 = 4e-3;

/// A closed polygon.
type Polygon = Vec<DVec2>;

fn sampled(path: &Path2) -> Polygon {
    let point = |at: [f32; 2]| DVec2::new(f64::from(at[0]), f64::from(at[1]));
    let mut points = vec![point(path.start)];
    for (from, control, to) in path.segments() {
        let (a, c) = (point(from), point(to));
        let Some(b) = control.map(point) else {
            points.push(c);
            continue;
        };
        points.extend((1..=SAMPLES).map(|i| {
            let t = i as f64 / SAMPLES as f64;
            a.lerp(b, t).lerp(b.lerp(c, t), t)
        }));
    }
    points
}

/// Returns the sum of the angles at which a point sees the edges, in turns.
fn winding_number(polygons: &[Polygon], at: DVec2) -> i64 {
    let turns = |polygon: &Polygon| {
        let next = polygon.iter().cycle().skip(1);
        let angles = polygon.iter().zip(next).map(|(a, b)| {
            let (a, b) = (*a - at, *b - at);
            a.perp_dot(b).atan2(a.dot(b))
        });
        angles.sum::<f64>() / std::f64::consts::TAU
    };
    polygons.iter().map(turns).sum::<f64>().round() as i64
}

fn border_distance(polygons: &[Polygon], at: DVec2) -> f64 {
    let edges = polygons
        .iter()
        .flat_map(|polygon| polygon.iter().zip(polygon.iter().cycle().skip(1)));
    let distances = edges.map(|(&a, &b)| {
        let length = (b - a).length_squared().max(1e-300);
        at.distance(a.lerp(b, ((at - a).dot(b - a) / length).clamp(0.0, 1.0)))
    });
    distances.fold(f64::INFINITY, f64::min)
}

/// Numbers from 0 to 1 (xorshift).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }
}

/// Returns the points at which borders disagree with the winding number of paths, of points in a square. A border is
/// read by the even-odd rule, as shapes read it.
fn faults(paths: &[Path2], border: &[Path2], half: f32, random: &mut Random) -> usize {
    let [paths, border] = [paths, border].map(|all| all.iter().map(sampled).collect::<Vec<_>>());
    let is_wrong = |at: DVec2| {
        let expected = winding_number(&paths, at) != 0;
        let is_inside = border
            .iter()
            .filter(|&path| winding_number(std::slice::from_ref(path), at) % 2 != 0);
        let near = MARGIN * f64::from(half);
        let edge = border_distance(&border, at) < near || border_distance(&paths, at) < near;
        !edge && (is_inside.count() % 2 == 1) != expected
    };
    (0..60)
        .map(|_| [random.next(), random.next()].map(|t| f64::from(half * (2.0 * t - 1.0))))
        .filter(|&at| is_wrong(at.into()))
        .count()
}

fn border(paths: &[Path2]) -> Vec<Path2> {
    let nested = nonzero_fill(paths);
    assert!(nested.is_sorted_by_key(|nested| nested.depth));
    nested.into_iter().map(|nested| nested.path).collect()
}

/// Returns a circle of four curves, counterclockwise if the radius is positive.
fn circle([x, y]: [f32; 2], radius: f32) -> Path2 {
    let (r, d) = (radius.abs(), radius);
    let corner = |i: usize, j: usize| {
        let signs = [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [-1.0, 1.0]];
        let turned = |[a, b]: [f32; 2], turns: usize| (0..turns).fold([a, b], |[a, b], _| [-b, a]);
        let [a, b] = turned(signs[i], j);
        [x + r * a, y + d * b]
    };
    (0..4).fold(Path2::new(corner(0, 0)), |path, turns| {
        path.curve(corner(1, turns), corner(2, turns))
    })
}

fn bar(x: [f32; 2], y: [f32; 2]) -> Path2 {
    Path2::new([x[0], y[0]])
        .line([x[1], y[0]])
        .line([x[1], y[1]])
        .line([x[0], y[1]])
}

/// Glyphs as fonts draw them: islands in holes, strokes that cross, and contours that overlap.
fn glyph_like() -> Vec<(&'static str, Vec<Path2>, usize)> {
    let nest = |signs: [f32; 4]| {
        let rings = signs.iter().zip(1..);
        rings
            .map(|(sign, i)| circle([0.0; 2], sign * 0.2 * (5 - i) as f32))
            .collect::<Vec<_>>()
    };
    let ring = [circle([0.0; 2], 0.9), circle([0.0; 2], -0.75)];
    let with_ring = |others: &[Path2]| [&ring[..], others].concat();
    let letter_c = bar([-0.3, 0.3], [-0.3, 0.3]);
    let letter_r = [bar([-0.3, 0.3], [-0.4, 0.4]), circle([0.0, 0.1], -0.2)];
    let one = [
        bar([-0.05, 0.05], [-0.4, 0.4]),
        bar([-0.3, 0.3], [-0.4, -0.3]),
    ];
    let struck = [
        circle([0.0; 2], 0.6),
        circle([0.0; 2], -0.4),
        bar([-0.8, 0.8], [-0.1, 0.1]),
    ];
    vec![
        ("c in a circle", with_ring(&[letter_c]), 3),
        ("r in a circle", with_ring(&letter_r), 4),
        ("1 in a circle, of two strokes", with_ring(&one), 3),
        ("a stroke through a ring", struck.to_vec(), 3),
        ("four rings in turn", nest([1.0, -1.0, 1.0, -1.0]), 4),
        ("four disks in one direction", nest([1.0; 4]), 1),
        ("clockwise rings", nest([-1.0, 1.0, -1.0, 1.0]), 4),
        (
            "two letters that overlap",
            vec![circle([-0.2, 0.0], 0.5), circle([0.2, 0.0], 0.5)],
            1,
        ),
        (
            "one letter twice",
            vec![circle([0.0; 2], 0.5), circle([0.0; 2], 0.5)],
            1,
        ),
        (
            "a letter and its opposite",
            vec![circle([0.0; 2], 0.5), circle([0.0; 2], -0.5)],
            0,
        ),
    ]
}

#[test]
fn borders_of_glyphs_enclose_what_winds_around_points() {
    let mut random = Random(5);
    for (name, paths, count) in glyph_like() {
        let border = border(&paths);
        assert_eq!(border.len(), count, "{name}");
        assert_eq!(faults(&paths, &border, 1.0, &mut random), 0, "{name}");
    }
    // The paths themselves, by the even-odd rule.
    let (_, overlapping, _) = glyph_like().swap_remove(7);
    assert!(faults(&overlapping, &overlapping, 1.0, &mut random) > 0);
}

#[test]
fn borders_of_random_paths_enclose_what_winds_around_points() {
    let mut random = Random(77);
    for case in 0..120 {
        // A coarse grid gives points and edges that coincide.
        let steps = [6.0, 600.0][case % 2];
        let mut point =
            || [random.next(), random.next()].map(|t| (t * steps).floor() / steps * 2.0 - 1.0);
        let paths: Vec<Path2> = (0..1 + case % 4)
            .map(|_| {
                (0..2 + case % 7).fold(Path2::new(point()), |path, i| match (case + i) % 3 {
                    0 => path.line(point()),
                    _ => path.curve(point(), point()),
                })
            })
            .collect();
        let border = border(&paths);
        assert_eq!(faults(&paths, &border, 1.0, &mut random), 0, "case {case}");
    }
}

#[test]
fn letters_that_overlap_stay_whole() {
    // The built-in font draws these letters over the ones before them.
    for (text, separate, joined) in [("(j", 3, 2), ("!⁄", 3, 2), ("%⁄", 6, 5), ("Å©®", 10, 10)]
    {
        let letters = text
            .chars()
            .map(|letter| text_outlines(&letter.to_string(), 1.0).len());
        assert_eq!(letters.sum::<usize>(), separate, "{text}");
        let outlines = text_outlines(text, 1.0);
        assert_eq!(outlines.len(), joined, "{text}");
        assert_eq!(border(&outlines).len(), joined, "{text}");
    }
}

#[test]
fn paths_without_an_inside_have_no_border() {
    for path in [
        Path2::new([0.0; 2]),
        Path2::new([0.0; 2]).line([1.0, 0.0]),
        Path2::new([0.0; 2]).line([f32::NAN, 0.0]).line([1.0, 1.0]),
        Path2::new([0.0; 2])
            .line([f32::INFINITY, 0.0])
            .line([1.0, 1.0]),
    ] {
        assert_eq!(nonzero_fill(std::slice::from_ref(&path)), [], "{path:?}");
    }
    assert_eq!(nonzero_fill(&[]), []);
}
