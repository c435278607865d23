//! What is known of a body at one time, as two VTK grids.

use super::grids::{field, write_body, write_fractures};
use crate::elasticity::loads::Voigt;
use crate::elasticity::{ElasticityError, element_stress};
use crate::nonlinear::{FaceFields, State};
use crate::scene::Body;
use std::io::{self, Write};

/// Displacements, stresses and contact at one time.
#[derive(Clone, Debug)]
pub struct Fields<'a> {
    body: &'a Body,
    displacement: &'a [f64],
    stress: Vec<[f64; 6]>,
    /// α Δp per element [Pa], where it differs within a material.
    drained: Option<Vec<f64>>,
    faces: &'a FaceFields,
    states: Vec<f64>,
    flips: Vec<f64>,
}

impl<'a> Fields<'a> {
    /// From displacements in full numbering [m], the fields of the faces, the state that both belong to, and what creep has taken from the
    /// stress of elements.
    ///
    /// # Errors
    /// [`ElasticityError`] for a mesh that has no stresses.
    pub fn new(
        body: &'a Body,
        displacement: &'a [f64],
        faces: &'a FaceFields,
        state: &State,
        relaxed: impl IntoIterator<Item = (usize, Voigt)>,
    ) -> Result<Self, ElasticityError> {
        // σ = σ0 − α Δp I + C ε; what is applied of the loads of time 0 is applied of σ0 as well
        let initial = |region: usize, x: [f64; 3]| {
            let pores = &body.pore_changes[region];
            let drained = pores.drained() * body.histories[pores.history].at(state.time);
            let mut sigma = body.initial_stress_at(region, x);
            (0..3).for_each(|i| sigma[i] -= drained);
            sigma.map(|s| state.loaded * s)
        };
        let mut stress = element_stress(&body.mesh, &body.materials, displacement, initial)?;
        let drained = drained(body, state);
        for e in body.pore_fields.iter().flat_map(|field| &field.elements) {
            let (own, e) = (&mut stress[*e as usize], *e as usize);
            let p = drained.as_ref().map_or(0.0, |all| all[e]);
            (0..3).for_each(|i| own[i] -= p);
        }
        for (e, relaxed) in relaxed {
            (0..6).for_each(|k| stress[e][k] += relaxed[k]);
        }
        Ok(Self {
            body,
            displacement,
            stress,
            drained,
            faces,
            states: state.states.iter().map(|s| f64::from(s.code())).collect(),
            flips: state.flips.iter().map(|n| f64::from(*n)).collect(),
        })
    }

    /// Writes the hexahedra: point vectors `displacement` [m], cell fields `stress` (mean of the element, total: initial
    /// stress and pore pressure included, xx, yy, zz, xy, yz, xz [Pa]) and `material`; where the pore pressure differs within a material also
    /// `alphaDeltaP`, Biot's coefficient times its change [Pa].
    ///
    /// # Errors
    /// What the writer says.
    pub fn write_body(&self, out: &mut impl Write) -> io::Result<()> {
        let mut fields = vec![field("stress", 6, self.stress.as_flattened())];
        fields.extend(self.drained.as_ref().map(|p| field("alphaDeltaP", 1, p)));
        write_body(self.body, self.displacement, fields, out)
    }

    /// Writes the minus sides of the fracture faces: cell fields `traction`, `displacementJump` (n, t1, t2), `slip`,
    /// `stabilizationJump` (n, t1, t2), `aperture`, `fractureState`, `criticality`, `tauLimit`, `pressure`, `stateFlips`, `normal`, `t1`, `t2`, `fracture`;
    /// where friction follows the path of slip also `cumulatedSlip`; with a fluid also `flux` (x, y, z, per width [m²/s]) and `conductivity` [m³].
    ///
    /// # Errors
    /// What the writer says.
    pub fn write_fracture(&self, out: &mut impl Write) -> io::Result<()> {
        let f = self.faces;
        let mut fields = vec![
            field("traction", 3, &f.traction),
            field("displacementJump", 3, &f.jump),
            field("slip", 1, &f.slip),
            field("stabilizationJump", 3, &f.stabilization_jump),
            field("aperture", 1, &f.aperture),
            field("fractureState", 1, &self.states),
            field("criticality", 1, &f.criticality),
            field("tauLimit", 1, &f.tau_limit),
            field("pressure", 1, &f.pressure),
            field("stateFlips", 1, &self.flips),
        ];
        if !f.path.is_empty() {
            fields.push(field("cumulatedSlip", 1, &f.path));
        }
        if !f.flux.is_empty() {
            fields.push(field("flux", 3, &f.flux));
            fields.push(field("conductivity", 1, &f.conductivity));
        }
        write_fractures(self.body, fields, out)
    }
}

/// α Δp per element [Pa], uniform ones included; `None` where all are uniform.
fn drained(body: &Body, state: &State) -> Option<Vec<f64>> {
    let all = &body.pore_fields;
    let uniform = |region: &u16| {
        let pores = &body.pore_changes[usize::from(*region)];
        state.loaded * pores.drained() * body.histories[pores.history].at(state.time)
    };
    let mut drained: Vec<f64> = match all.is_empty() {
        true => return None,
        false => body.mesh.regions.iter().map(uniform).collect(),
    };
    for field in all {
        for (e, p) in field.elements.iter().zip(field.drained(state.time)) {
            drained[*e as usize] = state.loaded * p;
        }
    }
    Some(drained)
}
