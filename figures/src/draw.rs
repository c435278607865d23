//! From a figure to a page.

use super::axis::{Scale, Tick};
use super::canvas::{Anchor, Canvas, Page, fitting_size, text_width};
use super::figure::{Figure, Mark, Region, Series};
use super::legend::Legend;
use super::{palette, pdf, svg};
use plotters::style::{BLACK, Color, RGBColor};

/// Page width, in points: a column and a half of a journal.
const WIDTH: f64 = 560.0;
/// Width for one of two columns, in points: letters keep their size beside those of the text.
const COLUMN: f64 = 280.0;
/// Width for one of four side by side, in points.
const PANEL: f64 = 318.0;
/// Space that a labelled tick of the horizontal axis takes, in points.
const TICK_SPACE: f64 = 60.0;
const TICK_SIZE: f64 = 10.0;
const LABEL_SIZE: f64 = 11.0;
/// Longest name that stands upright below a horizontal axis, in points; longer ones have smaller letters.
const LONGEST_NAME: f64 = 150.0;
const GRID: RGBColor = RGBColor(226, 226, 226);

/// The plot box on the page and the linearized ends of its axes.
pub(super) struct Frame<'a> {
    pub(super) figure: &'a Figure,
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) x: [f64; 2],
    pub(super) y: [f64; 2],
    /// Space for names below the horizontal axis that stand upright, in points; 0 where they lie beside each other.
    upright: f64,
}

impl Figure {
    /// The figure as SVG: no fonts, scripts or links inside.
    ///
    /// # Errors
    /// plotters' error; writing into memory gives none.
    pub fn to_svg(&self) -> anyhow::Result<String> {
        self.to_svg_of(WIDTH)
    }

    /// The same for one of two columns.
    ///
    /// # Errors
    /// As [`Figure::to_svg`].
    pub fn to_column_svg(&self) -> anyhow::Result<String> {
        self.to_svg_of(COLUMN)
    }

    /// The same for one of several side by side: four to a page of 1,400 pixels, two on paper.
    ///
    /// # Errors
    /// As [`Figure::to_svg`].
    pub fn to_panel_svg(&self) -> anyhow::Result<String> {
        self.to_svg_of(PANEL)
    }

    fn to_svg_of(&self, width: f64) -> anyhow::Result<String> {
        Ok(self.described(&svg::write(&self.page(width))?))
    }

    /// The figure as a PDF of one page, the letters that it shows embedded.
    ///
    /// # Errors
    /// A font that cannot be read; the one that is part of the program can.
    pub fn to_pdf(&self) -> anyhow::Result<Vec<u8>> {
        pdf::write(&self.page(WIDTH), &self.shown_title(), &self.caption)
    }

    /// The same for one of several side by side.
    ///
    /// # Errors
    /// As [`Figure::to_pdf`].
    pub fn to_panel_pdf(&self) -> anyhow::Result<Vec<u8>> {
        pdf::write(&self.page(PANEL), &self.shown_title(), &self.caption)
    }

    fn page(&self, page_width: f64) -> Page {
        let hidden: Vec<usize> = self.series.iter().map(|s| self.hidden(s)).collect();
        let (mut x, mut y) = self.ranges();
        let y_names = matches!(&self.y.scale, Scale::Categories(_));
        let widest = self
            .y
            .ticks(y, MOST_TICKS)
            .iter()
            .filter_map(|t| t.label.as_deref())
            .map(|l| text_width(l, TICK_SIZE))
            .fold(0.0, f64::max);
        let left =
            12.0 + if self.y.label.is_empty() {
                0.0
            } else {
                LABEL_SIZE + 8.0
            } + widest
                + 8.0;
        // numbers of a low bar are fewer: there is room for all of them
        let tall = 0.62 * (page_width - left);
        let bar = (self.cells.as_ref()).map_or(0.0, |cells| cells.bar_space(tall));
        let width = page_width - left - 18.0 - bar;
        let mut height = match &self.y.scale {
            Scale::Categories(names) => 34.0 * names.len().max(2) as f64,
            _ => 0.62 * width,
        };
        if self.equal_aspect {
            // The box follows the data, within limits; beyond them the shorter range is widened.
            let natural = width * self.stretch * (y[1] - y[0]) / (x[1] - x[0]);
            let tallest = if self.cells.is_some() { 1.0 } else { 0.85 };
            height = natural.clamp(0.30 * width, tallest * width);
            widen(&mut y, (x[1] - x[0]) * height / (self.stretch * width));
            widen(&mut x, (y[1] - y[0]) * self.stretch * width / height);
        }
        let top = self.heading_height();
        let frame = Frame {
            figure: self,
            left,
            top,
            width,
            height,
            x,
            y,
            upright: self.upright(width / (x[1] - x[0])),
        };
        let legend = Legend::new(self, &hidden, page_width - 30.0);
        let below = 43.0 + frame.upright;
        let page = top + height + below + legend.height() + 8.0;
        let (size, cells) = ([page_width, page], frame.cells());
        let (under, over) = (Canvas::default(), Canvas::default());
        frame.grid(&under, y_names);
        frame.bar(&over);
        frame.regions(&over);
        frame.outlines(&over);
        frame.slopes(&over);
        frame.all_series(&over);
        frame.border(&over);
        self.draw_heading(&over, left + 0.5 * width, page_width);
        legend.draw(&over, 0.5 * page_width, top + height + below);
        Page {
            size,
            under,
            cells,
            over,
        }
    }

