//! Lines, areas and arrows in space, seen from one side, as SVG.
//!
//! Written directly and not by the library of the other figures: that one rounds to whole pixels, by which short links
//! change their direction, and needs five times the space.

use std::fmt::Write as _;

use wbqp::nalgebra::Vector3;

/// Where the camera is: degrees to the right of what the robot looks along, and above the horizon.
const AZIMUTH: f64 = -52.0;
const ELEVATION: f64 = 18.0;
/// Size of the picture at most, pixels.
const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 560.0;
const MARGIN: f64 = 26.0;
/// Height of a line of text, pixels.
const LINE: f64 = 17.0;

/// Something to be drawn; lengths in metres but those of the pen, which are pixels.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    /// Straight pieces one after the other.
    Path { points: Vec<Vector3<f64>>, pen: Pen },
    /// Filled, with a thin edge.
    Area {
        points: Vec<Vector3<f64>>,
        colour: &'static str,
        opacity: f64,
    },
    /// A disc that always faces the camera.
    Dot {
        at: Vector3<f64>,
        radius: f64,
        fill: &'static str,
        edge: &'static str,
    },
    /// With a word at its tip.
    Arrow {
        from: Vector3<f64>,
        to: Vector3<f64>,
        colour: &'static str,
        label: String,
    },
    /// The sign of a centre of mass: a disc in four quarters.
    Mass { at: Vector3<f64>, radius: f64 },
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pen {
    pub(super) colour: &'static str,
    pub(super) width: f64,
    pub(super) dash: Dash,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dash {
    Solid,
    Dashed,
}

impl Pen {
    pub(super) fn solid(colour: &'static str, width: f64) -> Self {
        Self {
            colour,
            width,
            dash: Dash::Solid,
        }
    }

    pub(super) fn dashed(colour: &'static str, width: f64) -> Self {
        Self {
            dash: Dash::Dashed,
            ..Self::solid(colour, width)
        }
    }
}

impl Shape {
    pub(super) fn points(&self) -> Vec<Vector3<f64>> {
        match self {
            Self::Path { points, .. } | Self::Area { points, .. } => points.clone(),
            Self::Dot { at, .. } | Self::Mass { at, .. } => vec![*at],
            Self::Arrow { from, to, .. } => vec![*from, *to],
        }
    }
}

/// A picture: layers from back to front, each sorted by distance from the camera.
#[derive(Clone, Debug, Default)]
pub(super) struct Canvas {
    pub(super) layers: Vec<Vec<Shape>>,
    /// Lines above the picture, each with its colour.
    pub(super) text: Vec<(String, &'static str)>,
}

/// Right, up and towards the camera.
fn camera() -> [Vector3<f64>; 3] {
    let (sa, ca) = AZIMUTH.to_radians().sin_cos();
    let (se, ce) = ELEVATION.to_radians().sin_cos();
    [
        Vector3::new(-sa, ca, 0.0),
        Vector3::new(-se * ca, -se * sa, ce),
        Vector3::new(ce * ca, ce * sa, se),
    ]
}

/// From metres to pixels.
struct Projection {
    axes: [Vector3<f64>; 3],
    scale: f64,
    left: f64,
    top: f64,
}

impl Projection {
    fn at(&self, p: &Vector3<f64>) -> (f64, f64) {
        (
            self.left + self.scale * self.axes[0].dot(p),
            self.top - self.scale * self.axes[1].dot(p),
        )
    }

    fn list(&self, points: &[Vector3<f64>]) -> String {
        let points = points.iter().map(|p| {
            let (x, y) = self.at(p);
            format!("{x:.1},{y:.1}")
        });
        let mut points: Vec<String> = points.collect();
        points.dedup();
        points.join(" ")
    }
}

impl Canvas {
    /// The picture as a file.
    pub(super) fn svg(&self) -> String {
        let axes = camera();
        let all: Vec<Vector3<f64>> = self
            .layers
            .iter()
            .flatten()
            .flat_map(Shape::points)
            .collect();
        let range = |axis: &Vector3<f64>| {
            let along = all.iter().map(|p| axis.dot(p));
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
                (l.min(x), h.max(x))
            });
            if low <= high { (low, high) } else { (0.0, 0.0) }
        };
        let [(left, right), (low, high)] = [range(&axes[0]), range(&axes[1])];
        let header = LINE * self.text.len() as f64 + 8.0;
        let scale = ((WIDTH - 2.0 * MARGIN) / (right - left).max(1e-6))
            .min((HEIGHT - header - 2.0 * MARGIN) / (high - low).max(1e-6));
        let height = header + 2.0 * MARGIN + scale * (high - low);
        let middle = 0.5 * (left + right);
        let view = Projection {
            axes,
            scale,
            left: 0.5 * WIDTH - scale * middle,
            top: header + MARGIN + scale * high,
        };
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH:.0}\" height=\"{height:.0}\" \
             viewBox=\"0 0 {WIDTH:.0} {height:.0}\" font-family=\"sans-serif\" font-size=\"13\" \
             stroke-linecap=\"round\" stroke-linejoin=\"round\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
        );
        for layer in &self.layers {
            let depth = |shape: &Shape| {
                let points = shape.points();
                let sum: f64 = points.iter().map(|p| view.axes[2].dot(p)).sum();
                // A joint is in the middle of the links that meet there: it is drawn over them.
                let is_joint = matches!(shape, Shape::Dot { .. });
                (is_joint, sum / points.len().max(1) as f64)
            };
            let mut shapes: Vec<((bool, f64), &Shape)> =
                layer.iter().map(|s| (depth(s), s)).collect();
            shapes.sort_by(|(a, _), (b, _)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
            for (_, shape) in shapes {
                draw(shape, &view, &mut out);
            }
        }
        for (i, (text, colour)) in self.text.iter().enumerate() {
            let y = LINE * (i as f64 + 1.0);
            let text = escaped(text);
            let _ = writeln!(
                out,
                "<text x=\"10\" y=\"{y:.0}\" fill=\"{colour}\">{text}</text>"
            );
        }
        out.push_str("</svg>\n");
        out
    }
}

