//! Elements of a mesh in groups that fill a register, in tasks that may run in parallel.
#![allow(unsafe_code, reason = "writes of tasks that share no entry")]

use fracas_operators::shared::Colours;
use std::ops::Range;

/// Elements of one task, at least and at most. A task reads the nodes that it shares with its neighbours again, so that large tasks
/// move less memory; small meshes need enough of them for the threads.
const TASK: std::ops::RangeInclusive<usize> = 512..=2048;

/// Tasks of a mesh between those limits.
const TASKS: usize = 64;

/// Where the corner values of a group of elements are.
#[derive(Clone, Copy, Debug)]
pub(super) enum Nodes {
    /// Neighbours along x on four lines of consecutive nodes: the first node of each line, `[along y][along z]`.
    Lines([[u32; 2]; 2]),
    /// The same of so many elements, fewer than a register has lanes.
    Short([[u32; 2]; 2], u8),
    /// Any elements: the place of the first in the list of nodes by element.
    Any(usize),
}

/// The elements of a group, at most as many as a register has lanes, and their nodes.
pub(super) struct Group {
    pub(super) elements: Vec<usize>,
    /// How many of them, at the beginning, belong to the group before and count nothing here.
    pub(super) repeated: usize,
    /// First nodes of their node lines, if they are neighbours along x.
    pub(super) lines: Option<[[u32; 2]; 2]>,
}

/// Groups of `width` elements with nodes in lexicographic order: neighbours on node lines where they follow each other in
/// the mesh, the others as they come. What is left of a line of neighbours, if it fills more than a quarter of a group, makes one
/// with the last of the group before, or by itself where there is none.
pub(super) fn groups(elements: &[[u32; 8]], width: usize) -> Vec<Group> {
    let (mut groups, mut others, mut e) = (Vec::new(), Vec::new(), 0);
    // one behind the last element of the last whole group on node lines
    let mut lined = 0;
    while e < elements.len() {
        let run = run(&elements[e..elements.len().min(e + width)]);
        if run == width {
            groups.push(Group {
                elements: (e..e + width).collect(),
                repeated: 0,
                lines: Some(lines(&elements[e])),
            });
            e += width;
            lined = e;
            continue;
        }
        if lined == e
            && e > 0
            && let Some(rest) = overlapping(elements, e, width)
        {
            let first = e + rest - width;
            groups.push(Group {
                elements: (first..e + rest).collect(),
                repeated: width - rest,
                lines: Some(lines(&elements[first])),
            });
            e += rest;
            continue;
        }
        if run > width / 4 {
            groups.push(Group {
                elements: (e..e + run).collect(),
                repeated: 0,
                lines: Some(lines(&elements[e])),
            });
            e += run;
            continue;
        }
        others.push(e);
        e += 1;
        if others.len() == width {
            let elements = std::mem::take(&mut others);
            groups.push(Group {
                elements,
                repeated: 0,
                lines: None,
            });
        }
    }
    if !others.is_empty() {
        groups.push(Group {
            elements: others,
            repeated: 0,
            lines: None,
        });
    }
    groups
}

/// How many elements from e on continue the node lines of those before, if they are more than a quarter of `width`.
fn overlapping(elements: &[[u32; 8]], e: usize, width: usize) -> Option<usize> {
    let most = width.min(elements.len() - e + 1);
    let follow = |rest: &usize| run(&elements[e + rest - width..e + rest]) == width;
    (width / 4 + 1..most).rev().find(follow)
}

/// How many elements, from the first on, are each the neighbour along x of the one before, on four node lines that do not overlap.
fn run(elements: &[[u32; 8]]) -> usize {
    let first = &elements[0];
    let follows = |l: usize, nodes: &[u32; 8]| {
        (0..8).all(|m| nodes[m] as usize == first[m & !1] as usize + l + (m & 1))
    };
    let neighbours = elements
        .iter()
        .enumerate()
        .take_while(|(l, nodes)| follows(*l, nodes));
    let mut starts = [0, 2, 4, 6].map(|m| first[m]);
    starts.sort_unstable();
    let apart = starts.windows(2).map(|s| (s[1] - s[0]) as usize).min();
    neighbours.count().min(apart.unwrap_or(0).saturating_sub(1))
}

/// First nodes of the four node lines of an element: `[along y][along z]`.
fn lines(first: &[u32; 8]) -> [[u32; 2]; 2] {
    [0, 1].map(|y| [0, 1].map(|z| first[2 * y + 4 * z]))
}

/// Consecutive groups in tasks, coloured first come first served; the colours depend on the groups
/// alone.
pub(super) fn coloured(
    groups: &[Group],
    elements: &[[u32; 8]],
    nodes: usize,
    width: usize,
) -> Colours<Range<usize>> {
    /// Colours that fit a mask of 64 bits; tasks beyond them, on meshes numbered at random, run alone.
    const MASKED: usize = 64;
    let mut used = vec![0u64; nodes];
    let mut colours: Vec<Vec<Range<usize>>> = Vec::new();
    let mut alone = Vec::new();
    let per_task = (elements.len() / TASKS).clamp(*TASK.start(), *TASK.end()) / width;
    for first in (0..groups.len()).step_by(per_task) {
        let task = first..groups.len().min(first + per_task);
        let members = || groups[task.clone()].iter().flat_map(|g| &g.elements);
        let nodes = || members().flat_map(|e| elements[*e]);
        let taken = nodes().fold(0, |mask, node| mask | used[node as usize]);
        let colour = taken.trailing_ones() as usize;
        if colour == MASKED {
            alone.push(vec![task]);
            continue;
        }
        nodes().for_each(|node| used[node as usize] |= 1 << colour);
        if colour == colours.len() {
            colours.push(Vec::new());
        }
        colours[colour].push(task);
    }
    colours.append(&mut alone);
    // SAFETY: a task takes a colour that no task before it at any of its nodes has.
    unsafe { Colours::new(colours) }
}
