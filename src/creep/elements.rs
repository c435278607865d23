//! The elements that creep: their history as a load, what a step adds to it, what it dissipates.

use super::Rule;
use crate::elasticity::element::{GaussPoints, Inverted, gauss_point, shape_functions};
use crate::elasticity::loads::{VOIGT, Voigt};
use crate::elasticity::{Elastic, ElasticityError};
use crate::mesh::HexMesh;
use rayon::prelude::*;

/// Elements of one task.
const ELEMENTS_PER_TASK: usize = 256;

/// Where rock is stressed before any displacement.
pub trait Initial: Sync {
    /// σ0 at a point of a region [Pa].
    fn stress(&self, region: usize, x: [f64; 3]) -> Voigt;
}

/// Rock of which some elements creep; ε_v is a tensor (xx, yy, zz, xy, yz, xz, no factor 2 in shear) per integration point, eight per
/// creeping element in the order of the elements.
///
/// # Units
/// Displacements in full numbering [m], forces in full numbering [N], energies [J].
pub struct CreepingRock<'a> {
    mesh: &'a HexMesh,
    materials: &'a [Elastic],
    viscosities: &'a [Option<f64>],
    elements: Vec<u32>,
    initial: &'a dyn Initial,
}

/// What creeping elements do beyond an elastic A.
#[derive(Clone, Debug, PartialEq)]
pub struct Beyond {
    /// Nodal forces of their stresses, less those of A.
    pub force: Vec<f64>,
    /// Elastic energy, less `½ uᵀA u`.
    pub energy: f64,
}

impl<'a> CreepingRock<'a> {
    /// The elements whose region has a viscosity η [Pa·s]; `None` where there are none.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element.
    pub fn new(
        mesh: &'a HexMesh,
        materials: &'a [Elastic],
        viscosities: &'a [Option<f64>],
        initial: &'a dyn Initial,
    ) -> Result<Option<Self>, ElasticityError> {
        let creeps = |e: &u32| viscosities[usize::from(mesh.regions[*e as usize])].is_some();
        let elements: Vec<u32> = (0..mesh.elements.len() as u32).filter(creeps).collect();
        for e in &elements {
            let x = corners(mesh, *e);
            GaussPoints::new(&x).map_err(|source: Inverted| ElasticityError::Inverted {
                element: *e as usize,
                center: [0, 1, 2].map(|i| x.iter().map(|x| x[i]).sum::<f64>() / 8.0),
                source,
            })?;
        }
        Ok((!elements.is_empty()).then_some(Self {
            mesh,
            materials,
            viscosities,
            elements,
            initial,
        }))
    }

    /// The elements that creep, increasing.
    pub fn elements(&self) -> &[u32] {
        &self.elements
    }

    /// Integration points that creep.
    pub fn points(&self) -> usize {
        8 * self.elements.len()
    }

    /// Elastic constants that a step of `step` seconds sees, per region: G becomes φ G, K stays.
    pub fn materials_in(&self, step: f64) -> Vec<Elastic> {
        let of = |(rock, viscosity): (&Elastic, &Option<f64>)| match viscosity {
            Some(eta) => rock.with_shear_share(rule(rock, *eta, step).stiffness()),
            None => *rock,
        };
        self.materials
            .iter()
            .zip(self.viscosities)
            .map(of)
            .collect()
    }

    /// Forces of what a step of `step` seconds remembers: `−∫ Bᵀ(e^(−x) s − s0 − 2Gφ e) dV` at its start, s and s0 the deviators of the
    /// stress and of the initial one. With them `A u = f`, A of [`materials_in`](Self::materials_in), is equilibrium at its end.
    pub fn history(&self, step: f64, u: &[f64], strain: &[Voigt]) -> Vec<f64> {
        let (force, _) = self.summed(strain, |at, v| {
            let rule = at.rule(step);
            let (kept, stiff) = (rule.kept(), rule.stiffness());
            let e = at.deviator(u);
            let h = |q: usize, k: usize| {
                let [now, first] = [at.elastic(e[q], v[q]), at.initial[q]].map(|s| s[k]);
                // s = s0 + 2G (e − ε_v)
                (kept - 1.0) * first + kept * now - stiff * 2.0 * at.shear * e[q][k]
            };
            (
                std::array::from_fn(|q| std::array::from_fn(|k| -h(q, k))),
                0.0,
            )
        });
        force
    }