fn draw(shape: &Shape, view: &Projection, out: &mut String) {
    // Writing to a text cannot fail.
    let _ = match shape {
        Shape::Path { points, pen } => {
            let dash = match pen.dash {
                Dash::Solid => "",
                Dash::Dashed => " stroke-dasharray=\"5 4\"",
            };
            writeln!(
                out,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{:.1}\"{dash}/>",
                view.list(points),
                pen.colour,
                pen.width
            )
        }
        Shape::Area {
            points,
            colour,
            opacity,
        } => writeln!(
            out,
            "<polygon points=\"{}\" fill=\"{colour}\" fill-opacity=\"{opacity:.2}\" stroke=\"{colour}\"/>",
            view.list(points)
        ),
        Shape::Dot {
            at,
            radius,
            fill,
            edge,
        } => {
            let (x, y) = view.at(at);
            writeln!(
                out,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" fill=\"{fill}\" stroke=\"{edge}\" \
                 stroke-width=\"1.5\"/>"
            )
        }
        Shape::Arrow {
            from,
            to,
            colour,
            label,
        } => arrow(view.at(from), view.at(to), colour, label, out),
        Shape::Mass { at, radius: r } => {
            let (x, y) = view.at(at);
            writeln!(
                out,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r:.1}\" fill=\"#fff\" stroke=\"#000\"/>\
                 <path d=\"M{x:.1} {y:.1}v-{r:.1}a{r:.1} {r:.1} 0 0 1 {r:.1} {r:.1}z\
                 M{x:.1} {y:.1}v{r:.1}a{r:.1} {r:.1} 0 0 1 -{r:.1} -{r:.1}z\"/>"
            )
        }
    };
}

fn arrow(
    (x, y): (f64, f64),
    (tip_x, tip_y): (f64, f64),
    colour: &str,
    label: &str,
    out: &mut String,
) -> std::fmt::Result {
    let (dx, dy) = (tip_x - x, tip_y - y);
    let length = dx.hypot(dy);
    if length < 1.0 {
        return Ok(());
    }
    let (dx, dy) = (dx / length, dy / length);
    let head = 9.0_f64.min(length);
    let (neck_x, neck_y) = (tip_x - head * dx, tip_y - head * dy);
    let wing = 0.42 * head;
    write!(
        out,
        "<path d=\"M{x:.1} {y:.1}L{neck_x:.1} {neck_y:.1}\" stroke=\"{colour}\" stroke-width=\"2.5\"/>\
         <path d=\"M{tip_x:.1} {tip_y:.1}L{:.1} {:.1}L{:.1} {:.1}z\" fill=\"{colour}\"/>",
        neck_x - wing * dy,
        neck_y + wing * dx,
        neck_x + wing * dy,
        neck_y - wing * dx,
    )?;
    let label = escaped(label);
    // Beyond the tip, and on a white edge: what lies behind stays apart.
    let (anchor, beyond) = if dx < 0.0 {
        ("end", -5.0)
    } else {
        ("start", 5.0)
    };
    writeln!(
        out,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\" fill=\"{colour}\" font-size=\"11\" \
         stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\">{label}</text>",
        tip_x + beyond,
        tip_y + 3.0
    )
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(from: [f64; 3], to: [f64; 3]) -> Shape {
        Shape::Path {
            points: vec![from.into(), to.into()],
            pen: Pen::solid("#123456", 1.0),
        }
    }

    #[test]
    fn a_length_is_drawn_to_scale_and_what_is_nearer_comes_last() {
        let [right, up, near] = camera();
        for (a, b) in [(right, up), (up, near), (near, right)] {
            assert!(a.dot(&b).abs() < 1e-12);
        }
        assert!((right.cross(&up) - near).norm() < 1e-12);
        let far = line((-near).into(), (right - near).into());
        let close = line([0.0; 3], right.into());
        let canvas = Canvas {
            layers: vec![vec![close, far]],
            text: Vec::new(),
        };
        let svg = canvas.svg();
        // Both are as long as the picture is wide between its margins.
        assert!(svg.contains("points=\"26.0,"), "{svg}");
        assert_eq!(svg.matches("614.0,").count(), 2, "{svg}");
        assert_eq!(svg.matches("<polyline").count(), 2);
    }

    #[test]
    fn a_picture_of_nothing_and_names_with_signs_are_drawn() {
        let canvas = Canvas {
            layers: Vec::new(),
            text: vec![("a<b & c".to_owned(), "#000")],
        };
        let svg = canvas.svg();
        assert!(svg.contains("a&lt;b &amp; c"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
