//! Panels with shared time axis: lines, shaded stretches, horizontal limits, legends that cover no data.

use std::path::Path;

use plotters::{
    coord::{Shift, types::RangedCoordf64},
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use wbqp_measures::Series;
use wbqp_terminal::output::{Existing, OutputError, write};

/// Why there is no figure.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// It could not be drawn.
    #[error("figure: {0}")]
    Draw(String),
    /// Its file could not be written.
    #[error(transparent)]
    Write(#[from] OutputError),
}

impl<E: std::error::Error + Send + Sync> From<DrawingAreaErrorKind<E>> for PlotError {
    fn from(error: DrawingAreaErrorKind<E>) -> Self {
        Self::Draw(error.to_string())
    }
}

/// Colours that stay apart in print and for colour-blind readers (Okabe and Ito).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "a colour's name says it")]
pub enum Colour {
    Black,
    Blue,
    Red,
    Green,
    Orange,
    Purple,
    Sky,
    Grey,
}

impl Colour {
    /// One after the other, for lines of the same kind.
    pub const CYCLE: [Self; 6] = [
        Self::Blue,
        Self::Red,
        Self::Green,
        Self::Orange,
        Self::Purple,
        Self::Sky,
    ];

    pub(super) fn rgb(self) -> RGBColor {
        match self {
            Self::Black => RGBColor(0, 0, 0),
            Self::Blue => RGBColor(0, 114, 178),
            Self::Red => RGBColor(213, 58, 40),
            Self::Green => RGBColor(0, 158, 115),
            Self::Orange => RGBColor(230, 159, 0),
            Self::Purple => RGBColor(178, 100, 160),
            Self::Sky => RGBColor(86, 180, 233),
            Self::Grey => RGBColor(120, 120, 120),
        }
    }
}

/// A line with its name in the legend.
#[derive(Clone, Debug)]
pub struct Line {
    /// Name in the legend; empty for none.
    pub name: String,
    /// Colour.
    pub colour: Colour,
    /// Whether it is dashed.
    pub dashed: bool,
    /// The signal.
    pub data: Series,
}

impl Line {
    /// A solid line.
    pub fn solid(name: &str, colour: Colour, data: Series) -> Self {
        Self {
            name: name.to_owned(),
            colour,
            dashed: false,
            data,
        }
    }

    /// A dashed line.
    pub fn dashed(name: &str, colour: Colour, data: Series) -> Self {
        Self {
            dashed: true,
            ..Self::solid(name, colour, data)
        }
    }
}

/// Stretches of time with a coloured background.
#[derive(Clone, Debug)]
pub struct Shade {
    /// Name in the legend.
    pub name: String,
    /// Colour.
    pub colour: Colour,
    /// Opacity, 0 to 1.
    pub strength: f64,
    /// First and last instant of each, s.
    pub stretches: Vec<(f64, f64)>,
}

/// One coordinate system.
#[derive(Clone, Debug, Default)]
pub struct Panel {
    /// Above the panel.
    pub title: String,
    /// Quantity and unit of the vertical axis.
    pub y_label: String,
    /// Fixed vertical range; by default what the data needs.
    pub y_range: Option<(f64, f64)>,
    /// Signals.
    pub lines: Vec<Line>,
    /// Backgrounds.
    pub shades: Vec<Shade>,
    /// Dotted horizontal lines, with the name in the legend.
    pub limits: Option<(String, Vec<f64>)>,
}

/// Panels above one another.
#[derive(Clone, Debug, Default)]
pub struct Figure {
    /// From top to bottom.
    pub panels: Vec<Panel>,
    /// Range of the time axis, s.
    pub time: (f64, f64),
}

pub(super) const WIDTH: u32 = 960;
const PANEL: u32 = 390;
const LEGEND_ROW: i32 = 24;
/// Plotters divides by 1.24 on the way to SVG.
pub(super) const TEXT: f64 = 17.0 * 1.24;
const TITLE: f64 = 19.0 * 1.24;
pub(super) const FONT: &str = "DejaVu Sans, Arial, sans-serif";
/// Lines thinner than this in time show nothing more.
const POINTS: usize = 1600;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

impl Figure {
    /// Writes an SVG file.
    ///
    /// # Errors
    /// [`PlotError`] if the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), PlotError> {
        let height = PANEL * self.panels.len().max(1) as u32;
        let mut svg = String::new();
        let root = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
        root.fill(&WHITE)?;
        for (panel, area) in self
            .panels
            .iter()
            .zip(root.split_evenly((self.panels.len().max(1), 1)))
        {
            panel.draw(&area, self.time)?;
        }
        root.present()?;
        drop(root);
        Ok(write(path, &svg, Existing::IsReplaced)?)
    }
}

