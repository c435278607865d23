//! Unstructured grids of VTK: centres of cells, or points, with the numbers of one array.
//!
//! Read are arrays as text, as base 64 between tags or in the section behind them, and raw, uncompressed, in either order of bytes.
//!
//! # Source
//! The VTK User's Guide, Kitware, 11th ed. 2010, § 19.3: XML file formats.

mod array;
mod base64;
mod xml;

use super::PoreProblem;
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

/// What the tags of a file say.
fn scan<'b>(bytes: &'b [u8], name: &'b str) -> Result<File<'b>, String> {
    let mut tags = Tags { bytes, at: 0 };
    let mut file = File {
        name,
        pieces: Vec::new(),
        layout: Layout {
            is_big_endian: false,
            header: 4,
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

    /// The compressor, where it has worked on what is needed; text is never compressed.
    fn compressed(&self, origin: Origin, array: &str) -> Option<String> {
        let compressor = self.compressor.as_ref()?;
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
        for piece in &self.pieces {
            let (nodes, centers, sizes) = self.geometry(piece)?;
            let places = match origin {
                Origin::Cell => centers,
                Origin::Point | Origin::Record => nodes,
            };
            diameters.extend(sizes);
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
        })
    }

    /// Points of a piece, centres of its cells (the mean of their corners) and their diameters (of the boxes around them).
    fn geometry(&self, piece: &Piece<'_>) -> Result<Geometry, String> {
        if piece.points == 0 {
            return Ok(Default::default());
        }
        let own = piece.arrays.iter().find(|(section, _)| section == "Points");
        let name = own.ok_or("a Piece has no Points")?.1.name();
        let nodes = self.array(piece, "Points", name, 3, piece.points)?;
        let nodes: Vec<[f64; 3]> = nodes.as_chunks().0.to_vec();
        let (mut centers, mut sizes) = (Vec::new(), Vec::new());
        if piece.cells == 0 {
            return Ok((nodes, centers, sizes));
        }
        let ends = self.array(piece, "Cells", "offsets", 1, piece.cells)?;
        let corners = self.find(piece, "Cells", "connectivity")?;
        let corners = corners.numbers(self.layout, self.appended)?;
        let mut start = 0;
        for (cell, end) in ends.iter().enumerate() {
            let own = corners.get(start..*end as usize);
            let own = own.filter(|own| !own.is_empty());
            let own = own.ok_or_else(|| format!("cell {cell} has no corners in `connectivity`"))?;
            start = *end as usize;
            let (mut sum, mut ends) = ([0.0; 3], [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]);
            for a in own {
                let x = nodes.get(*a as usize).filter(|_| *a >= 0.0);
                let x = x.ok_or_else(|| {
                    format!(
                        "cell {cell} has the corner {a}, and there are {} points",
                        nodes.len()
                    )
                })?;
                for d in 0..3 {
                    sum[d] += x[d];
                    ends[0][d] = ends[0][d].min(x[d]);
                    ends[1][d] = ends[1][d].max(x[d]);
                }
            }
            centers.push(sum.map(|s| s / own.len() as f64));
            let square = (0..3).map(|d| (ends[1][d] - ends[0][d]).powi(2));
            sizes.push(square.sum::<f64>().sqrt());
        }
        Ok((nodes, centers, sizes))
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
        let numbers = array.numbers(self.layout, self.appended)?;
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

/// Points, centres of cells, diameters of cells.
type Geometry = (Vec<[f64; 3]>, Vec<[f64; 3]>, Vec<f64>);

/// The section of the arrays of cells or points.
fn data(origin: Origin) -> &'static str {
    match origin {
        Origin::Cell => "CellData",
        Origin::Point | Origin::Record => "PointData",
    }
}

#[cfg(test)]
mod tests;
