//! Unstructured grids of VTK: centres of cells, or points, with the numbers of one array.
//!
//! Read are arrays as text, as base 64 between tags or in the section behind them, and raw, as they are or compressed by zlib, in either order
//! of bytes.
//!
//! # Source
//! The VTK User's Guide, Kitware, 11th ed. 2010, § 19.3: XML file formats.

mod array;
mod base64;
mod packed;
mod xml;

use super::PoreProblem;
use super::cells::Shapes;
use super::cloud::{Cloud, Origin};
use super::places::median;
use array::{Appended, Array, Layout};
use xml::Tags;

/// A part of a grid.
#[derive(Default)]
struct Piece<'b> {
    points: usize,
    cells: usize,
    /// Its arrays and the section that each stands in.
    arrays: Vec<(String, Array<'b>)>,
}

/// A file, its arrays not yet read.
struct File<'b> {
    name: &'b str,
    pieces: Vec<Piece<'b>>,
    layout: Layout,
    appended: Option<Appended<'b>>,
    compressor: Option<String>,
}

/// The compressor that is read.
const ZLIB: &str = "vtkZLibDataCompressor";

/// Places and numbers of the array: those of cells at their centres, those of points where they lie. Units are those of the file.
///
/// # Errors
/// [`PoreProblem`] of the file.
pub(super) fn read(bytes: &[u8], file: &str, array: &str) -> Result<Cloud, PoreProblem> {
    let grid = |reason| PoreProblem::Grid {
        file: file.into(),
        reason,
    };
    let found = scan(bytes, file).map_err(grid)?;
    let origin = found.origin(array)?;
    if let Some(compressor) = found.compressed(origin, array) {
        return Err(PoreProblem::Compressed {
            file: file.into(),
            compressor,
        });
    }
    found.cloud(origin, array).map_err(grid)
}

/// Points and cells that the first piece of a file announces within the bytes that it begins with.
pub(super) fn announced(beginning: &[u8]) -> Option<[usize; 2]> {
    let mut tags = Tags {
        bytes: beginning,
        at: 0,
    };
    while let Some(tag) = tags.next().ok()? {
        if tag.name == "Piece" {
            let count = |name| tag.number(name).ok().flatten();
            return Some([count("NumberOfPoints")?, count("NumberOfCells")?]);
        }
    }
    None
}

/// What the tags of a file say.
fn scan<'b>(bytes: &'b [u8], name: &'b str) -> Result<File<'b>, String> {
    let mut tags = Tags { bytes, at: 0 };
    let mut file = File {
        name,
        pieces: Vec::new(),
        layout: Layout {
            is_big_endian: false,
            header: 4,
            is_packed: false,
        },
        appended: None,
        compressor: None,
    };
    let (mut section, mut is_vtk, mut is_whole) = (String::new(), false, false);
    while let Some(tag) = tags.next()? {
        match tag.name.as_str() {
            "VTKFile" => {
                let kind = tag.get("type").unwrap_or_default();
                if kind != "UnstructuredGrid" {
                    return Err(format!(
                        "it is of the type {kind}; save it as an UnstructuredGrid"
                    ));
                }
                is_vtk = true;
                file.layout.is_big_endian = tag.get("byte_order") == Some("BigEndian");
                file.layout.header = match tag.get("header_type") {
                    None | Some("UInt32") => 4,
                    Some("UInt64") => 8,
                    Some(other) => return Err(format!("its header_type is {other}")),
                };
                file.compressor = tag.get("compressor").map(String::from);
                file.layout.is_packed = file.compressor.is_some();
            }
            _ if !is_vtk => return Err(format!("it begins with <{}>, not <VTKFile>", tag.name)),
            "Piece" => {
                let count = |name| {
                    let number = tag.number(name)?;
                    number.ok_or_else(|| format!("a Piece has no {name}"))
                };
                file.pieces.push(Piece {
                    points: count("NumberOfPoints")?,
                    cells: count("NumberOfCells")?,
                    arrays: Vec::new(),
                });
            }
            "Points" | "Cells" | "PointData" | "CellData" if !tag.is_empty => {
                section = tag.name;
            }
            "/Points" | "/Cells" | "/PointData" | "/CellData" => section.clear(),
            "/VTKFile" => is_whole = true,
            "DataArray" => {
                let start = tag.end;
                let text = match tag.is_empty {
                    true => &bytes[start..start],
                    false => inside(&mut tags, "DataArray")?,
                };
                if let Some(piece) = file.pieces.last_mut().filter(|_| !section.is_empty()) {
                    piece.arrays.push((section.clone(), Array { tag, text }));
                }
            }
            "AppendedData" => {
                let rest = &bytes[tag.end..];
                let mark = rest.iter().position(|byte| *byte == b'_');
                let mark = mark.ok_or("its AppendedData has no _ to begin with")?;
                file.appended = Some(Appended {
                    bytes: &rest[mark + 1..],
                    is_raw: tag.get("encoding") == Some("raw"),
                });
                return Ok(file);
            }
            _ => {}
        }
    }
    match (is_vtk, is_whole) {
        (true, true) => Ok(file),
        (true, false) => Err("it ends before </VTKFile>".into()),
        (false, _) => Err("it has no <VTKFile>".into()),
    }
}