impl Panel {
    fn draw(&self, area: &Area<'_>, time: (f64, f64)) -> Result<(), PlotError> {
        let (header, body) = area.split_vertically(self.header_height());
        self.draw_header(&header)?;
        let (low, high) = self.range(time);
        let mut chart = ChartBuilder::on(&body)
            .margin_left(14)
            .margin_right(24)
            .margin_bottom(6)
            .x_label_area_size(54)
            .y_label_area_size(84)
            .build_cartesian_2d(time.0..time.1, low..high)?;
        self.draw_shades(&mut chart, (low, high))?;
        let label = (FONT, TEXT).into_font();
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_desc("time [s]")
            .y_desc(&self.y_label)
            .x_labels(11)
            .x_label_formatter(&|t| short(*t))
            .y_label_formatter(&|y| short(*y))
            .y_labels(7)
            .label_style(label.clone())
            .axis_desc_style(label)
            .draw()?;
        if let Some((_, limits)) = &self.limits {
            for &y in limits {
                let dots =
                    DashedLineSeries::new([(time.0, y), (time.1, y)], 2, 4, BLACK.stroke_width(2));
                chart.draw_series(dots)?;
            }
        }
        for line in &self.lines {
            let style = line.colour.rgb().stroke_width(2);
            for run in runs(&line.data.window(time.0, time.1)) {
                if line.dashed {
                    chart.draw_series(DashedLineSeries::new(run, 9, 6, style))?;
                } else {
                    chart.draw_series(LineSeries::new(run, style))?;
                }
            }
        }
        Ok(())
    }

    fn draw_shades(&self, chart: &mut Chart<'_, '_>, y: (f64, f64)) -> Result<(), PlotError> {
        for shade in &self.shades {
            let fill = shade.colour.rgb().mix(shade.strength).filled();
            let rectangle =
                |&(from, to): &(f64, f64)| Rectangle::new([(from, y.0), (to, y.1)], fill);
            chart.draw_series(shade.stretches.iter().map(rectangle))?;
        }
        Ok(())
    }

    /// Fixed range, or that of the data with a margin.
    fn range(&self, time: (f64, f64)) -> (f64, f64) {
        if let Some(range) = self.y_range {
            return range;
        }
        let limits = self.limits.iter().flat_map(|(_, l)| l.iter().copied());
        let visible = self.lines.iter().map(|l| l.data.window(time.0, time.1));
        let values: Vec<f64> = visible
            .flat_map(|s| [s.min(), s.max()])
            .flatten()
            .chain(limits)
            .collect();
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if low > high {
            return (0.0, 1.0);
        }
        let margin = (0.06 * (high - low)).max(1e-6 * high.abs()).max(1e-9);
        (low - margin, high + margin)
    }

    /// Height of title and legend, pixels.
    pub(super) fn header_height(&self) -> i32 {
        38 + LEGEND_ROW * self.legend_rows()
    }

    /// Title on the left, legend below it, row by row.
    pub(super) fn draw_header(&self, area: &Area<'_>) -> Result<(), PlotError> {
        let at = |size: f64| {
            (FONT, size)
                .into_font()
                .color(&BLACK)
                .pos(Pos::new(HPos::Left, VPos::Center))
        };
        area.draw_text(&self.title, &at(TITLE).clone(), (84, 22))?;
        for (entry, (column, row)) in self.legend() {
            let (x, y) = (column, 38 + LEGEND_ROW * row + LEGEND_ROW / 2);
            match entry {
                Entry::Line(line) => {
                    let style = line.colour.rgb().stroke_width(3);
                    let dash: &[(i32, i32)] = if line.dashed {
                        &[(0, 9), (13, 22), (26, 30)]
                    } else {
                        &[(0, 30)]
                    };
                    for (a, b) in dash {
                        area.draw(&PathElement::new([(x + a, y), (x + b, y)], style))?;
                    }
                }
                Entry::Shade(shade) => {
                    let fill = shade.colour.rgb().mix(shade.strength).filled();
                    area.draw(&Rectangle::new([(x, y - 8), (x + 30, y + 8)], fill))?;
                }
                Entry::Limits(_) => {
                    for a in [0, 6, 12, 18, 24] {
                        let style = BLACK.stroke_width(2);
                        area.draw(&PathElement::new([(x + a, y), (x + a + 3, y)], style))?;
                    }
                }
            }
            area.draw_text(entry.name(), &at(TEXT), (x + 38, y))?;
        }
        Ok(())
    }

