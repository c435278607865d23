//! Faces that physical surfaces select.

use super::faces::{Face, mean};
use super::{GmshDefect, GmshError, GmshMesh, GroupName};

/// What a surface is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceUse {
    /// A fracture: hexahedra on both sides.
    Fracture,
    /// A boundary condition: a hexahedron on one side.
    Boundary,
}

/// Faces of the body on physical surfaces, each once.
#[derive(Clone, Debug)]
pub struct Surface {
    /// First side of every face in order of the elements; a fracture has the second one right behind it.
    pub(super) faces: Vec<Face>,
}

impl GmshMesh {
    /// The faces on the physical surfaces `names`, in order of their elements whatever the order of the quadrilaterals.
    ///
    /// # Errors
    /// [`GmshError`]: a name that no surface has, elements that are no quadrilaterals, a quadrilateral that is no face of
    /// the body, or lies where `used` cannot have it.
    pub fn surface(&self, names: &[GroupName], used: SurfaceUse) -> Result<Surface, GmshError> {
        let mut faces = Vec::new();
        for name in names {
            let found = self.physical_surface(name, used);
            faces.extend(found.map_err(|defect| self.file.error(defect))?);
        }
        faces.sort_unstable_by_key(|sides: &[Face; 2]| (sides[0].1, sides[0].2));
        faces.dedup();
        let faces = match used {
            SurfaceUse::Fracture => faces.into_iter().flatten().collect(),
            SurfaceUse::Boundary => faces.into_iter().map(|sides| sides[0]).collect(),
        };
        Ok(Surface { faces })
    }

    /// Both sides of every face; a boundary has its one side twice.
    fn physical_surface(
        &self,
        name: &GroupName,
        used: SurfaceUse,
    ) -> Result<Vec<[Face; 2]>, GmshDefect> {
        let file = &self.file;
        let numbers = file.groups.find(2, name)?;
        let is_here = |set: u32| file.groups.touches(set, &numbers);
        let others = file.others.iter();
        if let Some(other) = others
            .clone()
            .find(|o| o.kind.dimension == 2 && is_here(o.set))
        {
            let alike = others.filter(|o| o.kind == other.kind && is_here(o.set));
            return Err(GmshDefect::NotQuadrilaterals {
                surface: name.clone(),
                count: alike.map(|o| o.count).sum(),
                kind: other.kind.name,
                element: other.first,
                center: other.center,
            });
        }
        let quads: Vec<_> = file
            .quadrilaterals
            .iter()
            .filter(|q| is_here(q.set))
            .collect();
        if quads.is_empty() {
            return Err(GmshDefect::EmptyGroup {
                dimension: "surface",
                name: name.clone(),
                elements: "quadrilateral",
            });
        }
        let mut faces = Vec::with_capacity(quads.len());
        let mut astray = None;
        for quad in &quads {
            let (surface, element) = (name.clone(), quad.id);
            let center = mean(&quad.nodes.map(|n| file.nodes[n as usize]));
            match (self.faces.sides(quad.nodes), used) {
                ([first, second], SurfaceUse::Fracture) => faces.push([*first, *second]),
                ([first], SurfaceUse::Boundary) => faces.push([*first, *first]),
                ([_], SurfaceUse::Fracture) => {
                    return Err(GmshDefect::FractureOutside {
                        surface,
                        element,
                        center,
                    });
                }
                ([first, second, ..], SurfaceUse::Boundary) => {
                    return Err(GmshDefect::BoundaryInside {
                        surface,
                        element,
                        center,
                        first: file.hexahedra[first.1 as usize].id,
                        second: file.hexahedra[second.1 as usize].id,
                    });
                }
                _ => astray = astray.or(Some((element, center))),
            }
        }
        match astray {
            None => Ok(faces),
            Some((element, center)) if faces.is_empty() => Err(GmshDefect::TouchesNothing {
                surface: name.clone(),
                count: quads.len(),
                element,
                center,
            }),
            Some((element, center)) => Err(GmshDefect::NoFace {
                surface: name.clone(),
                element,
                center,
            }),
        }
    }
}
