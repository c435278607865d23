use super::*;
use fracas_operators::random::Random;
use miniz_oxide::deflate::compress_to_vec_zlib;

const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

fn letters(bytes: &[u8]) -> String {
    let group = |own: &[u8]| -> String {
        let word = (0..3).fold(0u32, |w, k| w << 8 | u32::from(*own.get(k).unwrap_or(&0)));
        let letter = |k: usize| match k <= own.len() {
            true => LETTERS[(word >> (18 - 6 * k) & 63) as usize] as char,
            false => '=',
        };
        (0..4).map(letter).collect()
    };
    bytes.chunks(3).map(group).collect()
}

/// How a program writes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Style {
    /// `ascii`, `binary`, `base64` or `raw`.
    pub(super) format: &'static str,
    is_big_endian: bool,
    is_long: bool,
    is_single: bool,
    /// The length of an array is encoded apart from it.
    is_apart: bool,
    /// Bytes of a block that zlib compresses.
    pub(super) block: Option<usize>,
}

struct Writer {
    style: Style,
    appended: Vec<u8>,
}

impl Writer {
    fn word(&self, bytes: &[u8]) -> Vec<u8> {
        let mut bytes = bytes.to_vec();
        if self.style.is_big_endian {
            bytes.reverse();
        }
        bytes
    }

    fn array(&mut self, name: &str, kind: &str, components: usize, numbers: &[f64]) -> String {
        let of = |v: &f64| match kind {
            "Float32" => self.word(&(*v as f32).to_le_bytes()),
            "Float64" => self.word(&v.to_le_bytes()),
            "Int32" => self.word(&(*v as i32).to_le_bytes()),
            _ => self.word(&(*v as i64).to_le_bytes()),
        };
        let data: Vec<u8> = numbers.iter().flat_map(of).collect();
        let (words, data) = match self.style.block {
            None => (vec![data.len()], data),
            Some(size) => packed(&data, size),
        };
        let word = |n: &usize| match self.style.is_long {
            true => self.word(&(*n as u64).to_le_bytes()),
            false => self.word(&(*n as u32).to_le_bytes()),
        };
        let header: Vec<u8> = words.iter().flat_map(word).collect();
        let encoded = match self.style.is_apart {
            true => letters(&header) + &letters(&data),
            false => letters(&[header.clone(), data.clone()].concat()),
        };
        let tag = format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\""
        );
        let offset = self.appended.len();
        match self.style.format {
            "ascii" => {
                let words: Vec<String> = numbers.iter().map(f64::to_string).collect();
                format!(
                    "{tag} format=\"ascii\">\n {}\n</DataArray>\n",
                    words.join(" ")
                )
            }
            "binary" => format!("{tag} format=\"binary\">\n  {encoded}\n</DataArray>\n"),
            format => {
                match format {
                    "raw" => self.appended.extend([header, data].concat()),
                    _ => self.appended.extend(encoded.bytes()),
                }
                format!(
                    "{tag} format=\"appended\" offset=\"{offset}\"><InformationKey name=\"a\"/></DataArray>\n"
                )
            }
        }
    }
}

/// The header of blocks of such a size, and the blocks.
fn packed(data: &[u8], size: usize) -> (Vec<usize>, Vec<u8>) {
    let blocks = data.chunks(size).map(|own| compress_to_vec_zlib(own, 6));
    let blocks: Vec<Vec<u8>> = blocks.collect();
    // 0 says that the last one is whole
    let mut words = vec![blocks.len(), size, data.len() % size];
    words.extend(blocks.iter().map(Vec::len));
    (words, blocks.concat())
}

/// Tetrahedra and hexahedra in pieces, with numbers of cells and of points.
pub(super) struct Example {
    points: Vec<[f64; 3]>,
    cells: Vec<Vec<usize>>,
    of_points: Vec<f64>,
    of_cells: Vec<f64>,
}

