//! Nodes and elements of format 2.2.

use super::cursor::Cursor;
use super::element_kind::{ElementKind, element_kind};
use super::{GmshDefect, GmshFile};

/// `count`, then `number x y z`.
pub(super) fn nodes(cursor: &mut Cursor<'_>, file: &mut GmshFile) -> Result<(), GmshDefect> {
    let count = cursor.text_count("the number of nodes")?;
    if cursor.binary {
        cursor.end_line()?;
    }
    file.nodes.reserve(cursor.room(count));
    for _ in 0..count {
        let tag = cursor.natural("the number of a node")?;
        let mut at = [0.0; 3];
        for x in &mut at {
            *x = cursor.real("a coordinate")?;
        }
        file.add_node(cursor, tag, at)?;
    }
    Ok(())
}

/// Most tags of an element that are read: physical group, entity, number of partitions and these.
const MAX_TAGS: u64 = 1024;

fn kind(cursor: &mut Cursor<'_>) -> Result<&'static ElementKind, GmshDefect> {
    let number = cursor.integer("an element type")?;
    element_kind(number).ok_or_else(|| GmshDefect::UnknownKind {
        spot: cursor.before(),
        number,
    })
}

fn tag_count(cursor: &mut Cursor<'_>) -> Result<u64, GmshDefect> {
    const EXPECTED: &str = "the number of an element's tags";
    let found = cursor.natural(EXPECTED)?;
    match found <= MAX_TAGS {
        true => Ok(found),
        false => Err(GmshDefect::Malformed {
            spot: cursor.before(),
            expected: EXPECTED,
            found: found.to_string(),
        }),
    }
}

/// Text: `number type tags tag… node…`; binary: blocks `type count tags` of `number tag… node…`. The first tag is the
/// physical group.
pub(super) fn elements(cursor: &mut Cursor<'_>, file: &mut GmshFile) -> Result<(), GmshDefect> {
    let mut left = cursor.text_count("the number of elements")?;
    if cursor.binary {
        cursor.end_line()?;
    }
    let mut number = None;
    while left > 0 {
        let (kind, in_block, tags) = match cursor.binary {
            true => {
                const EXPECTED: &str = "the number of elements in a block";
                let kind = kind(cursor)?;
                let in_block = cursor.natural(EXPECTED)?;
                if in_block == 0 || in_block > left {
                    return Err(GmshDefect::Malformed {
                        spot: cursor.before(),
                        expected: EXPECTED,
                        found: in_block.to_string(),
                    });
                }
                (kind, in_block, tag_count(cursor)?)
            }
            false => {
                number = Some(cursor.natural("the number of an element")?);
                let kind = kind(cursor)?;
                (kind, 1, tag_count(cursor)?)
            }
        };
        for _ in 0..in_block {
            let id = match number.take() {
                Some(number) => number,
                None => cursor.natural("the number of an element")?,
            };
            let mut physical = 0;
            for tag in 0..tags {
                let value = cursor.tag("a tag of an element")?;
                if tag == 0 {
                    physical = value;
                }
            }
            let mut nodes = [0; 125];
            let nodes = &mut nodes[..kind.nodes];
            for node in nodes.iter_mut() {
                *node = cursor.natural("a node of an element")?;
            }
            let set = file.groups.set(kind.dimension, [physical].into_iter());
            file.add_element(cursor, kind, id, nodes, set)?;
        }
        left -= in_block;
    }
    Ok(())
}
