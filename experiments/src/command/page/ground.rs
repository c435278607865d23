//! Something flat, a section or a fracture, with quantities on it at some steps.

use super::unit::Kind;
use crate::report::Panels;
use fracas::run::Stored;
use fracas_figures::section::{Direction, Patches};
use fracas_figures::{Axis, Cells, Colors, Figure, Mark, Outline, Series, format_real};

/// Differences over the largest value that are none, and values over the largest of the body. Unit: 1.
const EVEN: f64 = 1e-9;

/// The largest displacement [m] and stress [Pa] at the steps of a page: what is far smaller is rounding.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Scale {
    pub(super) length: f64,
    pub(super) stress: f64,
}

impl Scale {
    /// Takes in the fields of a step.
    pub(super) fn add(&mut self, stored: &Stored) {
        let most = |from: f64, of: &[f64]| of.iter().fold(from, |m: f64, v| m.max(v.abs()));
        self.length = most(self.length, &stored.displacement);
        self.stress = most(most(self.stress, &stored.stress), &stored.traction);
    }

    fn noise(self, kind: Kind) -> f64 {
        EVEN * match kind {
            Kind::Length => self.length,
            Kind::Stress => self.stress,
            Kind::Share | Kind::Volume | Kind::Rate => 0.0,
        }
    }
}

/// Share of values at either end that takes the colour of the end: a corner of stress does not take all colours. Unit: 1.
const ENDS: f64 = 0.005;

/// Sides, short over long, below which a map does not show lengths as they are. Unit: 1.
const LONG: f64 = 0.125;

/// A value on every piece, at every step.
pub(super) struct Quantity {
    pub(super) id: &'static str,
    pub(super) name: String,
    pub(super) kind: Kind,
    /// Per step, per piece; SI.
    pub(super) values: Vec<Vec<f64>>,
}

/// A step in words.
pub(super) struct Moment {
    pub(super) step: usize,
    /// `step 3, t = 0.75 s`.
    pub(super) title: String,
    pub(super) why: String,
}

/// What quantities are drawn on.
pub(super) struct Ground {
    /// In names of files.
    pub(super) id: String,
    /// `in the section y = 2 m`.
    pub(super) place: String,
    pub(super) directions: [Direction; 2],
    pub(super) patches: Patches,
    pub(super) outlines: Vec<Outline>,
    /// Short side over long, below which a curve along the long one shows more. Unit: 1.
    pub(super) narrow: f64,
}

impl Ground {
    fn axis(&self, d: usize) -> Axis {
        Axis::linear(&format!("{} [m]", self.directions[d].label))
    }

    fn sides(&self) -> [f64; 2] {
        let [a, b] = &self.directions;
        let [[left, right], [low, high]] = self.patches.extent();
        [a.stretch() * (right - left), b.stretch() * (high - low)]
    }

    /// An empty map.
    fn map(&self, id: &str, title: &str, caption: &str) -> Figure {
        let mut figure = Figure::new(id, title, caption, self.axis(0), self.axis(1));
        let [a, b] = self.sides();
        figure.equal_aspect = a.min(b) > LONG * a.max(b);
        let [across, up] = self.directions.each_ref().map(Direction::stretch);
        figure.stretch = up / across;
        figure.outlines.clone_from(&self.outlines);
        figure
    }

    /// Names as colours: a map of what does not change.
    pub(super) fn classes(
        &self,
        id: &str,
        title: &str,
        names: Vec<String>,
        of: Vec<f64>,
    ) -> Figure {
        let mut figure = self.map(&format!("{}_{id}", self.id), title, "");
        figure.cells = Some(Cells {
            label: String::new(),
            colors: Colors::Classes(names),
            quads: self.patches.quads.clone(),
            values: of,
            range: [0.0, 1.0],
        });
        figure
    }

