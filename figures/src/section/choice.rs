//! Planes that show a body and its fractures.

use super::plane::{Plane, cross, dot, is_same, unit};
use fracas::scene::Body;

/// Planes at most.
const PLANES: usize = 3;

/// Sine squared of the angle between a fracture and a plane above which the plane shows it.
const STEEP: f64 = 0.25;

/// Elements across a body up to which it is a sheet, and shown along that. Unit: 1.
const SHEET: f64 = 2.5;

/// Share of the largest section below which one shows little. Unit: 1.
const SMALL: f64 = 0.05;

/// What a section through all materials is worth beside one across all fractures. Unit: 1.
const LAYERS: f64 = 0.5;

/// What of a normal of lower rank counts.
const PREFERENCE: f64 = 0.02;

/// A fracture by its faces.
struct Fault {
    area: f64,
    /// Of length 1.
    normal: [f64; 3],
    center: [f64; 3],
    nodes: Vec<[f64; 3]>,
}

/// Some planes, the first of which shows most: across the fractures, and along a body that is a sheet. One that goes through a fracture
/// goes through its middle, and through the middle of an element.
///
/// # Cost
/// O(elements) per direction looked at, of which there are eight or fewer.
pub fn planes(body: &Body) -> Vec<Plane> {
    let faults = faults(body);
    let view = View::new(body, faults.first());
    let mut planes: Vec<Plane> = Vec::new();
    let mut left: Vec<&Fault> = faults.iter().collect();
    while planes.len() < PLANES && (planes.is_empty() || !left.is_empty()) {
        let normal = view.normal(&left, planes.is_empty());
        let offset = view.offset(normal, &left);
        let plane = Plane { normal, offset };
        let before = left.len();
        left.retain(|fault| !fault.is_shown(&plane));
        let is_new = planes
            .iter()
            .all(|p| !is_same(p.normal, normal) || p.offset != offset);
        if is_new && (planes.is_empty() || left.len() < before) {
            planes.push(plane);
        } else {
            // no plane shows these
            break;
        }
    }
    planes
}

fn faults(body: &Body) -> Vec<Fault> {
    let place = |a: &u32| body.mesh.nodes[*a as usize];
    let mut faults: Vec<Fault> = Vec::new();
    for k in 0..body.fractures.names.len() {
        let faces = body.fractures.faces.iter();
        let own: Vec<_> = faces.filter(|f| usize::from(f.fracture) == k).collect();
        let area: f64 = own.iter().map(|f| f.area).sum();
        let sum = |of: &dyn Fn(usize) -> [f64; 3]| {
            let mut sum = [0.0; 3];
            for (f, face) in own.iter().enumerate() {
                let value = of(f);
                (0..3).for_each(|k| sum[k] += face.area * value[k]);
            }
            sum
        };
        let normal = sum(&|f| own[f].frame[0]);
        // a closed surface has none, and every plane shows it
        if area > 0.0 && dot(normal, normal).sqrt() > 0.1 * area {
            faults.push(Fault {
                area,
                normal: unit(normal),
                center: sum(&|f| own[f].center).map(|x| x / area),
                nodes: (own.iter().flat_map(|f| f.minus.nodes.iter()))
                    .map(place)
                    .collect(),
            });
        }
    }
    faults.sort_by(|a, b| b.area.total_cmp(&a.area));
    faults
}

impl Fault {
    /// Sine squared of its angle with planes of this normal.
    fn steepness(&self, normal: [f64; 3]) -> f64 {
        1.0 - dot(self.normal, normal).powi(2)
    }

    fn ends(&self, normal: [f64; 3]) -> [f64; 2] {
        ends(normal, &self.nodes)
    }

    fn is_shown(&self, plane: &Plane) -> bool {
        let [low, high] = self.ends(plane.normal);
        self.steepness(plane.normal) > STEEP && (low..=high).contains(&plane.offset)
    }
}

fn ends(normal: [f64; 3], nodes: &[[f64; 3]]) -> [f64; 2] {
    let at = nodes.iter().map(|x| dot(normal, *x));
    at.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| {
        [a.min(x), b.max(x)]
    })
}

/// Directions to look along, and what each shows.
struct View<'a> {
    body: &'a Body,
    middle: [f64; 3],
    /// Normals, those that are preferred first.
    normals: Vec<[f64; 3]>,
    /// Elements that a plane through the middle cuts.
    cut: Vec<f64>,
    /// Share of the materials that it cuts, more than one.
    layers: Vec<f64>,
    /// Extent within the planes [m²].
    areas: Vec<f64>,
}

