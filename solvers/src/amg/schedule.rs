//! The order of a Gauss–Seidel sweep: chunks of rows in colours.

use super::node_map::NONE;

/// Block rows per chunk. A chunk is swept by one thread in ascending order; chunks of one colour share neither an entry nor a
/// neighbour.
const CHUNK: usize = 512;

/// Chunks of consecutive rows grouped by colour, fixed by the pattern alone: a sweep visits colour after colour, so it
/// gives the same bits for any number of threads.
#[derive(Clone, Debug)]
pub(super) struct Schedule {
    rows: usize,
    /// Colour of every chunk.
    colour: Vec<u32>,
    /// Chunks of every colour.
    groups: Vec<Vec<u32>>,
}

impl Schedule {
    /// Greedy colouring of the chunk graph: chunks two steps apart differ.
    pub(super) fn new(offsets: &[usize], columns: &[u32]) -> Self {
        let rows = offsets.len() - 1;
        let chunks = rows.div_ceil(CHUNK);
        let neighbours = chunk_graph(offsets, columns, chunks);
        let mut colour: Vec<u32> = Vec::with_capacity(chunks);
        let mut groups: Vec<Vec<u32>> = Vec::new();
        for chunk in 0..chunks {
            let near = neighbours[chunk].iter();
            let near = near.flat_map(|c| neighbours[*c as usize].iter().chain([c]));
            let earlier = near.filter(|c| (**c as usize) < chunk);
            let taken: Vec<u32> = earlier.map(|c| colour[*c as usize]).collect();
            let free = (0..).find(|c| !taken.contains(c)).unwrap_or(0);
            if free as usize == groups.len() {
                groups.push(Vec::new());
            }
            groups[free as usize].push(chunk as u32);
            colour.push(free);
        }
        Self {
            rows,
            colour,
            groups,
        }
    }

    /// True when a sweep visits row j before row i.
    #[inline(always)]
    pub(super) fn before(&self, j: usize, i: usize) -> bool {
        let (a, b) = (j / CHUNK, i / CHUNK);
        if a == b {
            j < i
        } else {
            self.colour[a] < self.colour[b]
        }
    }

    /// Chunks of every colour, in the order of a forward sweep.
    pub(super) fn groups(&self) -> &[Vec<u32>] {
        &self.groups
    }

    /// Rows of a chunk.
    pub(super) fn chunk(&self, chunk: u32) -> std::ops::Range<usize> {
        let first = chunk as usize * CHUNK;
        first..self.rows.min(first + CHUNK)
    }
}

/// Chunks that share an entry, in both directions whatever the pattern.
fn chunk_graph(offsets: &[usize], columns: &[u32], chunks: usize) -> Vec<Vec<u32>> {
    let mut graph: Vec<Vec<u32>> = vec![Vec::new(); chunks];
    let mut seen = vec![NONE; chunks];
    for chunk in 0..chunks {
        let last = (offsets.len() - 1).min((chunk + 1) * CHUNK);
        for j in &columns[offsets[chunk * CHUNK]..offsets[last]] {
            let other = *j as usize / CHUNK;
            if other != chunk && seen[other] != chunk as u32 {
                seen[other] = chunk as u32;
                graph[chunk].push(other as u32);
                graph[other].push(chunk as u32);
            }
        }
    }
    graph
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_of_one_colour_share_no_neighbour_and_every_row_is_visited_once() {
        // a ring of rows with long couplings
        let n = 5000;
        let (mut offsets, mut columns) = (vec![0], Vec::new());
        for i in 0..n {
            let mut row = [
                i,
                (i + 1) % n,
                (i + n - 1) % n,
                (i + 900) % n,
                (i + n - 900) % n,
            ];
            row.sort_unstable();
            columns.extend(row.map(|j| j as u32));
            offsets.push(columns.len());
        }
        let schedule = Schedule::new(&offsets, &columns);
        let mut visited = vec![0; n];
        for group in schedule.groups() {
            for chunk in group {
                schedule.chunk(*chunk).for_each(|i| visited[i] += 1);
            }
        }
        assert!(visited.iter().all(|v| *v == 1));
        for i in 0..n {
            for j in &columns[offsets[i]..offsets[i + 1]] {
                let j = *j as usize;
                let orders = [schedule.before(j, i), schedule.before(i, j)];
                assert!(
                    i == j || orders[0] != orders[1],
                    "rows {i} and {j} are not ordered"
                );
            }
        }
    }
}
