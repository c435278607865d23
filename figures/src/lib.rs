//! Figures as data: series over two axes, shaded regions, coloured cells, reference slopes. A figure draws itself as SVG or
//! PDF and lists itself as CSV. [`section`] is what a plane cuts out of a body; numbers have the form that a page shows.

mod axis;
mod canvas;
mod cells;
mod draw;
mod figure;
mod heading;
mod indices;
mod legend;
mod marks;
mod non_normal;
mod palette;
mod pdf;
pub mod section;
mod series;
mod spectrum;
mod svg;
mod text;
mod window;

#[cfg(test)]
mod tests;

pub use axis::{Axis, Scale};
pub use cells::{Cells, Colors};
pub use figure::{Figure, Mark, Outline, Region, Series, Shade, Slope};
pub use indices::with_indices;
pub use non_normal::{Gmres, Level};
pub use spectrum::Spectrum;
pub use text::{format_real, quote};
