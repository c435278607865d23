//! Lists of numbers per row, in one array.

/// For every row the items that belong to it, in the order in which they were given.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Incidence {
    offsets: Vec<usize>,
    items: Vec<u32>,
}

impl Incidence {
    /// `(row, item)` pairs, given twice in the same order.
    pub(crate) fn new<I: Iterator<Item = (usize, u32)>>(
        rows: usize,
        pairs: impl Fn() -> I,
    ) -> Self {
        let mut offsets = vec![0; rows + 1];
        pairs().for_each(|(row, _)| offsets[row + 1] += 1);
        for row in 0..rows {
            offsets[row + 1] += offsets[row];
        }
        let mut next = offsets.clone();
        let mut items = vec![0; offsets[rows]];
        for (row, item) in pairs() {
            items[next[row]] = item;
            next[row] += 1;
        }
        Self { offsets, items }
    }

    /// Where the items of a row stand among those of all.
    pub(crate) fn range(&self, row: usize) -> std::ops::Range<usize> {
        self.offsets[row]..self.offsets[row + 1]
    }

    /// Items of a row.
    pub(crate) fn row(&self, row: usize) -> &[u32] {
        &self.items[self.range(row)]
    }

    /// Items of all rows.
    pub(crate) fn len(&self) -> usize {
        self.items.len()
    }
}

/// Some nodes of a mesh, increasing, and the way from a node to its place among them.
#[derive(Clone, Debug)]
pub(crate) struct Places {
    nodes: Vec<u32>,
    /// 1 + place, or 0.
    places: Vec<u32>,
}

impl Places {
    /// Of `nodes` in any order, repeated or not, out of `count`.
    pub(crate) fn new(count: usize, nodes: impl Iterator<Item = u32>) -> Self {
        let mut places = vec![0u32; count];
        nodes.for_each(|node| places[node as usize] = 1);
        let mut list = Vec::new();
        for (node, place) in places.iter_mut().enumerate() {
            if *place == 1 {
                list.push(node as u32);
                *place = list.len() as u32;
            }
        }
        Self {
            nodes: list,
            places,
        }
    }

    /// The nodes, increasing.
    pub(crate) fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Place of a node among them.
    pub(crate) fn of(&self, node: u32) -> Option<usize> {
        (self.places[node as usize] as usize).checked_sub(1)
    }

    /// Elements around each of the nodes, increasing.
    pub(crate) fn elements(&self, elements: &[[u32; 8]]) -> Incidence {
        Incidence::new(self.nodes.len(), || {
            elements.iter().enumerate().flat_map(|(e, corners)| {
                corners
                    .iter()
                    .filter_map(move |node| Some((self.of(*node)?, e as u32)))
            })
        })
    }
}