    /// Space for the names along x where two of them would overlap, `step` apart.
    fn upright(&self, step: f64) -> f64 {
        let Scale::Categories(names) = &self.x.scale else {
            return 0.0;
        };
        let width = |name: &String| text_width(name, TICK_SIZE);
        let widths: Vec<f64> = names.iter().map(width).collect();
        let overlaps = |pair: &[f64]| 0.5 * (pair[0] + pair[1]) + 4.0 > step;
        match widths.windows(2).any(overlaps) {
            true => widths
                .iter()
                .fold(0.0, |a: f64, b| a.max(*b))
                .min(LONGEST_NAME),
            false => 0.0,
        }
    }

    /// The title, or what stands for one.
    fn shown_title(&self) -> String {
        match (self.title.is_empty(), self.y.label.is_empty()) {
            (false, _) => self.title.clone(),
            (true, false) => format!("{} over {}", self.y.label, self.x.label),
            (true, true) => self.id.clone(),
        }
    }

    /// The page with title and description, for those who do not see it.
    fn described(&self, svg: &str) -> String {
        let escaped =
            |text: &str| (text.replace('&', "&amp;").replace('<', "&lt;")).replace('>', "&gt;");
        let title = self.shown_title();
        let described = format!(
            "><title>{}</title><desc>{}</desc>",
            escaped(&title),
            escaped(&self.caption)
        );
        // the end of the opening tag
        svg.replacen('>', &described, 1)
            .replacen("<svg ", "<svg role=\"img\" ", 1)
    }

    /// Points that no axis can show; lines run to the edge instead.
    fn hidden(&self, series: &Series) -> usize {
        match series.mark {
            Mark::Line | Mark::Dashed => 0,
            _ => series
                .points
                .iter()
                .filter(|p| self.place(**p).is_none())
                .count(),
        }
    }

    /// A point in linearized coordinates; `None` when an axis cannot show it.
    pub(super) fn place(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        Some([self.x.linearize(x)?, self.y.linearize(y)?])
    }

    /// Linearized ends of both axes.
    fn ranges(&self) -> ([f64; 2], [f64; 2]) {
        let shown = |p: &&[f64; 2]| self.place(**p).is_some();
        let mut corners: Vec<[f64; 2]> = self
            .series
            .iter()
            .flat_map(|s| s.points.iter().filter(shown))
            .copied()
            .collect();
        corners.extend(self.shades.iter().flat_map(|s| s.region.outline().1));
        corners.extend(self.slopes.iter().map(|s| s.through));
        corners.extend(self.cells.iter().flat_map(|c| c.quads.iter().flatten()));
        corners.extend(self.outlines.iter().flat_map(|o| &o.points));
        let x = self.x.fit(corners.iter().map(|p| p[0]));
        let mut y = self.y.fit(corners.iter().map(|p| p[1]));
        let bars = self.series.iter().any(|s| s.mark == Mark::Bars);
        if bars && self.y.scale == Scale::Linear && self.y.range.is_none() {
            y = [0.0_f64.min(y[0].min(0.0)), y[1]];
        }
        if bars && self.y.scale == Scale::Log && self.y.range.is_none() {
            // The shortest bar keeps a visible height.
            y[0] -= 0.12 * (y[1] - y[0]);
        }
        (x, y)
    }
}