    /// A row of small figures per quantity, or curves of all steps where the ground is narrow; and what is the same everywhere.
    pub(super) fn panels(
        &self,
        quantities: Vec<Quantity>,
        moments: &[Moment],
        scale: Scale,
    ) -> (Vec<Panels>, Vec<String>) {
        let (mut panels, mut notes) = (Vec::new(), Vec::new());
        let [a, b] = self.sides();
        let is_narrow = a.min(b) <= self.narrow * a.max(b);
        // several quantities in one row
        let mut beside = Panels::default();
        for quantity in quantities {
            let all = || quantity.values.iter().flatten().filter(|v| v.is_finite());
            let ends = all().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| {
                [a.min(*v), b.max(*v)]
            });
            let largest = ends[0].abs().max(ends[1].abs());
            if !largest.is_finite() || largest <= scale.noise(quantity.kind) {
                continue;
            }
            let (unit, factor) = quantity.kind.unit(largest);
            if ends[1] - ends[0] <= EVEN * largest {
                notes.push(format!(
                    "{} is {} {unit} everywhere {} at these steps.",
                    quantity.name,
                    format_real(factor * 0.5 * (ends[0] + ends[1])),
                    self.place
                ));
                continue;
            }
            let label = format!("{} [{unit}]", quantity.name);
            if is_narrow {
                (beside.figures).push(self.profile(&quantity, &label, factor, moments));
                continue;
            }
            let mut row = self.row(&quantity, &label, factor, moments);
            if let [figure] = &mut row.figures[..] {
                figure.title.clone_from(&quantity.name);
                figure.caption.clone_from(&moments[0].title);
                beside.figures.append(&mut row.figures);
            } else {
                panels.push(row);
            }
        }
        if !beside.figures.is_empty() {
            panels.push(beside);
        }
        (panels, notes)
    }

    fn row(&self, quantity: &Quantity, label: &str, factor: f64, moments: &[Moment]) -> Panels {
        let (range, colors) = range(quantity, factor);
        let figure = |(moment, values): (&Moment, &Vec<f64>)| {
            let id = format!("{}_{}_{}", self.id, quantity.id, moment.step);
            let mut figure = self.map(&id, &moment.title, &moment.why);
            figure.cells = Some(Cells {
                label: label.into(),
                colors: colors.clone(),
                quads: self.patches.quads.clone(),
                values: values.iter().map(|v| factor * v).collect(),
                range,
            });
            figure
        };
        Panels {
            title: String::new(),
            caption: format!("{} {}.", quantity.name, self.place),
            figures: moments.iter().zip(&quantity.values).map(figure).collect(),
        }
    }

    /// Along the longer side.
    fn profile(&self, quantity: &Quantity, label: &str, factor: f64, moments: &[Moment]) -> Figure {
        let [a, b] = self.sides();
        let long = usize::from(b > a);
        let id = format!("{}_{}", self.id, quantity.id);
        let mut figure = Figure::new(&id, "", "", self.axis(long), Axis::linear(label));
        for (moment, values) in moments.iter().zip(&quantity.values) {
            let middle = |quad: &[[f64; 2]; 4]| 0.25 * quad.iter().map(|p| p[long]).sum::<f64>();
            let mut points: Vec<[f64; 2]> = (self.patches.quads.iter().zip(values))
                .map(|(quad, value)| [middle(quad), factor * value])
                .collect();
            points.sort_by(|p, q| p[0].total_cmp(&q[0]));
            figure = figure.with(Series::new(&moment.title, Mark::LinePoints, points));
        }
        figure
    }
}

/// Ends of the bar and its colours, the same for all steps: those of both signs stand around 0.
fn range(quantity: &Quantity, factor: f64) -> ([f64; 2], Colors) {
    let mut all: Vec<f64> = quantity.values.iter().flatten().copied().collect();
    all.retain(|v| v.is_finite());
    all.sort_unstable_by(f64::total_cmp);
    let last = all.len().saturating_sub(1);
    let inner = (ENDS * last as f64) as usize;
    let mut ends = [factor * all[inner], factor * all[last - inner]];
    if ends[1] - ends[0] <= 0.02 * factor * (all[last] - all[0]) {
        // nearly everything is the same: what is not would have no colour of its own
        ends = [factor * all[0], factor * all[last]];
    }
    let [low, high] = ends;
    match low < 0.0 && high > 0.0 && low.abs().min(high) > 0.05 * low.abs().max(high) {
        true => {
            let most = low.abs().max(high);
            ([-most, most], Colors::Diverging)
        }
        false => ([low, high], Colors::Sequential),
    }
}