pub(super) fn example(r: &mut Random) -> Example {
    // halves, which 32 bits hold
    let mut half = |low: f64, high: f64| (2.0 * r.between(low, high)).round() / 2.0;
    let n = 9;
    Example {
        points: (0..n)
            .map(|_| std::array::from_fn(|_| half(-500.0, 500.0)))
            .collect(),
        cells: vec![
            vec![0, 1, 2, 3],
            vec![1, 2, 3, 4, 5, 6, 7, 8],
            vec![8, 2, 5, 0],
        ],
        of_points: (0..n).map(|_| half(0.0, 300.0)).collect(),
        of_cells: (0..3).map(|_| half(0.0, 300.0)).collect(),
    }
}

pub(super) fn written(example: &[Example], style: Style) -> Vec<u8> {
    let mut writer = Writer {
        style,
        appended: Vec::new(),
    };
    let float = if style.is_single {
        "Float32"
    } else {
        "Float64"
    };
    let whole = if style.is_single { "Int32" } else { "Int64" };
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<!-- a -- > b -->\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{}\"{}{}>\n<UnstructuredGrid>\n\
         <FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" format=\"ascii\">1</DataArray></FieldData>\n",
        if style.is_big_endian {
            "BigEndian"
        } else {
            "LittleEndian"
        },
        if style.is_long {
            " header_type=\"UInt64\""
        } else {
            ""
        },
        match style.block {
            Some(_) => " compressor=\"vtkZLibDataCompressor\"",
            None => "",
        }
    );
    for piece in example {
        let corners: Vec<f64> = piece.cells.iter().flatten().map(|a| *a as f64).collect();
        let ends = piece.cells.iter().scan(0, |end, cell| {
            *end += cell.len();
            Some(*end as f64)
        });
        text += &format!(
            "<Piece NumberOfPoints='{}' NumberOfCells='{}'>\n<PointData>{}</PointData>\n<CellData>{}</CellData>\n<Points>{}</Points>\n<Cells>{}{}</Cells>\n</Piece>\n",
            piece.points.len(),
            piece.cells.len(),
            writer.array("p &amp; q", float, 1, &piece.of_points),
            writer.array("pressure", float, 1, &piece.of_cells),
            writer.array("Points", float, 3, piece.points.as_flattened()),
            writer.array("connectivity", whole, 1, &corners),
            writer.array("offsets", whole, 1, &ends.collect::<Vec<_>>()),
        );
    }
    text += "</UnstructuredGrid>\n";
    let mut bytes = text.into_bytes();
    if ["raw", "base64"].contains(&style.format) {
        bytes.extend(format!("<AppendedData encoding=\"{}\">\n  _", style.format).bytes());
        bytes.extend(writer.appended);
        bytes.extend(b"\n</AppendedData>\n");
    }
    bytes.extend(b"</VTKFile>\n");
    bytes
}

pub(super) fn styles() -> Vec<Style> {
    let mut all = Vec::new();
    for format in ["ascii", "binary", "base64", "raw"] {
        for bits in 0..16 {
            all.push(Style {
                format,
                is_big_endian: bits & 1 > 0,
                is_long: bits & 2 > 0,
                is_single: bits & 4 > 0,
                is_apart: bits & 8 > 0,
                block: None,
            });
        }
    }
    for n in 16..all.len() {
        // one block, and several with a whole one at the end or a part
        let block = Some([64, 24, 1000][n % 3]);
        all.push(Style { block, ..all[n] });
    }
    all
}

#[test]
fn files_are_read_however_they_are_written() {
    for (seed, style) in styles().into_iter().enumerate() {
        let r = &mut Random::new(seed as u64);
        let pieces = [example(r), example(r)];
        let bytes = written(&pieces, style);
        let cells = read(&bytes, "a.vtu", "pressure").unwrap();
        let expected = pieces.iter().flat_map(|p| &p.of_cells);
        assert!(cells.pressures[0].iter().eq(expected), "{style:?}");
        let centers = pieces.iter().flat_map(|piece| {
            piece.cells.iter().map(|cell| {
                let sum = |d: usize| cell.iter().map(|a| piece.points[*a][d]).sum::<f64>();
                [0, 1, 2].map(|d| sum(d) / cell.len() as f64)
            })
        });
        assert!(centers.eq(cells.points), "{style:?}");
        let points = read(&bytes, "a.vtu", "p & q").unwrap();
        assert!(pieces.iter().flat_map(|p| &p.points).eq(&points.points));
        assert!(
            pieces
                .iter()
                .flat_map(|p| &p.of_points)
                .eq(&points.pressures[0])
        );
        assert!(cells.cells.is_some_and(|size| size > 0.0 && size < 1800.0));
    }
}

