//! The sections of a Gmsh file in order, and those that both formats share.

use super::cursor::Cursor;
use super::{GmshDefect, GmshFile, version2, version4};

/// Formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    /// 2.2.
    Two,
    /// 4.1.
    Four,
}

/// Bytes of a `double` and of a `size_t`.
const DATA_SIZE: i64 = 8;

/// Everything that the file says.
pub(super) fn sections(cursor: &mut Cursor<'_>, file: &mut GmshFile) -> Result<(), GmshDefect> {
    let is_gmsh = matches!(cursor.section(), Ok("MeshFormat"));
    if !is_gmsh {
        return Err(GmshDefect::NotGmsh);
    }
    let format = mesh_format(cursor)?;
    let mut entities = version4::Entities::default();
    let mut has_elements = false;
    while !cursor.is_at_end() {
        let section = cursor.section()?;
        match section {
            "PhysicalNames" => physical_names(cursor, file)?,
            "Entities" => {
                cursor.end_line()?;
                entities.read(cursor)?;
            }
            "Nodes" if file.places.is_some() => {
                return Err(GmshDefect::SectionTwice { section: "$Nodes" });
            }
            "Nodes" => {
                cursor.end_line()?;
                match format {
                    Format::Two => version2::nodes(cursor, file)?,
                    Format::Four => version4::nodes(cursor, file)?,
                }
                file.close_nodes()?;
            }
            "Elements" if has_elements => {
                return Err(GmshDefect::SectionTwice {
                    section: "$Elements",
                });
            }
            "Elements" if file.places.is_none() => {
                return Err(GmshDefect::NoSection { section: "$Nodes" });
            }
            "Elements" => {
                has_elements = true;
                cursor.end_line()?;
                match format {
                    Format::Two => version2::elements(cursor, file)?,
                    Format::Four => version4::elements(cursor, file, &entities)?,
                }
            }
            "PartitionedEntities" => return Err(GmshDefect::Partitioned),
            "ParametricNodes" => return Err(GmshDefect::Parametric),
            other => {
                cursor.skip_to_end(other)?;
                continue;
            }
        }
        cursor.end(section)?;
    }
    match (&file.places, has_elements) {
        (None, _) => Err(GmshDefect::NoSection { section: "$Nodes" }),
        (_, false) => Err(GmshDefect::NoSection {
            section: "$Elements",
        }),
        _ => Ok(()),
    }
}

/// The number of nodes that the file announces, without reading any.
pub(super) fn node_count(cursor: &mut Cursor<'_>) -> Result<u64, GmshDefect> {
    let is_gmsh = matches!(cursor.section(), Ok("MeshFormat"));
    if !is_gmsh {
        return Err(GmshDefect::NotGmsh);
    }
    let format = mesh_format(cursor)?;
    while !cursor.is_at_end() {
        match (cursor.section()?, format) {
            ("Nodes", Format::Two) => return cursor.text_count("the number of nodes"),
            ("Nodes", Format::Four) => {
                cursor.end_line()?;
                cursor.size("the number of node blocks")?;
                return cursor.size("the number of nodes");
            }
            (other, _) => cursor.skip_to_end(other)?,
        }
    }
    Err(GmshDefect::NoSection { section: "$Nodes" })
}

/// `version file-type data-size`, in binary files followed by the number one.
fn mesh_format(cursor: &mut Cursor<'_>) -> Result<Format, GmshDefect> {
    let version = cursor.word("the version of the format")?;
    let format = match version {
        b"2.2" => Format::Two,
        b"4.1" => Format::Four,
        other => {
            return Err(GmshDefect::Version {
                found: String::from_utf8_lossy(&other[..other.len().min(16)]).into_owned(),
            });
        }
    };
    let binary = match cursor.text_integer("0 (ASCII) or 1 (binary)")? {
        0 => false,
        1 => true,
        found => return Err(GmshDefect::FileType { found }),
    };
    let found = cursor.text_integer("the data size 8")?;
    if found != DATA_SIZE {
        return Err(GmshDefect::DataSize { found });
    }
    if binary {
        cursor.end_line()?;
        match cursor.four()? {
            [1, 0, 0, 0] => {}
            [0, 0, 0, 1] => return Err(GmshDefect::BigEndian),
            found => return Err(GmshDefect::NoOne { found }),
        }
    }
    cursor.end("MeshFormat")?;
    cursor.binary = binary;
    Ok(format)
}

/// `count`, then `dimension number "name"`: text in either kind of file.
fn physical_names(cursor: &mut Cursor<'_>, file: &mut GmshFile) -> Result<(), GmshDefect> {
    for _ in 0..cursor.text_count("the number of physical names")? {
        const DIMENSION: &str = "a dimension from 0 to 3";
        let dimension = cursor.text_integer(DIMENSION)?;
        let Some(dimension) = u8::try_from(dimension).ok().filter(|d| *d <= 3) else {
            return Err(GmshDefect::Malformed {
                spot: cursor.before(),
                expected: DIMENSION,
                found: dimension.to_string(),
            });
        };
        let number = cursor.text_tag("the number of a physical group")?;
        let name = cursor.quoted("a name between double quotes")?;
        file.groups.call(dimension, number, name);
    }
    Ok(())
}
