//! Plots as SVG, in the colors of the page.

use plotters::coord::Shift;
use plotters::prelude::*;

/// Width and height in pixels.
const SIZE: (u32, u32) = (720, 360);

/// Colors that most people can distinguish, on light and dark backgrounds (Okabe and Ito 2008).
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(128, 128, 128),
];

/// Placeholder for the page's text color.
const INK: RGBColor = RGBColor(1, 2, 3);

/// Named points.
pub(super) type Series = (String, Vec<(f64, f64)>);

/// Titles and scales of a plot.
#[derive(Clone, Copy)]
pub(super) struct PlotAxes<'a> {
    /// Title of the plot.
    pub title: &'a str,
    /// Title of the x axis.
    pub x: &'a str,
    /// Title of the y axis.
    pub y: &'a str,
    /// Whether the y axis is logarithmic.
    pub log_y: bool,
    /// Whether the x axis is logarithmic.
    pub log_x: bool,
}

type Drawn = Result<(), Box<dyn std::error::Error>>;

fn color(index: usize) -> RGBColor {
    COLORS[index % COLORS.len()]
}

fn drawn(title: &str, draw: impl FnOnce(DrawingArea<SVGBackend<'_>, Shift>) -> Drawn) -> String {
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
    if let Err(error) = draw(area) {
        return format!(
            "<p class=\"fault\">no plot: {}</p>",
            crate::formatting::escaped(&error.to_string())
        );
    }
    // The plot scales with the page and uses its text color.
    let open = format!(
        "<svg role=\"img\" aria-label=\"{}\" viewBox=\"0 0 {} {}\" ",
        crate::formatting::escaped(title),
        SIZE.0,
        SIZE.1
    );
    let svg = svg.replacen(
        &format!(
            "<svg width=\"{}\" height=\"{}\" viewBox=\"0 0 {} {}\" ",
            SIZE.0, SIZE.1, SIZE.0, SIZE.1
        ),
        &open,
        1,
    );
    svg.replace("#010203", "currentColor")
}

/// Returns the range of numbers with a margin. A linear range begins at 0.
fn range(numbers: impl Iterator<Item = f64>, log: bool) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for n in numbers.filter(|n| n.is_finite() && (!log || *n > 0.0)) {
        (low, high) = (low.min(n), high.max(n));
    }
    if low > high {
        return (if log { 0.1 } else { 0.0 }, 1.0);
    }
    if log {
        (low / 1.5, high * 1.5)
    } else {
        (low.min(0.0), if high > 0.0 { high * 1.08 } else { 1.0 })
    }
}

macro_rules! framed {
    ($area:expr, $axes:expr, $x:expr, $y:expr) => {{
        let mut chart = ChartBuilder::on(&$area)
            .margin(8)
            .caption($axes.title, ("sans-serif", 15, &INK))
            .x_label_area_size(38)
            .y_label_area_size(64)
            .build_cartesian_2d($x, $y)?;
        chart
            .configure_mesh()
            .x_desc($axes.x)
            .y_desc($axes.y)
            .x_label_formatter(&|x| crate::formatting::number(*x))
            .y_label_formatter(&|y| crate::formatting::number(*y))
            .axis_style(INK)
            .label_style(("sans-serif", 12, &INK))
            .axis_desc_style(("sans-serif", 13, &INK))
            .bold_line_style(INK.mix(0.15))
            .light_line_style(TRANSPARENT)
            .draw()?;
        chart
    }};
}

macro_rules! with_lines {
    ($chart:expr, $series:expr) => {{
        let mut chart = $chart;
        for (series, (name, points)) in $series.iter().enumerate() {
            let color = color(series);
            chart
                .draw_series(LineSeries::new(
                    points.iter().copied(),
                    color.stroke_width(2),
                ))?
                .label(name)
                .legend(move |(x, y)| {
                    PathElement::new([(x, y), (x + 16, y)], color.stroke_width(3))
                });
            // Too many points cannot be distinguished.
            let apart = points.iter().filter(|_| points.len() <= 40);
            chart.draw_series(apart.map(|&p| Circle::new(p, 3, color.filled())))?;
        }
        chart
            .configure_series_labels()
            .position(beside($series))
            .label_font(("sans-serif", 12, &INK))
            .border_style(INK.mix(0.2))
            .draw()?;
        Ok(())
    }};
}

/// Returns the position of the legend: where the first line is low.
fn beside(series: &[Series]) -> SeriesLabelPosition {
    let ends = series
        .first()
        .and_then(|(_, points)| points.first().zip(points.last()));
    match ends {
        Some((first, last)) if first.1 > last.1 => SeriesLabelPosition::UpperRight,
        _ => SeriesLabelPosition::UpperLeft,
    }
}

/// Draws lines through points.
pub(super) fn lines(axes: PlotAxes<'_>, series: &[Series]) -> String {
    let all = || series.iter().flat_map(|(_, points)| points);
    let x = range(all().map(|p| p.0), axes.log_x);
    let y = range(all().map(|p| p.1), axes.log_y);
    drawn(axes.title, |area| match (axes.log_x, axes.log_y) {
        (false, false) => with_lines!(framed!(area, axes, x.0..x.1, y.0..y.1), series),
        (true, false) => {
            with_lines!(
                framed!(area, axes, (x.0..x.1).log_scale(), y.0..y.1),
                series
            )
        }
        (false, true) => {
            with_lines!(
                framed!(area, axes, x.0..x.1, (y.0..y.1).log_scale()),
                series
            )
        }
        (true, true) => {
            let (x, y) = ((x.0..x.1).log_scale(), (y.0..y.1).log_scale());
            with_lines!(framed!(area, axes, x, y), series)
        }
    })
}