    /// ε_v at the end of a step of `step` seconds from `u[0]` to `u[1]`: `ε_v + (1 − φ) Δe + (1 − e^(−x)) s/2G`.
    pub fn advanced(&self, step: f64, u: [&[f64]; 2], strain: &[Voigt]) -> Vec<Voigt> {
        let of = |(e, v): (&u32, &[Voigt])| -> [Voigt; 8] {
            let at = self.at(*e);
            let rule = at.rule(step);
            let (flow, lost) = (rule.flow(), rule.lost() / (2.0 * at.shear));
            let [from, to] = u.map(|u| at.deviator(u));
            std::array::from_fn(|q| {
                let now = at.elastic(from[q], v[q]);
                std::array::from_fn(|k| {
                    v[q][k] + flow * (to[q][k] - from[q][k]) + lost * (now[k] + at.initial[q][k])
                })
            })
        };
        let all: Vec<[Voigt; 8]> = (self.elements.par_iter().with_min_len(ELEMENTS_PER_TASK))
            .zip(strain.par_chunks(8))
            .map(of)
            .collect();
        all.into_flattened()
    }

    /// Forces `∫ Bᵀ(2(G − G') e − 2G ε_v) dV` and energy `∫ (G − G') e:e − 2G e:ε_v + G ε_v:ε_v dV` beyond those of an A in which G' stands
    /// for G, that of steps of `step` seconds.
    pub fn beyond(&self, step: f64, u: &[f64], strain: &[Voigt]) -> Beyond {
        let (force, energy) = self.summed(strain, |at, v| {
            let less = at.shear * at.rule(step).flow();
            let e = at.deviator(u);
            let stress = std::array::from_fn(|q| {
                std::array::from_fn(|k| 2.0 * (less * e[q][k] - at.shear * v[q][k]))
            });
            let energy = |q: usize| {
                let own = less * product(e[q], e[q]) + at.shear * product(v[q], v[q]);
                at.points.weights[q] * (own - 2.0 * at.shear * product(e[q], v[q]))
            };
            (stress, (0..8).map(energy).sum())
        });
        Beyond { force, energy }
    }

    /// Work that creep takes of the stresses that come with strain, `∫ ½ (s̃ + s̃'):Δε_v dV`, s̃ = 2G(e − ε_v); and what it dissipates on the
    /// path of the step, `∫∫ s:s/(2η) dt dV`, which is never negative.
    pub fn work(&self, step: f64, u: [&[f64]; 2], strain: [&[Voigt]; 2]) -> [f64; 2] {
        let of = |n: usize| -> [f64; 2] {
            let at = self.at(self.elements[n]);
            let rule = at.rule(step);
            let [aa, ab, bb] = rule.squares();
            let [from, to] = u.map(|u| at.deviator(u));
            let mut sum = [0.0; 2];
            for q in 0..8 {
                let [v, w] = strain.map(|s| s[8 * n + q]);
                let [now, then] = [at.elastic(from[q], v), at.elastic(to[q], w)];
                let mean: Voigt = std::array::from_fn(|k| 0.5 * (now[k] + then[k]));
                let flowed: Voigt = std::array::from_fn(|k| w[k] - v[k]);
                let s: Voigt = std::array::from_fn(|k| now[k] + at.initial[q][k]);
                let d: Voigt = std::array::from_fn(|k| 2.0 * at.shear * (to[q][k] - from[q][k]));
                let square = aa * product(s, s) + 2.0 * ab * product(s, d) + bb * product(d, d);
                sum[0] += at.points.weights[q] * product(mean, flowed);
                sum[1] += at.points.weights[q] * step / (2.0 * at.viscosity) * square;
            }
            sum
        };
        let all: Vec<[f64; 2]> = (0..self.elements.len())
            .into_par_iter()
            .with_min_len(ELEMENTS_PER_TASK)
            .map(of)
            .collect();
        (all.into_iter()).fold([0.0; 2], |s, v| [s[0] + v[0], s[1] + v[1]])
    }

    /// Mean over every creeping element of what creep takes from its stress, `−2G ε_v`, in the order of the elements [Pa].
    pub fn relaxed<'s>(&'s self, strain: &'s [Voigt]) -> impl Iterator<Item = (usize, Voigt)> + 's {
        self.elements.iter().zip(strain.chunks(8)).map(|(e, v)| {
            let at = self.at(*e);
            let volume: f64 = at.points.weights.iter().sum();
            let mean = |k: usize| -> f64 {
                let integral = (0..8).map(|q| at.points.weights[q] * v[q][k]);
                -2.0 * at.shear * integral.sum::<f64>() / volume
            };
            (*e as usize, std::array::from_fn(mean))
        })
    }

