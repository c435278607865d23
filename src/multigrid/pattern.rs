//! Which blocks a remainder may have.

use super::elements::Elements;
use super::grid::Grid;
use rayon::prelude::*;
use std::ops::Range;

/// Block rows that one task collects.
const ROWS_PER_TASK: usize = 2048;

/// Block columns per block row, ascending.
#[derive(Clone, Debug)]
pub(super) struct Pattern {
    pub(super) offsets: Vec<usize>,
    pub(super) columns: Vec<u32>,
}

impl Pattern {
    /// All pairs of corners of an element that is no brick, and all pairs of corners of two linked elements.
    pub(super) fn new(grid: &Grid<'_>, kinds: &[u16], links: &[[u32; 2]]) -> Self {
        let loose = || {
            let kinds = kinds.iter().enumerate();
            kinds
                .filter(|(_, kind)| **kind == Elements::NONE)
                .map(|(e, _)| e)
        };
        let link_corners = |link: &[u32; 2]| link.map(|e| grid.elements[e as usize]);
        // node → elements, then links behind them
        let mut first = vec![0u32; grid.nodes + 1];
        let mut count = |corners: &[u32]| {
            corners.iter().for_each(|n| first[*n as usize + 1] += 1);
        };
        loose().for_each(|e| count(&grid.elements[e]));
        links
            .iter()
            .for_each(|link| count(link_corners(link).as_flattened()));
        for n in 0..grid.nodes {
            first[n + 1] += first[n];
        }
        let mut next = first.clone();
        let mut around = vec![0u32; first[grid.nodes] as usize];
        let mut enter = |corners: &[u32], group: usize| {
            for n in corners {
                around[next[*n as usize] as usize] = group as u32;
                next[*n as usize] += 1;
            }
        };
        loose().for_each(|e| enter(&grid.elements[e], e));
        for (l, link) in links.iter().enumerate() {
            enter(link_corners(link).as_flattened(), grid.elements.len() + l);
        }

        let starts: Vec<usize> = (0..grid.nodes).step_by(ROWS_PER_TASK).collect();
        let parts: Vec<(Vec<u32>, Vec<u32>)> = starts
            .par_iter()
            .map(|start| {
                let (mut lengths, mut columns) = (Vec::new(), Vec::new());
                let mut row: Vec<u32> = Vec::new();
                for n in *start..grid.nodes.min(start + ROWS_PER_TASK) {
                    row.clear();
                    for group in &around[first[n] as usize..first[n + 1] as usize] {
                        match (*group as usize).checked_sub(grid.elements.len()) {
                            None => row.extend(grid.elements[*group as usize]),
                            Some(l) => row.extend(link_corners(&links[l]).as_flattened()),
                        }
                    }
                    row.sort_unstable();
                    row.dedup();
                    lengths.push(row.len() as u32);
                    columns.extend_from_slice(&row);
                }
                (lengths, columns)
            })
            .collect();
        let mut offsets = Vec::with_capacity(grid.nodes + 1);
        offsets.push(0);
        let mut columns = Vec::with_capacity(parts.iter().map(|p| p.1.len()).sum());
        let mut end = 0;
        for (lengths, part) in parts {
            for length in lengths {
                end += length as usize;
                offsets.push(end);
            }
            columns.extend(part);
        }
        Self { offsets, columns }
    }

    /// Where a row stands.
    pub(super) fn range(&self, row: usize) -> Range<usize> {
        self.offsets[row]..self.offsets[row + 1]
    }

    /// Where block (row, column) stands.
    pub(super) fn place(&self, row: usize, column: u32) -> usize {
        let range = self.range(row);
        let at = range.start + self.columns[range].partition_point(|c| *c < column);
        debug_assert_eq!(self.columns[at], column);
        at
    }
}
