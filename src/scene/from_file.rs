//! A scene whose mesh comes from a Gmsh file.

use std::path::Path;

use super::geometry::regions;
use super::located::{Located, at};
use super::mesh_sections::AxisSection;
use super::sections::SceneSections;
use super::{GroupNames, Problem};
use crate::mesh::{BuiltMesh, GmshFile, GmshMesh, MeshError, Surface, SurfaceFracture, SurfaceUse};
use crate::units::Measure;

/// A key that belongs to the other kind of mesh.
struct Stray {
    path: Vec<String>,
    what: String,
    key: &'static str,
    instead: &'static str,
}

impl Stray {
    fn refuse(self, belongs: &'static str) -> Located {
        let path: Vec<&str> = self.path.iter().map(String::as_str).collect();
        at(
            &path,
            Problem::StrayKey {
                what: self.what,
                key: self.key,
                belongs,
                instead: self.instead,
            },
        )
    }
}

/// The first of `keys` that is there.
fn first(
    section: &[&str],
    what: &dyn Fn() -> String,
    keys: &[(bool, &'static str, &'static str)],
) -> Option<Stray> {
    let (_, key, instead) = *keys.iter().find(|(is_there, ..)| *is_there)?;
    let path = section.iter().copied().chain([key]);
    Some(Stray {
        path: path.map(String::from).collect(),
        what: what(),
        key,
        instead,
    })
}

/// No key of a mesh file stands beside a grid.
pub(super) fn require_grid_keys(sections: &SceneSections) -> Result<(), Located> {
    const BELONGS: &str = "a mesh from a `file`";
    let mesh = [(
        sections.mesh.unit.is_some(),
        "unit",
        "a grid has its own units",
    )];
    let mut stray = first(&["mesh"], &|| "[mesh]".into(), &mesh);
    for (i, material) in sections.material.iter().enumerate() {
        let keys = [(
            material.volume.is_some(),
            "volume",
            "use `boxes` or `layers`",
        )];
        let what = || format!("material \"{}\"", material.name);
        stray = stray.or_else(|| first(&["material", &i.to_string()], &what, &keys));
    }
    for (i, fracture) in sections.fracture.iter().enumerate() {
        let keys = [(
            fracture.surface.is_some(),
            "surface",
            "use `plane` and `at`",
        )];
        let what = || format!("fracture \"{}\"", fracture.name);
        stray = stray.or_else(|| first(&["fracture", &i.to_string()], &what, &keys));
    }
    for (i, boundary) in sections.boundary.iter().enumerate() {
        let keys = [(boundary.surface.is_some(), "surface", "use `side`")];
        let what = || format!("[[boundary]] of {}", boundary.place());
        stray = stray.or_else(|| first(&["boundary", &i.to_string()], &what, &keys));
        if boundary.side.is_none() && boundary.surface.is_none() {
            return Err(missing(
                &["boundary", &i.to_string()],
                "[[boundary]]",
                "side",
            ));
        }
    }
    match stray {
        Some(stray) => Err(stray.refuse(BELONGS)),
        None => Ok(()),
    }
}

/// No key of a grid stands beside a mesh file.
fn require_file_keys(sections: &SceneSections) -> Result<(), Located> {
    const BELONGS: &str = "a grid";
    let mesh = &sections.mesh;
    let is_given = |axis: &AxisSection| *axis != AxisSection::default();
    const OUT: &str = "leave it out, the mesh comes from `file`";
    let keys = [
        (is_given(&mesh.x), "x", OUT),
        (is_given(&mesh.y), "y", OUT),
        (is_given(&mesh.z), "z", OUT),
        (mesh.map.is_some(), "map", OUT),
    ];
    let mut stray = first(&["mesh"], &|| "[mesh]".into(), &keys);
    for (i, fracture) in sections.fracture.iter().enumerate() {
        const SURFACE: &str = "use `surface`, the name of a physical surface";
        let keys = [
            (fracture.plane.is_some(), "plane", SURFACE),
            (fracture.at.is_some(), "at", SURFACE),
            (fracture.every.is_some(), "every", SURFACE),
            (fracture.x.is_some(), "x", SURFACE),
            (fracture.y.is_some(), "y", SURFACE),
            (fracture.z.is_some(), "z", SURFACE),
        ];
        let what = || format!("fracture \"{}\"", fracture.name);
        stray = stray.or_else(|| first(&["fracture", &i.to_string()], &what, &keys));
    }
    for (i, boundary) in sections.boundary.iter().enumerate() {
        const SURFACE: &str = "use `surface`, the name of a physical surface";
        let keys = [(boundary.side.is_some(), "side", SURFACE)];
        let what = || format!("[[boundary]] of side {}", boundary.place());
        stray = stray.or_else(|| first(&["boundary", &i.to_string()], &what, &keys));
    }
    match stray {
        Some(stray) => Err(stray.refuse(BELONGS)),
        None => Ok(()),
    }
}

