//! VTK unstructured grids (`.vtu`), binary, raw appended: what ParaView opens.

use std::io::{self, Write};

/// The cells of a file: all of one type.
#[derive(Clone, Copy, Debug)]
pub enum Cells<'a> {
    /// Eight-node hexahedra (VTK type 12).
    Hexahedra(&'a [[u32; 8]]),
    /// Four-node quadrilaterals (VTK type 9).
    Quadrilaterals(&'a [[u32; 4]]),
}

/// A named field with `components` values per point or per cell, one entity after the other.
#[derive(Clone, Debug)]
pub struct Field<'a> {
    /// Name shown by ParaView.
    pub name: &'a str,
    /// 1 for scalars, 3 for vectors, 6 for symmetric tensors.
    pub components: usize,
    /// `components` × entities values.
    pub values: &'a [f64],
}

/// A grid with its fields.
#[derive(Clone, Debug)]
pub struct Grid<'a> {
    /// Positions [m].
    pub points: &'a [[f64; 3]],
    /// Cells.
    pub cells: Cells<'a>,
    /// Fields with one entry per point.
    pub point_fields: Vec<Field<'a>>,
    /// Fields with one entry per cell.
    pub cell_fields: Vec<Field<'a>>,
}

/// An array of the appended section.
enum Values<'a> {
    Positions(&'a [[f64; 3]]),
    Reals(&'a [f64]),
    Corners(Cells<'a>),
    /// Where the corners of each cell end.
    Ends {
        cells: usize,
        corners: usize,
    },
    Types {
        cells: usize,
        kind: u8,
    },
}

/// The arrays of the appended section, each behind its length in bytes (UInt64): written from where they are, not collected.
#[derive(Default)]
struct Appended<'a> {
    arrays: Vec<Values<'a>>,
    bytes: usize,
}

impl Cells<'_> {
    fn len(self) -> usize {
        match self {
            Self::Hexahedra(cells) => cells.len(),
            Self::Quadrilaterals(cells) => cells.len(),
        }
    }

    /// Corners of a cell.
    fn corners(self) -> usize {
        match self {
            Self::Hexahedra(_) => 8,
            Self::Quadrilaterals(_) => 4,
        }
    }
}

impl Values<'_> {
    /// Type of an entry, and its size in bytes.
    fn kind(&self) -> (&'static str, usize) {
        match self {
            Self::Positions(_) | Self::Reals(_) => ("Float64", 8),
            Self::Corners(_) | Self::Ends { .. } => ("Int64", 8),
            Self::Types { .. } => ("UInt8", 1),
        }
    }

    /// Entries.
    fn len(&self) -> usize {
        match self {
            Self::Positions(points) => 3 * points.len(),
            Self::Reals(values) => values.len(),
            Self::Corners(cells) => cells.len() * cells.corners(),
            Self::Ends { cells, .. } | Self::Types { cells, .. } => *cells,
        }
    }

    fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let real = |v: &f64| out.write_all(&v.to_le_bytes());
        match self {
            Self::Positions(points) => points.iter().flatten().try_for_each(real),
            Self::Reals(values) => values.iter().try_for_each(real),
            Self::Corners(cells) => {
                let corners = match cells {
                    Cells::Hexahedra(cells) => cells.as_flattened(),
                    Cells::Quadrilaterals(cells) => cells.as_flattened(),
                };
                let mut index = |a: &u32| out.write_all(&i64::from(*a).to_le_bytes());
                corners.iter().try_for_each(&mut index)
            }
            Self::Ends { cells, corners } => {
                let mut end = |c: usize| out.write_all(&((c * corners) as i64).to_le_bytes());
                (1..=*cells).try_for_each(&mut end)
            }
            Self::Types { cells, kind } => (0..*cells).try_for_each(|_| out.write_all(&[*kind])),
        }
    }
}

impl<'a> Appended<'a> {
    /// Appends an array and returns the XML tag that points at it.
    fn tag(&mut self, name: &str, components: usize, values: Values<'a>) -> String {
        let (offset, (kind, size)) = (self.bytes, values.kind());
        self.bytes += 8 + size * values.len();
        self.arrays.push(values);
        format!(
            "<DataArray type=\"{kind}\" Name=\"{}\" NumberOfComponents=\"{components}\" format=\"appended\" offset=\"{offset}\"/>\n",
            escape(name)
        )
    }

    fn field(&mut self, field: &Field<'a>, entities: usize) -> String {
        assert_eq!(
            field.values.len(),
            field.components * entities,
            "field {} has the wrong length",
            field.name
        );
        self.tag(field.name, field.components, Values::Reals(field.values))
    }

    fn write(&self, out: &mut impl Write) -> io::Result<()> {
        self.arrays.iter().try_for_each(|values| {
            let (_, size) = values.kind();
            out.write_all(&((size * values.len()) as u64).to_le_bytes())?;
            values.write(out)
        })
    }
}

/// Text that is safe inside an XML attribute.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;")
}

impl Grid<'_> {
    /// Writes the file.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let kind = match self.cells {
            Cells::Hexahedra(_) => 12,
            Cells::Quadrilaterals(_) => 9,
        };
        let (n_cells, corners) = (self.cells.len(), self.cells.corners());
        let mut data = Appended::default();
        let points = data.tag("Points", 3, Values::Positions(self.points));
        let mut cells = data.tag("connectivity", 1, Values::Corners(self.cells));
        let ends = Values::Ends {
            cells: n_cells,
            corners,
        };
        cells += &data.tag("offsets", 1, ends);
        let types = Values::Types {
            cells: n_cells,
            kind,
        };
        cells += &data.tag("types", 1, types);
        let mut point_fields = String::new();
        for field in &self.point_fields {
            point_fields += &data.field(field, self.points.len());
        }
        let mut cell_fields = String::new();
        for field in &self.cell_fields {
            cell_fields += &data.field(field, n_cells);
        }
        write!(
            out,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
             <UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{n_cells}\">\n\
             <Points>\n{points}</Points>\n<Cells>\n{cells}</Cells>\n\
             <PointData>\n{point_fields}</PointData>\n<CellData>\n{cell_fields}</CellData>\n\
             </Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_",
            self.points.len()
        )?;
        data.write(out)?;
        out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_point_at_the_arrays() {
        let points = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
        ];
        let grid = Grid {
            points: &points,
            cells: Cells::Quadrilaterals(&[[0, 1, 2, 3]]),
            point_fields: vec![],
            cell_fields: vec![Field {
                name: "traction",
                components: 3,
                values: &[1.0, 2.0, 3.0],
            }],
        };
        let mut file = Vec::new();
        grid.write(&mut file).unwrap();
        let start = file.windows(4).position(|w| w == b"raw\"").unwrap() + 7;
        let text = String::from_utf8_lossy(&file[..start]).into_owned();
        assert_eq!(file[start - 1], b'_');
        let offset: usize = text
            .split("Name=\"traction\"")
            .nth(1)
            .and_then(|t| t.split("offset=\"").nth(1))
            .and_then(|t| t.split('"').next())
            .unwrap()
            .parse()
            .unwrap();
        let at = start + offset;
        assert_eq!(u64::from_le_bytes(file[at..at + 8].try_into().unwrap()), 24);
        assert_eq!(
            f64::from_le_bytes(file[at + 16..at + 24].try_into().unwrap()),
            2.0
        );
    }
}
