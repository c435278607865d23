//! Writes Gmsh files: formats 2.2 and 4.1, ASCII and binary.

use std::fmt::Write as _;

/// An element with the numbers of its nodes and physical groups.
#[derive(Clone, Debug)]
pub(crate) struct Element {
    pub(crate) id: u64,
    pub(crate) kind: i32,
    pub(crate) dimension: i32,
    pub(crate) groups: Vec<i32>,
    pub(crate) nodes: Vec<u64>,
}

/// A mesh as Gmsh sees it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Msh {
    pub(crate) nodes: Vec<(u64, [f64; 3])>,
    /// (dimension, number, name).
    pub(crate) names: Vec<(i32, i32, String)>,
    pub(crate) elements: Vec<Element>,
}

/// The four forms.
pub(crate) const FORMS: [(&str, bool); 4] =
    [("2.2", false), ("2.2", true), ("4.1", false), ("4.1", true)];

/// Text or little-endian numbers.
struct Out {
    bytes: Vec<u8>,
    binary: bool,
}

impl Out {
    fn text(&mut self, text: &str) {
        self.bytes.extend(text.as_bytes());
    }
    fn int(&mut self, value: i64) {
        match self.binary {
            true => self.bytes.extend((value as i32).to_le_bytes()),
            false => self.text(&format!("{value} ")),
        }
    }
    fn size(&mut self, value: u64) {
        match self.binary {
            true => self.bytes.extend(value.to_le_bytes()),
            false => self.text(&format!("{value} ")),
        }
    }
    fn real(&mut self, value: f64) {
        match self.binary {
            true => self.bytes.extend(value.to_le_bytes()),
            false => self.text(&format!("{value:?} ")),
        }
    }
    /// Ends a record of a text file.
    fn next(&mut self) {
        if !self.binary {
            self.text("\n");
        }
    }
}

impl Msh {
    pub(crate) fn write(&self, (version, binary): (&str, bool)) -> Vec<u8> {
        let mut out = Out {
            bytes: Vec::new(),
            binary,
        };
        out.text(&format!("$MeshFormat\n{version} {} 8\n", u8::from(binary)));
        if binary {
            out.int(1);
            out.text("\n");
        }
        out.text("$EndMeshFormat\n");
        let mut names = String::new();
        for (dimension, number, name) in &self.names {
            writeln!(names, "{dimension} {number} \"{name}\"").unwrap();
        }
        let count = self.names.len();
        out.text(&format!(
            "$PhysicalNames\n{count}\n{names}$EndPhysicalNames\n"
        ));
        match version {
            "2.2" => self.version2(&mut out),
            _ => self.version4(&mut out),
        }
        out.bytes
    }

    fn version2(&self, out: &mut Out) {
        out.text(&format!("$Nodes\n{}\n", self.nodes.len()));
        for (tag, x) in &self.nodes {
            out.int(*tag as i64);
            x.iter().for_each(|x| out.real(*x));
            out.next();
        }
        // an element is written once for each of its groups
        let mut records = Vec::new();
        let mut extra = 1_000_000;
        for element in &self.elements {
            let mut groups = element.groups.clone();
            if groups.is_empty() {
                groups.push(0);
            }
            for (g, group) in groups.into_iter().enumerate() {
                extra += 1;
                let id = if g == 0 { element.id } else { extra };
                records.push((id, group, element));
            }
        }
        out.text(&format!("$EndNodes\n$Elements\n{}\n", records.len()));
        for (id, group, element) in records {
            if out.binary {
                out.int(element.kind.into());
                out.int(1);
                out.int(2);
                out.int(id as i64);
            } else {
                out.text(&format!("{id} {} 2 ", element.kind));
            }
            out.int(group.into());
            out.int(1);
            element.nodes.iter().for_each(|n| out.int(*n as i64));
            out.next();
        }
        out.text("$EndElements\n");
    }

    fn version4(&self, out: &mut Out) {
        // an entity for every set of groups
        let mut entities: Vec<(i32, Vec<i32>)> = Vec::new();
        let entity = |e: &Element| (e.dimension, e.groups.clone());
        for element in &self.elements {
            if !entities.contains(&entity(element)) {
                entities.push(entity(element));
            }
        }
        out.text("$Entities\n");
        for d in 0..4 {
            out.size(entities.iter().filter(|e| e.0 == d).count() as u64);
        }
        out.next();
        for d in 0..4 {
            for (number, (dimension, groups)) in entities.iter().enumerate() {
                if *dimension != d {
                    continue;
                }
                out.int(number as i64 + 1);
                (0..if d == 0 { 3 } else { 6 }).for_each(|_| out.real(0.5));
                out.size(groups.len() as u64);
                groups.iter().for_each(|g| out.int((*g).into()));
                if d > 0 {
                    out.size(2);
                    out.int(1);
                    out.int(-2);
                }
                out.next();
            }
        }
        out.text("$EndEntities\n$Nodes\n");
        // two blocks, the second one parametric on a surface
        let half = self.nodes.len() / 2;
        out.size(2);
        out.size(self.nodes.len() as u64);
        out.size(1);
        out.size(self.nodes.iter().map(|n| n.0).max().unwrap_or(0));
        out.next();
        for (parametric, block) in [(0, &self.nodes[..half]), (1, &self.nodes[half..])] {
            out.int(2);
            out.int(1);
            out.int(parametric);
            out.size(block.len() as u64);
            out.next();
            for (tag, _) in block {
                out.size(*tag);
                out.next();
            }
            for (_, x) in block {
                x.iter().for_each(|x| out.real(*x));
                (0..2 * parametric).for_each(|_| out.real(0.25));
                out.next();
            }
        }
        out.text("$EndNodes\n$Elements\n");
        let same = |a: &Element, b: &Element| entity(a) == entity(b) && a.kind == b.kind;
        let blocks: Vec<&[Element]> = self.elements.chunk_by(same).collect();
        out.size(blocks.len() as u64);
        out.size(self.elements.len() as u64);
        out.size(1);
        out.size(self.elements.iter().map(|e| e.id).max().unwrap_or(0));
        out.next();
        for block in blocks {
            let place = entities
                .iter()
                .position(|e| *e == entity(&block[0]))
                .unwrap();
            out.int(block[0].dimension.into());
            out.int(place as i64 + 1);
            out.int(block[0].kind.into());
            out.size(block.len() as u64);
            out.next();
            for element in block {
                out.size(element.id);
                element.nodes.iter().for_each(|n| out.size(*n));
                out.next();
            }
        }
        out.text("$EndElements\n");
    }
}
