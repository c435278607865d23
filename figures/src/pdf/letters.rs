//! Letters of DejaVu Sans, the first choice of our SVGs: widths, and a font of those that a page shows.

use super::COMPRESSION;
use crate::indices::{INDEX_DROP, INDEX_SIZE, runs};
use anyhow::Context;
use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::{CidFontType, FontFlags, SystemInfo, UnicodeCmap};
use pdf_writer::{Filter, Finish, Name, Pdf, Rect, Ref, Str};
use std::collections::BTreeMap;
use subsetter::{GlyphRemapper, subset};
use ttf_parser::Face;

/// A name of the form that embedded parts of fonts have.
const NAME: Name<'static> = Name(b"FRACAS+DejaVuSans");
const IDENTITY: SystemInfo<'static> = SystemInfo {
    registry: Str(b"Adobe"),
    ordering: Str(b"Identity"),
    supplement: 0,
};

/// Letters in a row, of one size.
pub(super) struct Line {
    /// Numbers in the embedded font, two bytes each.
    pub(super) glyphs: Vec<u8>,
    /// Where it begins, from the beginning of the text. Unit: points, as the next two.
    pub(super) along: f64,
    /// How far it lies below the line of the text.
    pub(super) drop: f64,
    pub(super) size: f64,
}

/// The letter that is drawn: the font has no script capitals, and the double-struck ones are no other symbols of ours.
fn drawn(letter: char) -> char {
    match letter {
        '𝒜' => '𝔸',
        other => other,
    }
}

/// A font, and which of its letters were used.
pub(super) struct Letters {
    face: Face<'static>,
    used: GlyphRemapper,
    /// Letter and width, by the number in the embedded font.
    shown: BTreeMap<u16, (char, f64)>,
}

impl Letters {
    /// # Errors
    /// A font that cannot be read.
    pub(super) fn new() -> anyhow::Result<Self> {
        Ok(Self {
            face: Face::parse(dejavu::sans::regular(), 0).context("the font of figures")?,
            used: GlyphRemapper::new(),
            shown: BTreeMap::new(),
        })
    }

    /// Height of an x over the size of the letters.
    pub(super) fn x_height(&self) -> f64 {
        // DejaVu Sans: 1120 of 2048
        self.em(self.face.x_height().unwrap_or(1120))
    }

    fn em(&self, units: impl Into<f64>) -> f64 {
        units.into() / f64::from(self.face.units_per_em())
    }

    /// A text with its indices, and its width in points.
    pub(super) fn set(&mut self, text: &str, size: f64) -> (Vec<Line>, f64) {
        let (mut lines, mut along) = (Vec::new(), 0.0);
        for (part, is_index) in runs(text) {
            let (size, drop) = match is_index {
                true => (INDEX_SIZE * size, INDEX_DROP * size),
                false => (size, 0.0),
            };
            let (mut glyphs, mut width) = (Vec::new(), 0.0);
            for letter in part.chars() {
                // glyph 0 is an empty box: the font has no such letter
                let glyph = self.face.glyph_index(drawn(letter)).unwrap_or_default();
                let wide = self.em(self.face.glyph_hor_advance(glyph).unwrap_or(0));
                let number = self.used.remap(glyph.0);
                self.shown.insert(number, (letter, wide));
                glyphs.extend(number.to_be_bytes());
                width += wide * size;
            }
            lines.push(Line {
                glyphs,
                along,
                drop,
                size,
            });
            along += width;
        }
        (lines, along)
    }

    /// The font `first` and the four objects from `others` on that it consists of.
    ///
    /// # Errors
    /// A font of which no part can be taken.
    pub(super) fn write(&self, pdf: &mut Pdf, first: Ref, others: i32) -> anyhow::Result<()> {
        let [described, details, data, meaning] = [0, 1, 2, 3].map(|k| Ref::new(others + k));
        let thousandths = |em: f64| (1e3 * em).round() as f32;
        pdf.type0_font(first)
            .base_font(NAME)
            .encoding_predefined(Name(b"Identity-H"))
            .descendant_font(described)
            .to_unicode(meaning);
        let mut font = pdf.cid_font(described);
        font.subtype(CidFontType::Type2)
            .base_font(NAME)
            .system_info(IDENTITY)
            .font_descriptor(details)
            .cid_to_gid_map_predefined(Name(b"Identity"));
        let mut widths = font.widths();
        for (number, (_, width)) in &self.shown {
            widths.consecutive(*number, [thousandths(*width)]);
        }
        widths.finish();
        font.finish();
        let area = self.face.global_bounding_box();
        let [left, low, right, high] = [area.x_min, area.y_min, area.x_max, area.y_max]
            .map(|units| thousandths(self.em(units)));
        // the height of capitals: DejaVu Sans, 1493 of 2048; stems: 0.09 of the size, as drawn
        let capitals = self.face.capital_height().unwrap_or(1493);
        pdf.font_descriptor(details)
            .name(NAME)
            .flags(FontFlags::SYMBOLIC)
            .bbox(Rect::new(left, low, right, high))
            .italic_angle(0.0)
            .ascent(thousandths(self.em(self.face.ascender())))
            .descent(thousandths(self.em(self.face.descender())))
            .cap_height(thousandths(self.em(capitals)))
            .stem_v(90.0)
            .font_file2(data);
        let part = subset(dejavu::sans::regular(), 0, &self.used)
            .map_err(|error| anyhow::anyhow!("the font of figures: {error}"))?;
        let packed = compress_to_vec_zlib(&part, COMPRESSION);
        let mut stream = pdf.stream(data, &packed);
        stream.filter(Filter::FlateDecode);
        stream.pair(Name(b"Length1"), part.len() as i32);
        stream.finish();
        let mut letters = UnicodeCmap::<u16>::new(Name(b"Letters"), IDENTITY);
        for (number, (letter, _)) in &self.shown {
            letters.pair(*number, *letter);
        }
        pdf.cmap(meaning, &letters.finish());
        Ok(())
    }
}

/// True where the font has this letter.
#[cfg(test)]
pub(crate) fn knows(letter: char) -> bool {
    Letters::new().is_ok_and(|letters| {
        letters
            .face
            .glyph_index(drawn(letter))
            .is_some_and(|glyph| glyph.0 > 0)
    })
}
