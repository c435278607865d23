//! What a figure shows.

use super::axis::Axis;
use super::cells::Cells;
use crate::text::quote;
use std::fmt::Write as _;

/// A figure: an SVG and a CSV file.
#[derive(Clone, Debug)]
pub struct Figure {
    /// File name without extension.
    pub id: String,
    /// Heading inside the figure; may be empty.
    pub title: String,
    /// A line below the title that whoever reads the figure has to know; may be empty.
    pub note: String,
    /// A sentence or two below the figure.
    pub caption: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Lengths are as they are in both directions (complex plane, map).
    pub equal_aspect: bool,
    /// Length of one unit of y over that of one of x, where lengths are as they are: heights in a plane that dips have more than 1.
    pub stretch: f64,
    /// Shaded regions, drawn first.
    pub shades: Vec<Shade>,
    /// Coloured cells, drawn behind the data.
    pub cells: Option<Cells>,
    /// Black lines over the cells: edges of a body, of its materials, fractures.
    pub outlines: Vec<Outline>,
    /// Data.
    pub series: Vec<Series>,
    /// Reference slopes of a log-log plot.
    pub slopes: Vec<Slope>,
}

impl Figure {
    /// An empty figure.
    pub fn new(id: &str, title: &str, caption: &str, x: Axis, y: Axis) -> Self {
        Self {
            id: id.into(),
            title: title.into(),
            note: String::new(),
            caption: caption.into(),
            x,
            y,
            equal_aspect: false,
            stretch: 1.0,
            shades: Vec::new(),
            cells: None,
            outlines: Vec::new(),
            series: Vec::new(),
            slopes: Vec::new(),
        }
    }

    /// Adds a series.
    #[must_use]
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Adds a shaded region.
    #[must_use]
    pub fn shade(mut self, name: &str, region: Region) -> Self {
        self.shades.push(Shade {
            name: name.into(),
            region,
        });
        self
    }

    /// Adds a reference slope `y ∝ x^order` through a point.
    #[must_use]
    pub fn slope(mut self, order: f64, through: [f64; 2]) -> Self {
        self.slopes.push(Slope { order, through });
        self
    }

    /// Everything drawn, a line per point: `layer,kind,x,y`; a cell is a line at its centre whose layer is its value.
    pub fn to_csv(&self) -> String {
        let mut text = format!(
            "layer,kind,{},{}\n",
            quote(&self.x.label),
            quote(&self.y.label)
        );
        let mut line = |name: &str, kind: &str, x: f64, y: f64| {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{},{kind},{x},{y}", quote(name));
        };
        for shade in &self.shades {
            let (kind, corners) = shade.region.outline();
            corners
                .iter()
                .for_each(|c| line(&shade.name, kind, c[0], c[1]));
        }
        if let Some(cells) = &self.cells {
            for (quad, value) in cells.quads.iter().zip(&cells.values) {
                let [x, y] = Cells::center(quad);
                line(&value.to_string(), "cell", x, y);
            }
        }
        for outline in &self.outlines {
            (outline.points.iter()).for_each(|p| line("", "outline", p[0], p[1]));
        }
        for series in &self.series {
            series
                .points
                .iter()
                .for_each(|p| line(&series.name, series.mark.word(), p[0], p[1]));
        }
        for slope in &self.slopes {
            line(
                &format!("slope {}", slope.order),
                "slope",
                slope.through[0],
                slope.through[1],
            );
        }
        text
    }
}

/// A black line that belongs to no series.
#[derive(Clone, Debug)]
pub struct Outline {
    /// Points.
    pub points: Vec<[f64; 2]>,
    /// Its width in points.
    pub width: f64,
}

/// Points with one style.
#[derive(Clone, Debug)]
pub struct Series {
    /// In the legend; empty for none.
    pub name: String,
    /// Data.
    pub points: Vec<[f64; 2]>,
    /// How they are drawn.
    pub mark: Mark,
    /// Place in the palette; by default the place in the figure.
    pub tone: Option<usize>,
}

impl Series {
    /// A series.
    pub fn new(name: &str, mark: Mark, points: Vec<[f64; 2]>) -> Self {
        Self {
            name: name.into(),
            points,
            mark,
            tone: None,
        }
    }

    /// With a colour and marker shared with another series.
    #[must_use]
    pub fn tone(mut self, tone: usize) -> Self {
        self.tone = Some(tone);
        self
    }
}

/// How points are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A line.
    Line,
    /// A dashed line.
    Dashed,
    /// Markers.
    Points,
    /// A line with markers.
    LinePoints,
    /// Vertical bars from the lower end of the axis.
    Bars,
}

impl Mark {
    const fn word(self) -> &'static str {
        match self {
            Self::Line => "line",
            Self::Dashed => "dashed",
            Self::Points => "points",
            Self::LinePoints => "line+points",
            Self::Bars => "bars",
        }
    }
}

/// A region with a name in the legend.
#[derive(Clone, Debug)]
pub struct Shade {
    /// In the legend.
    pub name: String,
    /// Its shape.
    pub region: Region,
}

/// A part of the plane.
#[derive(Clone, Debug)]
pub enum Region {
    /// A rectangle.
    Rectangle {
        /// Lower and upper end in x.
        x: [f64; 2],
        /// Lower and upper end in y.
        y: [f64; 2],
    },
    /// An interval on the real axis.
    RealInterval([f64; 2]),
    /// A disc.
    Disc {
        /// Centre.
        center: [f64; 2],
        /// Radius.
        radius: f64,
    },
    /// A convex set by its boundary (field of values).
    Polygon(Vec<[f64; 2]>),
}

impl Region {
    /// Kind and corner points; a disc gives its bounding square.
    pub(super) fn outline(&self) -> (&'static str, Vec<[f64; 2]>) {
        match self {
            Self::Rectangle { x, y } => (
                "rectangle",
                vec![[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]],
            ),
            Self::RealInterval([a, b]) => ("interval", vec![[*a, 0.0], [*b, 0.0]]),
            Self::Disc {
                center: [x, y],
                radius: r,
            } => (
                "disc",
                vec![
                    [x - r, y - r],
                    [x + r, y - r],
                    [x + r, y + r],
                    [x - r, y + r],
                ],
            ),
            Self::Polygon(corners) => ("polygon", corners.clone()),
        }
    }
}

/// `y ∝ x^order`, drawn as a dashed line through a point.
#[derive(Clone, Copy, Debug)]
pub struct Slope {
    /// Exponent.
    pub order: f64,
    /// A point on the line.
    pub through: [f64; 2],
}
