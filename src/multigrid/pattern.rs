//! Which blocks a remainder may have.

use super::elements::Elements;
use super::grid::Grid;
use fracas_operators::sparse::Pattern;

/// Block columns per block row: all pairs of corners of an element that is no brick, and all pairs of corners of two linked elements.
pub(super) fn pattern(grid: &Grid<'_>, kinds: &[u16], links: &[[u32; 2]]) -> Pattern {
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

    Pattern::collect(grid.nodes, Vec::new, |n, row: &mut Vec<u32>, columns| {
        row.clear();
        for group in &around[first[n] as usize..first[n + 1] as usize] {
            match (*group as usize).checked_sub(grid.elements.len()) {
                None => row.extend(grid.elements[*group as usize]),
                Some(l) => row.extend(link_corners(&links[l]).as_flattened()),
            }
        }
        row.sort_unstable();
        row.dedup();
        columns.extend_from_slice(row);
    })
}
