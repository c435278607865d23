//! Entities, nodes and elements of format 4.1.

use std::collections::HashMap;

use super::cursor::Cursor;
use super::element_kind::element_kind;
use super::{GmshDefect, GmshFile};

/// Physical groups of the entities, by (dimension, number).
#[derive(Clone, Debug, Default)]
pub(super) struct Entities {
    groups: HashMap<(i64, i64), Vec<i32>>,
}

impl Entities {
    /// Counts per dimension, then per entity its number, its box, its physical groups and its boundary.
    pub(super) fn read(&mut self, cursor: &mut Cursor<'_>) -> Result<(), GmshDefect> {
        let mut counts = [0; 4];
        for count in &mut counts {
            *count = cursor.size("the number of entities")?;
        }
        for (dimension, count) in (0..).zip(counts) {
            for _ in 0..count {
                let number = cursor.integer("the number of an entity")?;
                // a point has a position, the others have a box
                for _ in 0..if dimension == 0 { 3 } else { 6 } {
                    cursor.real("a bound of an entity")?;
                }
                let mut groups = Vec::new();
                for _ in 0..cursor.size("the number of an entity's physical groups")? {
                    groups.push(cursor.tag("a physical group")?);
                }
                if dimension > 0 {
                    for _ in 0..cursor.size("the number of an entity's bounding entities")? {
                        cursor.integer("a bounding entity")?;
                    }
                }
                self.groups.insert((dimension, number), groups);
            }
        }
        Ok(())
    }
}

/// Blocks of node numbers, then of as many positions; a parametric block has more coordinates per node.
pub(super) fn nodes(cursor: &mut Cursor<'_>, file: &mut GmshFile) -> Result<(), GmshDefect> {
    let blocks = cursor.size("the number of node blocks")?;
    let count = cursor.size("the number of nodes")?;
    for _ in 0..2 {
        cursor.size("the lowest or highest node")?;
    }
    file.nodes.reserve(cursor.room(count));
    let mut tags = Vec::new();
    for _ in 0..blocks {
        let dimension = cursor.natural("the dimension of an entity")?;
        cursor.integer("the number of an entity")?;
        let parameters = match cursor.integer("0 or 1 (parametric)")? {
            0 => 0,
            _ => dimension.min(3),
        };
        let in_block = cursor.size("the number of nodes in a block")?;
        tags.clear();
        tags.reserve(cursor.room(in_block));
        for _ in 0..in_block {
            tags.push(cursor.size("the number of a node")?);
        }
        for tag in &tags {
            let mut at = [0.0; 3];
            for x in &mut at {
                *x = cursor.real("a coordinate")?;
            }
            for _ in 0..parameters {
                cursor.real("a parametric coordinate")?;
            }
            file.add_node(cursor, *tag, at)?;
        }
    }
    counted(
        cursor,
        "nodes in all blocks",
        count,
        file.nodes.len() as u64,
    )
}

/// Blocks of elements of one entity and one type.
pub(super) fn elements(
    cursor: &mut Cursor<'_>,
    file: &mut GmshFile,
    entities: &Entities,
) -> Result<(), GmshDefect> {
    let blocks = cursor.size("the number of element blocks")?;
    let count = cursor.size("the number of elements")?;
    for _ in 0..2 {
        cursor.size("the lowest or highest element")?;
    }
    let mut found = 0;
    for _ in 0..blocks {
        let dimension = cursor.integer("the dimension of an entity")?;
        let entity = cursor.integer("the number of an entity")?;
        let number = cursor.integer("an element type")?;
        let kind = element_kind(number).ok_or_else(|| GmshDefect::UnknownKind {
            spot: cursor.before(),
            number,
        })?;
        let groups = entities.groups.get(&(dimension, entity));
        let groups = groups.into_iter().flatten().copied();
        let set = file.groups.set(kind.dimension, groups);
        for _ in 0..cursor.size("the number of elements in a block")? {
            let id = cursor.size("the number of an element")?;
            let mut nodes = [0; 125];
            let nodes = &mut nodes[..kind.nodes];
            for node in nodes.iter_mut() {
                *node = cursor.size("a node of an element")?;
            }
            file.add_element(cursor, kind, id, nodes, set)?;
            found += 1;
        }
    }
    counted(cursor, "elements in all blocks", count, found)
}

/// The blocks hold what the section promises.
fn counted(
    cursor: &Cursor<'_>,
    what: &'static str,
    expected: u64,
    found: u64,
) -> Result<(), GmshDefect> {
    match expected == found {
        true => Ok(()),
        false => Err(GmshDefect::Count {
            spot: cursor.before(),
            what,
            expected,
            found,
        }),
    }
}