/// A bar and its whisker.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlotBar {
    /// Height of the bar.
    pub value: f64,
    /// Ends of the whisker.
    pub reach: (f64, f64),
}

/// Returns the range of bars, with a margin above.
fn heights(
    is_log: bool,
    groups: usize,
    series: &[(String, Vec<Option<PlotBar>>)],
    stacked: bool,
) -> [f64; 2] {
    let heights = || series.iter().flat_map(|(_, bars)| bars.iter().flatten());
    let most = if stacked {
        let sum = |group: usize| {
            let bars_of_group = series
                .iter()
                .filter_map(|(_, bars)| bars.get(group).copied().flatten());
            bars_of_group.map(|bar| bar.value).sum::<f64>()
        };
        (0..groups).map(sum).fold(0.0, f64::max)
    } else {
        heights()
            .map(|bar| bar.reach.1.max(bar.value))
            .fold(0.0, f64::max)
    };
    let least = heights()
        .map(|bar| bar.value)
        .filter(|v| *v > 0.0)
        .fold(f64::INFINITY, f64::min);
    let floor = if is_log && least.is_finite() {
        least / 2.0
    } else {
        0.0
    };
    let ceiling = if most > 0.0 { 1.1 * most } else { 1.0 };
    [floor, ceiling]
}

/// Draws groups of bars, one bar per series; or stacked, one bar per group.
pub(super) fn bars(
    axes: PlotAxes<'_>,
    groups: &[String],
    series: &[(String, Vec<Option<PlotBar>>)],
    stacked: bool,
) -> String {
    // Records may lack the value.
    if groups.is_empty() {
        return String::new();
    }
    let [floor, ceiling] = heights(axes.log_y, groups.len(), series, stacked);
    let wide = groups.len() as f64;
    drawn(axes.title, |area| {
        let name = |x: &f64| {
            let at = x.floor();
            let is_middle = (x - at - 0.5).abs() < 0.01;
            groups
                .get(at as usize)
                .filter(|_| is_middle)
                .cloned()
                .unwrap_or_default()
        };
        macro_rules! draw {
            ($y:expr) => {{
                let mut chart = ChartBuilder::on(&area)
                    .margin(8)
                    .caption(axes.title, ("sans-serif", 15, &INK))
                    .x_label_area_size(38)
                    .y_label_area_size(64)
                    .build_cartesian_2d(0.0..wide, $y)?;
                chart
                    .configure_mesh()
                    .disable_x_mesh()
                    .x_labels(2 * groups.len() + 1)
                    .x_label_formatter(&name)
                    .x_desc(axes.x)
                    .y_desc(axes.y)
                    .y_label_formatter(&|y| crate::formatting::number(*y))
                    .axis_style(INK)
                    .label_style(("sans-serif", 12, &INK))
                    .axis_desc_style(("sans-serif", 13, &INK))
                    .bold_line_style(INK.mix(0.15))
                    .light_line_style(TRANSPARENT)
                    .draw()?;
                let each = 0.84 / series.len().max(1) as f64;
                let mut under = vec![0.0; groups.len()];
                for (index, (name, of_series)) in series.iter().enumerate() {
                    let color = color(index);
                    let place = BarPosition {
                        index,
                        each,
                        floor,
                        stacked,
                    };
                    let (boxes, whiskers) = placed(of_series, &place, &mut under);
                    let boxes = boxes.into_iter().map(|b| Rectangle::new(b, color.filled()));
                    let whisker = |w: [(f64, f64); 2]| PathElement::new(w, INK.mix(0.7));
                    let whiskers = whiskers.into_iter().map(whisker);
                    chart.draw_series(boxes)?.label(name).legend(move |(x, y)| {
                        Rectangle::new([(x, y - 5), (x + 12, y + 5)], color.filled())
                    });
                    chart.draw_series(whiskers)?;
                }
                chart
                    .configure_series_labels()
                    .position(SeriesLabelPosition::UpperLeft)
                    .label_font(("sans-serif", 12, &INK))
                    .border_style(INK.mix(0.2))
                    .draw()?;
            }};
        }
        if axes.log_y {
            draw!((floor.max(1e-9)..ceiling).log_scale());
        } else {
            draw!(floor..ceiling);
        }
        Ok(())
    })
}

/// Position of a series' bars.
struct BarPosition {
    /// Index of the series.
    index: usize,
    /// Width of a bar, relative to the group.
    each: f64,
    floor: f64,
    stacked: bool,
}

type Span = [(f64, f64); 2];

/// Returns the corners of a series' bars and the ends of their whiskers. `under` is the stacked height of each
/// group.
fn placed(
    bars: &[Option<PlotBar>],
    place: &BarPosition,
    under: &mut [f64],
) -> (Vec<Span>, Vec<Span>) {
    let &BarPosition {
        index,
        each,
        floor,
        stacked,
    } = place;
    let (mut boxes, mut whiskers) = (Vec::new(), Vec::new());
    for (group, bar) in bars.iter().enumerate() {
        let Some(bar) = bar else { continue };
        let (left, right, low) = if stacked {
            let low = under[group];
            under[group] += bar.value;
            (group as f64 + 0.15, group as f64 + 0.85, low)
        } else {
            let left = group as f64 + 0.08 + each * index as f64;
            (left, left + 0.92 * each, floor)
        };
        let high = low + bar.value - if stacked { 0.0 } else { floor };
        boxes.push([(left, low), (right, high)]);
        if !stacked && bar.reach.1 > bar.reach.0 {
            let middle = 0.5 * (left + right);
            whiskers.push([(middle, bar.reach.0.max(floor)), (middle, bar.reach.1)]);
        }
    }
    (boxes, whiskers)
}
