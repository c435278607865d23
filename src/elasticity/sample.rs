//! Small structured meshes for tests and benches.

use crate::mesh::{Grid, HexMesh};

/// How a sample mesh departs from a uniform box.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sample {
    /// Cells per axis.
    pub(crate) cells: [usize; 3],
    /// Ratio of neighbouring cell lengths minus one.
    pub(crate) grading: f64,
    /// Amplitude of the map that moves nodes, in cell lengths; 0 keeps bricks.
    pub(crate) distortion: f64,
    /// Number of regions, scattered over the elements.
    pub(crate) regions: u16,
    /// Doubles the nodes of the lower half (in y) of the middle plane in x.
    pub(crate) split: bool,
}

fn lines(cells: usize, grading: f64) -> Vec<f64> {
    let mut line = vec![0.0];
    let mut h = 1.0;
    for i in 0..cells {
        line.push(line[i] + h);
        h *= 1.0 + grading;
    }
    line
}

/// The structured box described by `sample`.
pub(crate) fn mesh(sample: Sample) -> HexMesh {
    let [nx, ny, nz] = sample.cells;
    let lines = sample.cells.map(|n| lines(n, sample.grading));
    let index = |i: usize, j: usize, k: usize| (i + (nx + 1) * (j + (ny + 1) * k)) as u32;
    let mut nodes = Vec::new();
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                let x = [lines[0][i], lines[1][j], lines[2][k]];
                let s = sample.distortion;
                nodes.push([
                    x[0] + s * (x[1] + 0.7 * x[2]).sin(),
                    x[1] + s * (1.3 * x[2] - 0.4 * x[0]).sin(),
                    x[2] + s * (0.9 * x[0] + x[1]).cos(),
                ]);
            }
        }
    }
    let (mut elements, mut regions) = (Vec::new(), Vec::new());
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let bottom = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                elements.push(std::array::from_fn(|a| {
                    let (i, j) = bottom[a % 4];
                    index(i, j, k + a / 4)
                }));
                regions.push(((i + 2 * j + 5 * k) % usize::from(sample.regions.max(1))) as u16);
            }
        }
    }
    let mut origin: Vec<u32> = (0..nodes.len() as u32).collect();
    if sample.split {
        for k in 0..=nz {
            for j in 0..ny.div_ceil(2) {
                let original = index(nx / 2, j, k);
                let copy = nodes.len() as u32;
                nodes.push(nodes[original as usize]);
                origin.push(original);
                for (e, element) in elements.iter_mut().enumerate() {
                    if e % nx >= nx / 2 {
                        element
                            .iter_mut()
                            .filter(|n| **n == original)
                            .for_each(|n| *n = copy);
                    }
                }
            }
        }
    }
    HexMesh {
        nodes,
        elements,
        regions,
        origin,
        grid: Some(Grid {
            cells: sample.cells,
            lines,
            axis_aligned: sample.distortion == 0.0,
        }),
    }
}
