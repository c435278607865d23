//! The part of the complex plane that a figure of a spectrum shows.

use super::{Figure, Spectrum};

/// Bounds further than this many extents of the spectrum from it are cut at the edge of the figure.
const WINDOW: f64 = 0.6;

/// Corners of a field of values farther from zero than this are not shown beside pseudospectra. Unit: 1, as eigenvalues.
const FAR: f64 = 4.0;

impl Spectrum {
    /// Shows all eigenvalues, and bounds as far as they lie within a window around them.
    pub(super) fn window(&self, figure: &mut Figure) {
        let ends = |values: &[f64]| {
            let ends = (f64::INFINITY, f64::NEG_INFINITY);
            let wider = |(a, b): (f64, f64), v: &f64| (a.min(*v), b.max(*v));
            values.iter().fold(ends, wider)
        };
        let lines = self
            .levels
            .iter()
            .flat_map(|level| level.lines.iter().flatten());
        // a field of values that is much wider leaves the picture
        let near = |corner: &&[f64; 2]| {
            !self.levels.is_empty() && corner[0].abs().max(corner[1].abs()) < FAR
        };
        let corners = self.field.iter().flatten().filter(near);
        let (re, im): (Vec<f64>, Vec<f64>) = lines.chain(corners).map(|[x, y]| (*x, *y)).unzip();
        let re = [&self.re[..], &re].concat();
        let ((low, high), (down, up)) = (ends(&re), ends(&[&self.im[..], &im].concat()));
        let im = up.max(-down);
        let room = WINDOW * (high - low).max(im);
        let [real, re] =
            [self.real, self.complex.map(|(re, _)| re)].map(|i| i.unwrap_or((low, high)));
        let left = low.min(real.0.min(re.0).max(low - room));
        let right = high.max(real.1.max(re.1).min(high + room));
        let top = im.max(self.complex.map_or(im, |(_, bound)| bound.min(im + room)));
        let margin = 0.05 * (right - left);
        figure.x = figure.x.clone().range(left - margin, right + margin);
        figure.y = figure.y.clone().range(-top - margin, top + margin);
    }
}
