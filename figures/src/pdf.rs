//! A page as PDF: the same marks as in SVG, compressed, with the letters that it shows embedded, so that it looks the same everywhere.

mod letters;

use super::canvas::{Anchor, Ink, Label, Page, Quads};
use letters::Letters;
use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str, TextStr};
use plotters::style::{RGBAColor, RGBColor};
use std::collections::BTreeMap;

/// Level of zlib that is also its default.
const COMPRESSION: u8 = 6;
/// Distance of the ends of the two handles of a quarter of a circle from its ends, over the radius: `4(√2 − 1)/3`.
const HANDLE: f64 = 0.552_284_75;
const LETTERS: Name<'static> = Name(b"F");

/// Objects of the file.
const CATALOG: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const CONTENT: Ref = Ref::new(4);
const INFO: Ref = Ref::new(5);
const FONT: Ref = Ref::new(6);
/// The first of four that belong to the font, then of the opacities.
const OTHERS: i32 = 7;

/// Writes a page with a title and what a caption says.
///
/// # Errors
/// A font that cannot be read.
pub(super) fn write(page: &Page, title: &str, caption: &str) -> anyhow::Result<Vec<u8>> {
    let [width, height] = page.size;
    let mut sheet = Sheet {
        content: Content::new(),
        letters: Letters::new()?,
        opacities: BTreeMap::new(),
        opacity: 255,
    };
    // y runs downwards, as on the page
    sheet
        .content
        .transform([1.0, 0.0, 0.0, -1.0, 0.0, height as f32]);
    page.under.ink().iter().for_each(|ink| sheet.draw(ink));
    sheet.cells(&page.cells);
    page.over.ink().iter().for_each(|ink| sheet.draw(ink));

    let mut pdf = Pdf::new();
    pdf.catalog(CATALOG).pages(PAGES);
    pdf.pages(PAGES).kids([PAGE]).count(1);
    pdf.document_info(INFO)
        .title(TextStr(title))
        .subject(TextStr(caption));
    let opacities = (sheet.opacities.values())
        .map(|(place, opacity)| (format!("A{place}"), OTHERS + 4 + place, *opacity));
    let opacities: Vec<_> = opacities.collect();
    let mut described = pdf.page(PAGE);
    described
        .media_box(Rect::new(0.0, 0.0, width as f32, height as f32))
        .parent(PAGES)
        .contents(CONTENT);
    let mut resources = described.resources();
    resources.fonts().pair(LETTERS, FONT);
    let mut states = resources.ext_g_states();
    for (name, object, _) in &opacities {
        states.pair(Name(name.as_bytes()), Ref::new(*object));
    }
    states.finish();
    resources.finish();
    described.finish();
    for (_, object, opacity) in &opacities {
        pdf.ext_graphics(Ref::new(*object))
            .stroking_alpha(*opacity)
            .non_stroking_alpha(*opacity);
    }
    let content = compress_to_vec_zlib(&sheet.content.finish(), COMPRESSION);
    pdf.stream(CONTENT, &content).filter(Filter::FlateDecode);
    sheet.letters.write(&mut pdf, FONT, OTHERS)?;
    Ok(pdf.finish())
}

/// What a page draws, unpacked.
#[cfg(test)]
pub(super) fn drawn(pdf: &[u8]) -> String {
    // the first stream
    let after = |bytes: &[u8], word: &[u8]| {
        let at = bytes.windows(word.len()).position(|w| w == word);
        at.map_or(bytes.len(), |at| at + word.len())
    };
    let packed = &pdf[after(pdf, b"stream\n")..];
    let end = after(packed, b"\nendstream") - b"\nendstream".len();
    let bytes = miniz_oxide::inflate::decompress_to_vec_zlib(&packed[..end]);
    String::from_utf8_lossy(&bytes.unwrap_or_default()).into_owned()
}

#[cfg(test)]
pub(super) use letters::knows;

/// What is drawn, with the letters and the opacities that it takes.
struct Sheet {
    content: Content,
    letters: Letters,
    /// Place and opacity, by its share of 255.
    opacities: BTreeMap<u8, (i32, f32)>,
    /// That in force, of 255.
    opacity: u8,
}

/// A hundredth of a point is finer than any printer.
fn fine(length: f64) -> f32 {
    ((length * 100.0).round() / 100.0) as f32
}

fn unit(RGBColor(r, g, b): RGBColor) -> [f32; 3] {
    [r, g, b].map(|part| (f64::from(part) / 255.0 * 1e3).round() as f32 / 1e3)
}