#[test]
fn no_cut_file_is_taken_for_a_whole_one() {
    for style in styles().into_iter().step_by(5) {
        let bytes = written(&[example(&mut Random::new(7))], style);
        let whole = read(&bytes, "a.vtu", "pressure").unwrap();
        for end in 0..bytes.len() {
            // what is left out may be the end, or an array that nobody asks for
            if let Ok(cut) = read(&bytes[..end], "a.vtu", "pressure") {
                assert_eq!(cut.pressures, whole.pressures, "{style:?}, {end}");
                assert_eq!(cut.points, whole.points, "{style:?}, {end}");
            }
        }
    }
}

#[test]
fn what_cannot_be_read_is_said() {
    let style = Style {
        format: "ascii",
        is_big_endian: false,
        is_long: false,
        is_single: false,
        is_apart: false,
        block: None,
    };
    let text = String::from_utf8(written(&[example(&mut Random::new(3))], style)).unwrap();
    for (from, to, array, expected) in [
        (
            "UnstructuredGrid\"",
            "ImageData\"",
            "pressure",
            "is of the type ImageData",
        ),
        ("VTKFile", "Other", "pressure", "begins with <Other>"),
        (
            "",
            "",
            "pore",
            "a.vtu has no array `pore` of cells or points; it has: p & q, pressure",
        ),
        (
            "Name=\"p &amp; q\"",
            "Name=\"pressure\"",
            "pressure",
            "of cells and one of points",
        ),
        (
            "Name=\"pressure\" NumberOfComponents=\"1\"",
            "Name=\"pressure\" NumberOfComponents=\"3\"",
            "pressure",
            "has 3 components, not 1",
        ),
        (
            "NumberOfCells='3'",
            "NumberOfCells='4'",
            "pressure",
            "has 3 numbers, and 4 are needed",
        ),
        (
            "NumberOfCells='3'",
            "NumberOfCells='x'",
            "pressure",
            "NumberOfCells=\"x\", which is no count",
        ),
        (
            "format=\"ascii\"",
            "format=\"zip\"",
            "pressure",
            "has the format zip",
        ),
        (
            "Name=\"connectivity\"",
            "Name=\"corners\"",
            "pressure",
            "no array `connectivity` in Cells",
        ),
        (
            ">\n 0 1 2 3 1",
            ">\n 0 1 2 3 17",
            "pressure",
            "cell 1 has the corner 17, and there are 9 points",
        ),
        (
            ">\n 4 12 16",
            ">\n 4 3 16",
            "pressure",
            "cell 1 has no corners",
        ),
        ("</Cells>", "", "p & q", ""),
    ] {
        assert!(text.contains(from), "{from}");
        let wrong = text.replace(from, to);
        match read(wrong.as_bytes(), "a.vtu", array) {
            Ok(_) => assert_eq!(expected, ""),
            Err(error) => {
                let said = error.to_string();
                assert!(!expected.is_empty() && said.contains(expected), "{said}");
            }
        }
    }
    let zipped = written(
        &[example(&mut Random::new(3))],
        Style {
            format: "binary",
            ..style
        },
    );
    let zipped = String::from_utf8(zipped).unwrap();
    let zipped = zipped.replace(" version=", " compressor=\"vtkLZ4DataCompressor\" version=");
    let said = read(zipped.as_bytes(), "a.vtu", "pressure")
        .unwrap_err()
        .to_string();
    assert!(
        said.contains("a.vtu is compressed (vtkLZ4DataCompressor), and only zlib is read; save it"),
        "{said}"
    );
}
