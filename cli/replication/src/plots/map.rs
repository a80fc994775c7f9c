//! Paths in a plane, to scale.

use std::path::Path;

use plotters::prelude::*;

use super::{
    Colour, Line, Panel, PlotError,
    figure::{FONT, TEXT, WIDTH, short},
};
use wbqp_measures::Series;
use wbqp_terminal::output::{Existing, write};

/// A path with its name in the legend.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Colour.
    pub colour: Colour,
    /// Whether it is dashed.
    pub dashed: bool,
    /// Its points, right and up.
    pub points: Vec<(f64, f64)>,
}

impl Curve {
    /// The path of two signals of the same instants; where one has no sample there is no point.
    pub fn new(name: &str, colour: Colour, right: &Series, up: &Series) -> Self {
        let points = right.y.iter().copied().zip(up.y.iter().copied());
        Self {
            name: name.to_owned(),
            colour,
            dashed: false,
            points: points
                .filter(|(x, y)| x.is_finite() && y.is_finite())
                .collect(),
        }
    }

    /// Dashed.
    pub fn dashed(mut self) -> Self {
        self.dashed = true;
        self
    }
}

/// A plane with paths. Both axes have the same scale.
#[derive(Clone, Debug, Default)]
pub struct Map {
    /// Above the plane.
    pub title: String,
    /// Quantity and unit of the axis that points right.
    pub right: String,
    /// Quantity and unit of the axis that points up.
    pub up: String,
    /// Paths; the last is on top.
    pub curves: Vec<Curve>,
}

const LEFT: u32 = 98;
const RIGHT: u32 = 24;
const BELOW: u32 = 60;

impl Map {
    /// Writes an SVG file.
    ///
    /// # Errors
    /// [`PlotError`] if the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), PlotError> {
        let header = self.header();
        let header_height = header.header_height();
        let [(left, right), (low, high)] = [self.range(|p| p.0), self.range(|p| p.1)];
        let scale = f64::from(WIDTH - LEFT - RIGHT) / (right - left);
        // A path that is almost straight still gets a readable axis.
        let plane = ((high - low) * scale).clamp(160.0, 2400.0) as u32;
        let height = header_height.unsigned_abs() + plane + BELOW;
        let mut svg = String::new();
        let root = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
        root.fill(&WHITE)?;
        let (top, body) = root.split_vertically(header_height);
        header.draw_header(&top)?;
        let mut chart = ChartBuilder::on(&body)
            .margin_left(14)
            .margin_right(RIGHT)
            .margin_bottom(6)
            .x_label_area_size(54)
            .y_label_area_size(84)
            .build_cartesian_2d(left..right, low..high)?;
        let label = (FONT, TEXT).into_font();
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_desc(&self.right)
            .y_desc(&self.up)
            .x_labels(13)
            .y_labels(9)
            .x_label_formatter(&|x| short(*x))
            .y_label_formatter(&|y| short(*y))
            .label_style(label.clone())
            .axis_desc_style(label)
            .draw()?;
        for curve in &self.curves {
            let style = curve.colour.rgb().stroke_width(2);
            let points = apart(&curve.points, 0.7 / scale);
            if curve.dashed {
                chart.draw_series(DashedLineSeries::new(points, 9, 6, style))?;
            } else {
                chart.draw_series(LineSeries::new(points, style))?;
            }
        }
        root.present()?;
        drop((chart, top, body, root));
        Ok(write(path, &svg, Existing::IsReplaced)?)
    }

    /// Title and legend, as a panel without data.
    fn header(&self) -> Panel {
        let line = |curve: &Curve| Line {
            name: curve.name.clone(),
            colour: curve.colour,
            dashed: curve.dashed,
            data: Series::default(),
        };
        Panel {
            title: self.title.clone(),
            lines: self.curves.iter().map(line).collect(),
            ..Panel::default()
        }
    }

    /// What all points need, with a margin.
    fn range(&self, coordinate: impl Fn(&(f64, f64)) -> f64) -> (f64, f64) {
        let values = || self.curves.iter().flat_map(|c| &c.points).map(&coordinate);
        let low = values().fold(f64::INFINITY, f64::min);
        let high = values().fold(f64::NEG_INFINITY, f64::max);
        if low > high {
            return (0.0, 1.0);
        }
        let margin = (0.06 * (high - low)).max(1e-6 * high.abs()).max(1e-9);
        (low - margin, high + margin)
    }
}

/// Leaves out points that are nearer to the last one than `distance`.
fn apart(points: &[(f64, f64)], distance: f64) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for &(x, y) in points {
        let far = |&(a, b): &(f64, f64)| (x - a).hypot(y - b) >= distance;
        if kept.last().is_none_or(far) {
            kept.push((x, y));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_is_round_and_an_empty_map_is_drawn() {
        let path = std::env::temp_dir().join(format!("wbqp_map_{}.svg", std::process::id()));
        Map::default().save(&path).unwrap();
        let angle = |k: i32| f64::from(k) * 0.01;
        let [right, up] = [f64::cos as fn(f64) -> f64, f64::sin].map(|f| {
            (0..629)
                .map(|k| (angle(k), f(angle(k))))
                .collect::<Series>()
        });
        let map = Map {
            curves: vec![Curve::new("circle", Colour::Blue, &right, &up).dashed()],
            ..Map::default()
        };
        map.save(&path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let height = text.split("height=\"").nth(1).unwrap();
        let height: u32 = height.split('"').next().unwrap().parse().unwrap();
        let plane = WIDTH - LEFT - RIGHT;
        assert!(height.abs_diff(plane + BELOW + map.header().header_height().unsigned_abs()) <= 1);
        std::fs::remove_file(path).unwrap();
    }
}