impl<'a> View<'a> {
    fn new(body: &'a Body, largest: Option<&Fault>) -> Self {
        let nodes = &body.mesh.nodes;
        let count = nodes.len() as f64;
        let middle = [0, 1, 2].map(|k| nodes.iter().map(|x| x[k]).sum::<f64>() / count);
        let mut normals = vec![[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
        let mut add = |normal: [f64; 3]| {
            if normals.iter().all(|other| !is_same(*other, normal)) {
                normals.push(normal);
            }
        };
        // upright planes across the largest fracture, then level ones, then along what is thin
        if let Some(fault) = largest
            && fault.normal[0].hypot(fault.normal[1]) > 0.05
        {
            add(unit([-fault.normal[1], fault.normal[0], 0.0]));
        }
        add([0.0, 0.0, 1.0]);
        thin(nodes, middle).into_iter().for_each(&mut add);
        let mesh = &body.mesh;
        let materials = body.materials.len();
        let through = |normal: &[f64; 3]| {
            let offset = dot(*normal, middle);
            let side = |a: &u32| dot(*normal, nodes[*a as usize]) < offset;
            let (mut cut, mut met) = (0usize, vec![false; materials]);
            for (e, region) in mesh.elements.iter().zip(&mesh.regions) {
                let below = e.iter().filter(|a| side(a)).count();
                if below != 0 && below != 8 {
                    cut += 1;
                    met[usize::from(*region)] = true;
                }
            }
            let met = met.into_iter().filter(|met| *met).count();
            let layers = met.saturating_sub(1) as f64 / materials.saturating_sub(1).max(1) as f64;
            (cut.max(1) as f64, layers)
        };
        let (cut, layers) = normals.iter().map(through).unzip();
        let area = |normal: &[f64; 3]| {
            let [a, b] = super::in_plane(*normal, std::iter::empty()).map(|d| {
                let [low, high] = ends(d.along, nodes);
                high - low
            });
            a * b
        };
        Self {
            body,
            middle,
            cut,
            layers,
            areas: normals.iter().map(area).collect(),
            normals,
        }
    }

    /// The normal that shows these fractures best, and, in the first section of a body, its materials.
    fn normal(&self, faults: &[&Fault], is_first: bool) -> [f64; 3] {
        let all = self.body.mesh.elements.len() as f64;
        let is_sheet: Vec<bool> = self.cut.iter().map(|cut| all / cut <= SHEET).collect();
        let has_sheet = is_sheet.contains(&true);
        let largest = self.areas.iter().fold(0.0f64, |m, a| m.max(*a));
        let total: f64 = faults.iter().map(|f| f.area).sum();
        let worth = |k: usize| {
            let steep = faults.iter().map(|f| f.area * f.steepness(self.normals[k]));
            // a body without fractures is shown as a whole
            let shown = match total > 0.0 {
                true => 0.05 + steep.sum::<f64>() / total,
                false => 1.0,
            };
            let large = (self.areas[k] / (SMALL * largest)).min(1.0);
            let sheet = if has_sheet && !is_sheet[k] { 0.0 } else { 1.0 };
            let layers = if is_first {
                LAYERS * self.layers[k]
            } else {
                0.0
            };
            sheet * (shown + layers) * large - PREFERENCE * k as f64
        };
        let best = (0..self.normals.len()).max_by(|i, j| worth(*i).total_cmp(&worth(*j)));
        best.map_or([0.0, 1.0, 0.0], |k| self.normals[k])
    }

    /// Through as much of these fractures as can be, near the middle, in the middle of an element.
    fn offset(&self, normal: [f64; 3], faults: &[&Fault]) -> f64 {
        let middle = dot(normal, self.middle);
        let seen: Vec<&&Fault> = (faults.iter())
            .filter(|f| f.steepness(normal) > STEEP)
            .collect();
        let crossed = |at: f64| {
            let crosses = |f: &&&&Fault| {
                let [low, high] = f.ends(normal);
                (low..=high).contains(&at)
            };
            seen.iter().filter(crosses).map(|f| f.area).sum::<f64>()
        };
        let centers = seen.iter().map(|f| dot(normal, f.center));
        let wanted = std::iter::once(middle)
            .chain(centers)
            .map(|at| (crossed(at), -(at - middle).abs(), at))
            .max_by(|p, q| p.0.total_cmp(&q.0).then(p.1.total_cmp(&q.1)))
            .map_or(middle, |(.., at)| at);
        // where two elements are as near the lower one, whatever rounding says
        let [low, high] = ends(normal, &self.body.mesh.nodes);
        let even = 1e-9 * (high - low);
        let mesh = &self.body.mesh;
        let centers = mesh.elements.iter().map(|nodes| {
            let sum = nodes.iter().map(|a| dot(normal, mesh.nodes[*a as usize]));
            sum.sum::<f64>() / 8.0
        });
        let nearest = centers.fold((f64::INFINITY, wanted), |(best, found), at| {
            let distance = (at - wanted).abs();
            match distance < best - even || (distance < best + even && at < found - even) {
                true => (distance, at),
                false => (best, found),
            }
        });
        nearest.1
    }
}

/// The principal directions of nodes, where one of them is far shorter than the others: that of least extent first.
fn thin(nodes: &[[f64; 3]], middle: [f64; 3]) -> Vec<[f64; 3]> {
    let mut moments = [[0.0; 3]; 3];
    for x in nodes {
        for i in 0..3 {
            for j in 0..3 {
                moments[i][j] += (x[i] - middle[i]) * (x[j] - middle[j]);
            }
        }
    }
    let trace = moments[0][0] + moments[1][1] + moments[2][2];
    // powers of tr I − M draw any vector towards the direction of least extent
    let shifted = [0, 1, 2]
        .map(|i: usize| [0, 1, 2].map(|j: usize| if i == j { trace } else { 0.0 } - moments[i][j]));
    let mut v = unit([0.31, 0.47, 0.83]);
    for _ in 0..200 {
        v = unit([0, 1, 2].map(|i: usize| dot(shifted[i], v)));
    }
    let spread = |v: [f64; 3]| dot(v, [0, 1, 2].map(|i: usize| dot(moments[i], v)));
    if spread(v) > 0.05 * trace {
        return Vec::new();
    }
    let level = match v[0].hypot(v[1]) {
        flat if flat < 1e-9 => [1.0, 0.0, 0.0],
        _ => unit([-v[1], v[0], 0.0]),
    };
    vec![v, level, cross(v, level)]
}

#[cfg(test)]
mod tests;