    /// Entries with the left edge and the row of each.
    fn legend(&self) -> Vec<(Entry<'_>, (i32, i32))> {
        let lines = self
            .lines
            .iter()
            .filter(|l| !l.name.is_empty())
            .map(Entry::Line);
        let limits = self.limits.iter().map(|(name, _)| Entry::Limits(name));
        let shades = self.shades.iter().map(Entry::Shade);
        let (mut x, mut row) = (84, 0);
        let mut placed = Vec::new();
        for entry in lines.chain(limits).chain(shades) {
            let width = 38 + 26 + (9.6 * entry.name().chars().count() as f64) as i32;
            if x + width > WIDTH.cast_signed() && x > 84 {
                (x, row) = (84, row + 1);
            }
            placed.push((entry, (x, row)));
            x += width;
        }
        placed
    }

    fn legend_rows(&self) -> i32 {
        self.legend().last().map_or(0, |(_, (_, row))| row + 1)
    }
}

/// What the legend shows.
enum Entry<'a> {
    Line(&'a Line),
    Shade(&'a Shade),
    Limits(&'a str),
}

impl Entry<'_> {
    fn name(&self) -> &str {
        match self {
            Self::Line(line) => &line.name,
            Self::Shade(shade) => &shade.name,
            Self::Limits(name) => name,
        }
    }
}

/// A tick's number without noise of rounding and trailing zeros.
pub(super) fn short(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0" } else { text }.to_owned()
}

/// Points of unbroken stretches of a signal, thinned to the lowest and highest of each pixel, so that peaks stay.
fn runs(series: &Series) -> Vec<Vec<(f64, f64)>> {
    let points: Vec<(f64, f64)> = series.samples().collect();
    let Some(step) = typical_step(&points) else {
        return vec![points];
    };
    points
        .chunk_by(|a, b| b.0 - a.0 < 5.0 * step)
        .map(thin)
        .collect()
}

/// Median distance in time, s.
fn typical_step(points: &[(f64, f64)]) -> Option<f64> {
    let mut steps: Vec<f64> = points.windows(2).map(|w| w[1].0 - w[0].0).collect();
    steps.sort_unstable_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied()
}

fn thin(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let bucket = points.len().div_ceil(POINTS / 2);
    if bucket < 2 {
        return points.to_vec();
    }
    let mut thinned = Vec::with_capacity(POINTS);
    for part in points.chunks(bucket) {
        let by_value = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let (low, high) = (part.iter().min_by(by_value), part.iter().max_by(by_value));
        if let (Some(&low), Some(&high)) = (low, high) {
            let (first, second) = if low.0 <= high.0 {
                (low, high)
            } else {
                (high, low)
            };
            thinned.push(first);
            if second != first {
                thinned.push(second);
            }
        }
    }
    thinned
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_peaks_and_gaps_stay_open() {
        let mut points: Vec<(f64, f64)> = (0..10_000).map(|k| (1e-3 * f64::from(k), 0.0)).collect();
        points[5_003].1 = 7.0;
        points.drain(2_000..3_000);
        let runs = runs(&points.into_iter().collect());
        assert_eq!(runs.len(), 2);
        assert!(runs[1].len() <= POINTS + 1);
        assert!(runs[1].iter().any(|p| p.1 == 7.0));
    }

    #[test]
    fn an_empty_figure_is_drawn() {
        let path = std::env::temp_dir().join("wbqp_empty_figure.svg");
        let figure = Figure {
            panels: vec![Panel::default()],
            time: (0.0, 1.0),
        };
        figure.save(&path).unwrap();
        assert!(std::fs::read_to_string(&path).unwrap().contains("<svg"));
        std::fs::remove_file(path).unwrap();
    }
}