impl Sheet {
    fn draw(&mut self, ink: &Ink) {
        match ink {
            // a file must not paint a path that is none
            Ink::Line(points, ..) | Ink::Fill(points, _) if points.len() < 2 => {}
            Ink::Line(points, color, width) => {
                self.stroke(*color, *width);
                self.path(points);
                self.content.stroke();
            }
            Ink::Fill(corners, color) => {
                self.fill(*color);
                self.path(corners);
                self.content.fill_nonzero();
            }
            Ink::Circle(center, radius, color, width) => {
                match width {
                    Some(width) => self.stroke(*color, *width),
                    None => self.fill(*color),
                }
                self.ring(*center, *radius);
                match width {
                    Some(_) => self.content.close_and_stroke(),
                    None => self.content.fill_nonzero(),
                };
            }
            Ink::Text(label) => self.text(label),
        }
    }

    fn solid(color: RGBColor) -> RGBAColor {
        RGBAColor(color.0, color.1, color.2, 1.0)
    }

    fn fill(&mut self, color: RGBAColor) {
        let [r, g, b] = unit(RGBColor(color.0, color.1, color.2));
        self.content.set_fill_rgb(r, g, b);
        self.show_through(color.3);
    }

    fn stroke(&mut self, color: RGBAColor, width: f64) {
        let [r, g, b] = unit(RGBColor(color.0, color.1, color.2));
        self.content.set_stroke_rgb(r, g, b);
        self.content.set_line_width(fine(width));
        self.show_through(color.3);
    }

    fn show_through(&mut self, opacity: f64) {
        let share = (opacity * 255.0).round() as u8;
        let next = self.opacities.len() as i32;
        let place = (self.opacities.entry(share)).or_insert((next, f32::from(share) / 255.0));
        if share != self.opacity {
            let name = format!("A{}", place.0);
            self.content.set_parameters(Name(name.as_bytes()));
            self.opacity = share;
        }
    }

    fn path(&mut self, points: &[[f64; 2]]) {
        for (k, [x, y]) in points.iter().map(|p| p.map(fine)).enumerate() {
            match k {
                0 => self.content.move_to(x, y),
                _ => self.content.line_to(x, y),
            };
        }
    }

    fn ring(&mut self, [x, y]: [f64; 2], r: f64) {
        let corner = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [1.0, 0.0]];
        let [x0, y0] = [x + r, y].map(fine);
        self.content.move_to(x0, y0);
        for pair in corner.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let at = |a: [f64; 2], b: [f64; 2]| {
                [
                    fine(x + r * (a[0] + HANDLE * b[0])),
                    fine(y + r * (a[1] + HANDLE * b[1])),
                ]
            };
            let ([x1, y1], [x2, y2], [x3, y3]) = (at(from, to), at(to, from), at(to, [0.0, 0.0]));
            self.content.cubic_to(x1, y1, x2, y2, x3, y3);
        }
    }

    fn cells(&mut self, cells: &Quads) {
        for ((r, g, b), quads) in &cells.of_color {
            self.fill(Self::solid(RGBColor(*r, *g, *b)));
            quads.iter().for_each(|quad| self.path(quad));
            self.content.fill_nonzero();
        }
    }

    fn text(&mut self, label: &Label) {
        let size = label.size;
        let (lines, width) = self.letters.set(&label.text, size);
        let (back, is_upwards) = match label.anchor {
            Anchor::Left => (0.0, false),
            Anchor::Center => (0.5 * width, false),
            Anchor::Right => (width, false),
            Anchor::Upwards => (0.5 * width, true),
            Anchor::UpwardsFrom => (0.0, true),
        };
        self.fill(Self::solid(label.color));
        self.content.begin_text();
        for line in &lines {
            // from the point along the line, and from it downwards
            let along = line.along - back;
            let down = 0.5 * self.letters.x_height() * size + line.drop;
            let matrix = match is_upwards {
                false => [1.0, 0.0, 0.0, -1.0, label.at[0] + along, label.at[1] + down],
                true => [
                    0.0,
                    -1.0,
                    -1.0,
                    0.0,
                    label.at[0] + down,
                    label.at[1] - along,
                ],
            };
            self.content
                .set_font(LETTERS, fine(line.size))
                .set_text_matrix(matrix.map(fine))
                .show(Str(&line.glyphs));
        }
        self.content.end_text();
    }
}
