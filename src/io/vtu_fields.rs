//! Fields read back from a grid that [`vtu`](super::vtu) wrote.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// The end of the XML, behind which the arrays stand.
const RAW: &[u8] = b"<AppendedData encoding=\"raw\">\n_";

/// Longest XML that is looked at: a few dozen fields.
const XML: u64 = 1 << 20;

/// Numbers of the field `name`, all components of an entity together; none where the file has no such field.
///
/// # Cost
/// The field alone is read.
///
/// # Errors
/// What the file system says, and `InvalidData` for a file of another form.
pub fn read_field(path: &Path, name: &str) -> io::Result<Option<Vec<f64>>> {
    let bad = |what: &str| io::Error::new(io::ErrorKind::InvalidData, what.to_owned());
    let mut file = BufReader::new(File::open(path)?);
    let mut xml = Vec::new();
    while !xml.ends_with(RAW) {
        // the marker ends with the only underscore behind a line's end
        let read = file.by_ref().take(XML).read_until(b'_', &mut xml)?;
        if read == 0 || xml.len() as u64 > XML {
            return Err(bad("no appended data of a grid of fracas"));
        }
    }
    let start = xml.len() as u64;
    let text = String::from_utf8_lossy(&xml);
    let named = format!("<DataArray type=\"Float64\" Name=\"{name}\" ");
    let Some((_, tag)) = text.split_once(&named) else {
        return Ok(None);
    };
    let offset = tag.split_once("offset=\"").and_then(|(_, rest)| {
        let (digits, _) = rest.split_once('"')?;
        digits.parse::<u64>().ok()
    });
    let offset = offset.ok_or_else(|| bad("a field without an offset"))?;
    file.seek(SeekFrom::Start(start + offset))?;
    let mut word = [0; 8];
    file.read_exact(&mut word)?;
    let bytes = u64::from_le_bytes(word);
    let mut raw = Vec::new();
    // what is not there is not reserved
    if file.take(bytes).read_to_end(&mut raw)? as u64 != bytes {
        return Err(bad("a field that is cut off"));
    }
    let numbers = raw.as_chunks::<8>().0.iter();
    Ok(Some(numbers.map(|w| f64::from_le_bytes(*w)).collect()))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::vtu::{Cells, Field, Grid};
    use super::*;

    #[test]
    fn fields_read_back_to_the_last_bit() {
        let field = |name, components, values| Field {
            name,
            components,
            values,
        };
        let values = [1.0, -0.0, f64::MIN_POSITIVE, 2.5];
        let grid = Grid {
            points: &[[0.0; 3], [1.0; 3], [2.0; 3], [3.0; 3]],
            cells: Cells::Quadrilaterals(&[[0, 1, 2, 3]]),
            point_fields: vec![field("u_1", 1, &values)],
            cell_fields: vec![field("t", 3, &[1.0, 2.0, 3.0])],
        };
        let path = std::env::temp_dir().join(format!("fracas-{}.vtu", std::process::id()));
        grid.write(&mut File::create(&path).unwrap()).unwrap();
        let read = |name: &str| read_field(&path, name).unwrap();
        let bits = |v: &[f64]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&read("u_1").unwrap()), bits(&values));
        assert_eq!(read("t").unwrap(), [1.0, 2.0, 3.0]);
        assert_eq!(read("pressure"), None);
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() - 60]).unwrap();
        assert!(read_field(&path, "t").is_err());
        std::fs::write(&path, "<VTKFile>").unwrap();
        assert!(read_field(&path, "t").is_err());
        std::fs::remove_file(&path).unwrap();
    }
}