fn missing(section: &[&str], what: &str, key: &'static str) -> Located {
    let what = what.into();
    at(section, Problem::MissingKey { what, key })
}

/// The mesh in `file`, split along the fractures; its sides are those of the boundary sections, in order.
pub(super) fn mesh_from_file(sections: &SceneSections, file: &Path) -> Result<BuiltMesh, Located> {
    require_file_keys(sections)?;
    let gmsh = |path: &[&str]| {
        let path: Vec<String> = path.iter().map(|s| (*s).to_string()).collect();
        move |error: crate::mesh::GmshError| Located {
            path,
            problem: Box::new(MeshError::from(error).into()),
        }
    };
    let unit = sections.mesh.unit.as_ref().map_or(1.0, Measure::si);
    let here = ["mesh", "file"];
    let mesh = GmshFile::read(file).map_err(gmsh(&here))?;
    let mesh = GmshMesh::new(mesh, unit).map_err(gmsh(&here))?;

    let mut volumes = Vec::new();
    for (i, material) in sections.material.iter().enumerate() {
        let names = material.volume.as_ref();
        let marks = names.map(|names| mesh.in_volumes(&names.0)).transpose();
        volumes.push(marks.map_err(gmsh(&["material", &i.to_string(), "volume"]))?);
    }
    let found = mesh.regions(&regions(sections)?, &volumes);
    let found = found.map_err(|error| match &error {
        MeshError::EmptyRegion { region } => {
            let index = sections.material.iter().position(|m| m.name == *region);
            at(&["material", &index.unwrap_or(0).to_string()], error)
        }
        _ => at(&["material", "0"], error),
    })?;

    let select = |section: &str, i: usize, names: &Option<GroupNames>, what: String, used| {
        let number = i.to_string();
        let Some(names) = names else {
            return Err(missing(&[section, &number], &what, "surface"));
        };
        let surface = mesh.surface(&names.0, used);
        surface.map_err(gmsh(&[section, &number, "surface"]))
    };
    let mut fractures = Vec::new();
    for (i, fracture) in sections.fracture.iter().enumerate() {
        let what = format!("fracture \"{}\"", fracture.name);
        fractures.push(SurfaceFracture {
            name: fracture.name.clone(),
            surface: select("fracture", i, &fracture.surface, what, SurfaceUse::Fracture)?,
            flip: fracture.flip,
        });
    }
    let mut boundaries: Vec<Surface> = Vec::new();
    for (i, boundary) in sections.boundary.iter().enumerate() {
        let what = "[[boundary]]".to_string();
        boundaries.push(select(
            "boundary",
            i,
            &boundary.surface,
            what,
            SurfaceUse::Boundary,
        )?);
    }
    mesh.build(found, &fractures, &boundaries).map_err(|error| {
        let name = match &error {
            MeshError::Overlap { second, .. } => Some(second),
            MeshError::Gmsh(gmsh) => match &*gmsh.defect {
                crate::mesh::GmshDefect::OneSided { fracture, .. } => Some(fracture),
                _ => None,
            },
            _ => None,
        };
        match sections.fracture.iter().position(|f| Some(&f.name) == name) {
            Some(i) => at(&["fracture", &i.to_string(), "surface"], error),
            None => at(&here, error),
        }
    })
}
