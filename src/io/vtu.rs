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

/// Arrays collected for the appended section, each behind its length in bytes (UInt64).
#[derive(Default)]
struct Appended(Vec<u8>);

impl Appended {
    /// Appends an array and returns the XML tag that points at it.
    fn tag<const N: usize>(
        &mut self,
        kind: &str,
        name: &str,
        components: usize,
        values: impl Iterator<Item = [u8; N]>,
    ) -> String {
        let offset = self.0.len();
        self.0.extend_from_slice(&[0; 8]);
        values.for_each(|v| self.0.extend_from_slice(&v));
        let bytes = (self.0.len() - offset - 8) as u64;
        self.0[offset..offset + 8].copy_from_slice(&bytes.to_le_bytes());
        format!(
            "<DataArray type=\"{kind}\" Name=\"{}\" NumberOfComponents=\"{components}\" format=\"appended\" offset=\"{offset}\"/>\n",
            escape(name)
        )
    }

    fn field(&mut self, field: &Field<'_>, entities: usize) -> String {
        assert_eq!(
            field.values.len(),
            field.components * entities,
            "field {} has the wrong length",
            field.name
        );
        let values = field.values.iter().map(|v| v.to_le_bytes());
        self.tag("Float64", field.name, field.components, values)
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
        let (connectivity, corners, cell_type): (Box<dyn Iterator<Item = u32> + '_>, usize, u8) =
            match self.cells {
                Cells::Hexahedra(cells) => (Box::new(cells.iter().flatten().copied()), 8, 12),
                Cells::Quadrilaterals(cells) => (Box::new(cells.iter().flatten().copied()), 4, 9),
            };
        let n_cells = match self.cells {
            Cells::Hexahedra(cells) => cells.len(),
            Cells::Quadrilaterals(cells) => cells.len(),
        };
        let mut data = Appended::default();
        let positions = self.points.iter().flatten().map(|v| v.to_le_bytes());
        let points = data.tag("Float64", "Points", 3, positions);
        let indices = connectivity.map(|a| i64::from(a).to_le_bytes());
        let mut cells = data.tag("Int64", "connectivity", 1, indices);
        let ends = (1..=n_cells).map(|c| ((c * corners) as i64).to_le_bytes());
        cells += &data.tag("Int64", "offsets", 1, ends);
        let types = std::iter::repeat_n([cell_type], n_cells);
        cells += &data.tag("UInt8", "types", 1, types);
        let mut section = |fields: &[Field<'_>], entities: usize| -> String {
            fields.iter().map(|f| data.field(f, entities)).collect()
        };
        let point_fields = section(&self.point_fields, self.points.len());
        let cell_fields = section(&self.cell_fields, n_cells);
        write!(
            out,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
             <UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{n_cells}\">\n\
             <Points>\n{points}</Points>\n<Cells>\n{cells}</Cells>\n\
             <PointData>\n{point_fields}</PointData>\n<CellData>\n{cell_fields}</CellData>\n\
             </Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_",
            self.points.len()
        )?;
        out.write_all(&data.0)?;
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