    /// `Σ ∫ Bᵀ σ dV` and the sum of numbers, element by element in their order: the same bits for any number of threads.
    fn summed(
        &self,
        strain: &[Voigt],
        of: impl Fn(&Element<'_>, &[Voigt]) -> ([Voigt; 8], f64) + Sync,
    ) -> (Vec<f64>, f64) {
        assert_eq!(strain.len(), self.points(), "integration points that creep");
        let forces = |(e, v): (&u32, &[Voigt])| {
            let at = self.at(*e);
            let (stress, number) = of(&at, v);
            (at.forces(&stress), number)
        };
        let all: Vec<([[f64; 3]; 8], f64)> =
            (self.elements.par_iter().with_min_len(ELEMENTS_PER_TASK))
                .zip(strain.par_chunks(8))
                .map(forces)
                .collect();
        let (mut force, mut sum) = (vec![0.0; 3 * self.mesh.nodes.len()], 0.0);
        for (e, (of_nodes, number)) in self.elements.iter().zip(all) {
            for (node, f) in self.mesh.elements[*e as usize].iter().zip(of_nodes) {
                (0..3).for_each(|i| force[3 * *node as usize + i] += f[i]);
            }
            sum += number;
        }
        (force, sum)
    }

    fn at(&self, e: u32) -> Element<'_> {
        let region = usize::from(self.mesh.regions[e as usize]);
        let x = corners(self.mesh, e);
        let (Ok(points), Some(viscosity)) = (GaussPoints::new(&x), self.viscosities[region]) else {
            unreachable!("looked at by `new`");
        };
        let initial = std::array::from_fn(|q| {
            let shape = shape_functions(gauss_point(q));
            let place = [0, 1, 2].map(|i| (0..8).map(|a| shape[a] * x[a][i]).sum());
            deviatoric(self.initial.stress(region, place))
        });
        let rock = &self.materials[region];
        Element {
            nodes: &self.mesh.elements[e as usize],
            points,
            shear: rock.shear(),
            viscosity,
            initial,
        }
    }
}

/// One of them.
struct Element<'m> {
    nodes: &'m [u32; 8],
    points: GaussPoints,
    shear: f64,
    viscosity: f64,
    /// Deviator of the initial stress [Pa].
    initial: [Voigt; 8],
}

impl Element<'_> {
    fn rule(&self, step: f64) -> Rule {
        Rule::new(step, self.viscosity / self.shear)
    }

    /// Deviator of sym ∇u.
    fn deviator(&self, u: &[f64]) -> [Voigt; 8] {
        let mut slope = [[[0.0; 3]; 3]; 8];
        for (a, node) in self.nodes.iter().enumerate() {
            for (q, slope) in slope.iter_mut().enumerate() {
                for i in 0..3 {
                    for j in 0..3 {
                        slope[i][j] += u[3 * *node as usize + i] * self.points.gradients[a][j][q];
                    }
                }
            }
        }
        slope.map(|h| {
            let shear = |i: usize, j: usize| 0.5 * (h[i][j] + h[j][i]);
            deviatoric([
                h[0][0],
                h[1][1],
                h[2][2],
                shear(0, 1),
                shear(1, 2),
                shear(0, 2),
            ])
        })
    }

    /// 2G (e − ε_v).
    fn elastic(&self, e: Voigt, v: Voigt) -> Voigt {
        std::array::from_fn(|k| 2.0 * self.shear * (e[k] - v[k]))
    }

    /// ∫ Bᵀ σ dV.
    fn forces(&self, stress: &[Voigt; 8]) -> [[f64; 3]; 8] {
        std::array::from_fn(|a| {
            [0, 1, 2].map(|i| {
                let at = |q: usize| -> f64 {
                    let row =
                        (0..3).map(|j| self.points.gradients[a][j][q] * stress[q][VOIGT[i][j]]);
                    self.points.weights[q] * row.sum::<f64>()
                };
                (0..8).map(at).sum()
            })
        })
    }
}

fn rule(rock: &Elastic, viscosity: f64, step: f64) -> Rule {
    Rule::new(step, viscosity / rock.shear())
}

fn corners(mesh: &HexMesh, e: u32) -> [[f64; 3]; 8] {
    mesh.elements[e as usize].map(|node| mesh.nodes[node as usize])
}

fn deviatoric(s: Voigt) -> Voigt {
    let mean = (s[0] + s[1] + s[2]) / 3.0;
    [s[0] - mean, s[1] - mean, s[2] - mean, s[3], s[4], s[5]]
}

/// a : b.
fn product(a: Voigt, b: Voigt) -> f64 {
    let normal: f64 = (0..3).map(|k| a[k] * b[k]).sum();
    let shear: f64 = (3..6).map(|k| a[k] * b[k]).sum();
    normal + 2.0 * shear
}