/// What stands between a tag and the one that closes it; tags between, as VTK writes about ranges, end it.
fn inside<'b>(tags: &mut Tags<'b>, name: &str) -> Result<&'b [u8], String> {
    let start = tags.at;
    let length = tags.bytes[start..].iter().position(|byte| *byte == b'<');
    let text = &tags.bytes[start..start + length.unwrap_or(0)];
    while let Some(tag) = tags.next()? {
        if tag.name.strip_prefix('/') == Some(name) {
            return Ok(text);
        }
    }
    Err(format!("it ends within a {name}"))
}

impl File<'_> {
    /// Whether the array is of cells or of points.
    fn origin(&self, array: &str) -> Result<Origin, PoreProblem> {
        let all = || self.pieces.iter().flat_map(|piece| &piece.arrays);
        let is_in = |own: &str| all().any(|(section, a)| section == own && a.name() == array);
        match (is_in("CellData"), is_in("PointData")) {
            (true, false) => Ok(Origin::Cell),
            (false, true) => Ok(Origin::Point),
            (true, true) => Err(PoreProblem::TwoArrays {
                file: self.name.into(),
                array: array.into(),
            }),
            (false, false) => {
                let of_data = all().filter(|(section, _)| section.ends_with("Data"));
                let mut known: Vec<String> = of_data.map(|(_, a)| a.name().to_owned()).collect();
                known.sort();
                known.dedup();
                Err(PoreProblem::NoArray {
                    file: self.name.into(),
                    array: array.into(),
                    known,
                })
            }
        }
    }

    /// The compressor, where it is not zlib and has worked on what is needed; text is never compressed.
    fn compressed(&self, origin: Origin, array: &str) -> Option<String> {
        let compressor = self.compressor.as_ref().filter(|name| *name != ZLIB)?;
        let needed = |(section, own): &(String, Array<'_>)| {
            !section.ends_with("Data") || (section == data(origin) && own.name() == array)
        };
        let mut all = self.pieces.iter().flat_map(|piece| &piece.arrays);
        let is_binary = |own: &Array<'_>| own.tag.get("format").is_some_and(|f| f != "ascii");
        all.any(|own| needed(own) && is_binary(&own.1))
            .then(|| compressor.clone())
    }

    fn cloud(&self, origin: Origin, array: &str) -> Result<Cloud, String> {
        let (mut points, mut numbers, mut diameters) = (Vec::new(), Vec::new(), Vec::new());
        let mut shapes = Shapes::default();
        for piece in &self.pieces {
            let own = self.geometry(piece)?;
            diameters.extend((0..own.ends.len()).map(|cell| own.diameter(cell)));
            let places = match origin {
                Origin::Cell => {
                    own.check()?;
                    let centers = own.centers();
                    shapes.append(own);
                    centers
                }
                Origin::Point | Origin::Record => own.nodes,
            };
            let own = match places.is_empty() {
                true => Vec::new(),
                false => self.array(piece, data(origin), array, 1, places.len())?,
            };
            numbers.extend(own);
            points.extend(places);
        }
        Ok(Cloud {
            file: self.name.into(),
            origin,
            numbers: (0..points.len()).collect(),
            points,
            pressures: vec![numbers],
            cells: (!diameters.is_empty()).then(|| median(diameters)),
            shapes: (origin == Origin::Cell).then_some(shapes),
        })
    }

    /// Points and cells of a piece.
    fn geometry(&self, piece: &Piece<'_>) -> Result<Shapes, String> {
        let mut shapes = Shapes::default();
        if piece.points == 0 {
            return Ok(shapes);
        }
        let own = piece.arrays.iter().find(|(section, _)| section == "Points");
        let name = own.ok_or("a Piece has no Points")?.1.name();
        let nodes = self.array(piece, "Points", name, 3, piece.points)?;
        shapes.nodes = nodes.as_chunks().0.to_vec();
        if piece.cells == 0 {
            return Ok(shapes);
        }
        let ends = self.array(piece, "Cells", "offsets", 1, piece.cells)?;
        let count = ends.last().map_or(0, |end| *end as usize);
        let corners = self.find(piece, "Cells", "connectivity")?;
        let corners = corners.numbers(self.layout, self.appended, count)?;
        let nodes = shapes.nodes.len();
        let mut start = 0;
        for (cell, end) in ends.iter().map(|end| *end as usize).enumerate() {
            let own = corners.get(start..end).filter(|own| !own.is_empty());
            let own = own.ok_or_else(|| format!("cell {cell} has no corners in `connectivity`"))?;
            start = end;
            if let Some(a) = own.iter().find(|a| !(**a >= 0.0 && **a < nodes as f64)) {
                return Err(format!(
                    "cell {cell} has the corner {a}, and there are {nodes} points"
                ));
            }
            shapes.corners.extend(own.iter().map(|a| *a as u32));
            shapes.ends.push(end);
        }
        // of some writers' files they are missing: boxes are cells then
        shapes.types = match self.find(piece, "Cells", "types") {
            Ok(_) => {
                let types = self.array(piece, "Cells", "types", 1, piece.cells)?;
                types.into_iter().map(|kind| kind as u8).collect()
            }
            Err(_) => vec![0; piece.cells],
        };
        Ok(shapes)
    }

    fn find<'p>(
        &self,
        piece: &'p Piece<'_>,
        section: &str,
        name: &str,
    ) -> Result<&'p Array<'p>, String> {
        let is_own = |(own, array): &&(String, Array<'_>)| own == section && array.name() == name;
        let found = piece.arrays.iter().find(is_own).map(|(_, array)| array);
        found.ok_or_else(|| format!("a Piece has no array `{name}` in {section}"))
    }

    /// The numbers of an array with so many components and entities.
    fn array(
        &self,
        piece: &Piece<'_>,
        section: &str,
        name: &str,
        components: usize,
        entities: usize,
    ) -> Result<Vec<f64>, String> {
        let array = self.find(piece, section, name)?;
        let own = array.tag.number("NumberOfComponents")?.unwrap_or(1);
        if own != components {
            return Err(format!(
                "array `{name}` has {own} components, not {components}"
            ));
        }
        let numbers = array.numbers(self.layout, self.appended, components * entities)?;
        if numbers.len() != components * entities {
            return Err(format!(
                "array `{name}` has {} numbers, and {} are needed",
                numbers.len(),
                components * entities
            ));
        }
        Ok(numbers)
    }
}

/// The section of the arrays of cells or points.
fn data(origin: Origin) -> &'static str {
    match origin {
        Origin::Cell => "CellData",
        Origin::Point | Origin::Record => "PointData",
    }
}

#[cfg(test)]
mod tests;