/// Labelled ticks of a vertical axis.
const MOST_TICKS: usize = 7;

/// Ticks for which a vertical axis of this height has room, in points.
pub(super) fn tick_count(height: f64) -> usize {
    ((height / 15.0) as usize).clamp(2, MOST_TICKS)
}

/// Widens a range symmetrically to at least `length`.
fn widen(range: &mut [f64; 2], length: f64) {
    let missing = 0.5 * (length - (range[1] - range[0])).max(0.0);
    range[0] -= missing;
    range[1] += missing;
}

impl Frame<'_> {
    /// Page position of linearized coordinates.
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let u = (x - self.x[0]) / (self.x[1] - self.x[0]);
        let v = (y - self.y[0]) / (self.y[1] - self.y[0]);
        [
            self.left + u * self.width,
            self.top + (1.0 - v) * self.height,
        ]
    }

    pub(super) fn inside(&self, [x, y]: [f64; 2]) -> bool {
        let slack = |r: [f64; 2]| 1e-9 * (r[1] - r[0]);
        (self.x[0] - slack(self.x)..=self.x[1] + slack(self.x)).contains(&x)
            && (self.y[0] - slack(self.y)..=self.y[1] + slack(self.y)).contains(&y)
    }

    fn grid(&self, canvas: &Canvas, y_names: bool) {
        let (left, right, top, bottom) = (
            self.left,
            self.left + self.width,
            self.top,
            self.top + self.height,
        );
        let most = (self.width / TICK_SPACE).round() as usize;
        let x_names = matches!(self.figure.x.scale, Scale::Categories(_));
        // a number ends before the next one begins; names are as many as there are
        let beside = |ticks: &[Tick]| {
            let labelled = ticks.iter().filter_map(|t| Some((t.at, t.label.as_ref()?)));
            let ends = labelled.map(|(at, label)| {
                let half = 0.5 * text_width(label, TICK_SIZE);
                let at = self.at([at, self.y[0]])[0];
                [at - half, at + half]
            });
            let ends: Vec<[f64; 2]> = ends.collect();
            x_names || ends.windows(2).all(|pair| pair[0][1] + 3.0 < pair[1][0])
        };
        let x_ticks = (self.figure.x).ticks_of_three(self.x, most.clamp(2, 8), beside);
        let y_ticks = (self.figure.y).ticks_of_three(self.y, tick_count(self.height), |_| true);
        let major = |t: &&Tick| t.label.is_some();
        for tick in x_ticks.iter().filter(major).filter(|_| !x_names) {
            let x = self.at([tick.at, self.y[0]])[0];
            canvas.line(&[[x, top], [x, bottom]], GRID.mix(1.0), 0.6);
        }
        for tick in y_ticks.iter().filter(major) {
            let y = self.at([self.x[0], tick.at])[1];
            canvas.line(
                &[[left, y], [right, y]],
                GRID.mix(if y_names { 0.7 } else { 1.0 }),
                0.6,
            );
        }
        for tick in &x_ticks {
            let x = self.at([tick.at, self.y[0]])[0];
            let length = if tick.label.is_some() { 5.0 } else { 3.0 };
            canvas.line(&[[x, bottom], [x, bottom + length]], BLACK.mix(1.0), 0.8);
            match &tick.label {
                Some(name) if self.upright > 0.0 => {
                    let size = fitting_size(name, TICK_SIZE, self.upright);
                    let foot = bottom + 8.0 + text_width(name, size);
                    canvas.text([x, foot], name, size, Anchor::UpwardsFrom);
                }
                Some(label) => {
                    canvas.text([x, bottom + 14.0], label, TICK_SIZE, Anchor::Center);
                }
                None => {}
            }
        }
        for tick in &y_ticks {
            let y = self.at([self.x[0], tick.at])[1];
            let length = if tick.label.is_some() { 5.0 } else { 3.0 };
            canvas.line(&[[left - length, y], [left, y]], BLACK.mix(1.0), 0.8);
            if let Some(label) = &tick.label {
                canvas.text([left - 8.0, y], label, TICK_SIZE, Anchor::Right);
            }
        }
        canvas.text(
            [0.5 * (left + right), bottom + 32.0 + self.upright],
            &self.figure.x.label,
            LABEL_SIZE,
            Anchor::Center,
        );
        canvas.text(
            [14.0, 0.5 * (top + bottom)],
            &self.figure.y.label,
            LABEL_SIZE,
            Anchor::Upwards,
        )
    }

    fn border(&self, canvas: &Canvas) {
        let (l, r, t, b) = (
            self.left,
            self.left + self.width,
            self.top,
            self.top + self.height,
        );
        canvas.line(
            &[[l, t], [r, t], [r, b], [l, b], [l, t]],
            BLACK.mix(1.0),
            0.8,
        )
    }

    fn regions(&self, canvas: &Canvas) {
        for (k, shade) in self.figure.shades.iter().enumerate() {
            let color = palette::shade(k);
            let mut corners = match &shade.region {
                Region::Disc {
                    center: [x, y],
                    radius,
                } => (0..180)
                    .map(|i| f64::from(i) * std::f64::consts::TAU / 180.0)
                    .map(|a| [x + radius * a.cos(), y + radius * a.sin()])
                    .collect(),
                other => other.outline().1,
            };
            corners.retain(|c| self.figure.place(*c).is_some());
            let mut page: Vec<[f64; 2]> = corners
                .iter()
                .filter_map(|c| self.figure.place(*c))
                .map(|c| self.at(self.clamped(c)))
                .collect();
            if let (Region::RealInterval(_), [a, b]) = (&shade.region, &page[..]) {
                let h = 5.0;
                canvas.fill(
                    &[
                        [a[0], a[1] - h],
                        [b[0], b[1] - h],
                        [b[0], b[1] + h],
                        [a[0], a[1] + h],
                    ],
                    color.mix(0.5),
                );
                continue;
            }
            if page.len() > 2 {
                canvas.fill(&page, color.mix(0.22));
                page.push(page[0]);
                canvas.line(&page, color.mix(1.0), 0.8);
            }
        }
    }

    /// Lines of a section: bodies, materials, fractures.
    fn outlines(&self, canvas: &Canvas) {
        for outline in &self.figure.outlines {
            let shown = outline.points.iter();
            let shown = shown.filter_map(|p| self.figure.place(*p));
            let page: Vec<[f64; 2]> = shown.map(|p| self.at(self.clamped(p))).collect();
            canvas.line(&page, BLACK.mix(1.0), outline.width);
        }
    }

    pub(super) fn clamped(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [x.clamp(self.x[0], self.x[1]), y.clamp(self.y[0], self.y[1])]
    }

    /// `log y = log y0 + order (log x − log x0)`, as far as the box reaches.
    fn slopes(&self, canvas: &Canvas) {
        for slope in &self.figure.slopes {
            let Some([x0, y0]) = self.figure.place(slope.through) else {
                continue;
            };
            let y = |x: f64| y0 + slope.order * (x - x0);
            let steps = 200;
            let points: Vec<[f64; 2]> = (0..=steps)
                .map(|i| self.x[0] + (self.x[1] - self.x[0]) * f64::from(i) / f64::from(steps))
                .map(|x| [x, y(x)])
                .filter(|p| self.inside(*p))
                .collect();
            let (Some(first), Some(last)) = (points.first(), points.last()) else {
                continue;
            };
            let gray = RGBColor(110, 110, 110);
            canvas.dashed(&[self.at(*first), self.at(*last)], gray.mix(1.0), 1.0);
            // The label stands beside the line, an eighth of the way along.
            let ([x0, y0], [x1, y1]) = (self.at(*first), self.at(*last));
            let (dx, dy, length) = (x1 - x0, y1 - y0, (x1 - x0).hypot(y1 - y0).max(1.0));
            let label = format!("slope {}", slope.order);
            let away = 8.0 + 0.5 * text_width(&label, TICK_SIZE) * (dy / length).abs();
            let at = [
                x0 + 0.125 * dx + away * dy / length,
                y0 + 0.125 * dy - away * dx / length,
            ];
            canvas.colored_text(at, &label, TICK_SIZE, Anchor::Center, gray);
        }
    }
}
