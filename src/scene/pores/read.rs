//! From a section and its files to what every element takes.

use super::cells::mean;
use super::cloud::{Cloud, Origin};
use super::field::{Change, Fields};
use super::moved::place;
use super::places::{Places, Taken};
use super::{PoreField, PoreProblem, csv_grid, vtu};
use crate::digest::Hash;
use crate::mesh::HexMesh;
use crate::scene::acting::require_time_for;
use crate::scene::csv_table::measured;
use crate::scene::located::{Located, at};
use crate::scene::pore_pressure::{Between, PorePressureSection, increasing};
use crate::scene::sections::{MaterialSection, SceneSections};
use crate::scene::{Latest, Problem, TableProblem};
use crate::units::{Duration, Measure, PorePressure};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Elements of one task.
const ELEMENTS_PER_TASK: usize = 512;

/// Name of the array where none is given.
const ARRAY: &str = "pressure";

/// The files of a section and the key that names them.
fn files(section: &PorePressureSection) -> (Vec<&PathBuf>, &'static str) {
    match &section.fields {
        Some(fields) => (fields.iter().map(|(_, file)| file).collect(), "fields"),
        None => (section.grid.iter().collect(), "grid"),
    }
}

/// The bytes of a file of a section, which the digest takes in.
fn open(
    file: &Path,
    (section, folder): (&PorePressureSection, &Path),
    digest: &mut Hash,
) -> Result<Vec<u8>, PoreProblem> {
    let read = std::fs::read(place(file, folder, section.digest.is_some()));
    let bytes = read.map_err(|error| PoreProblem::Unreadable {
        file: file.display().to_string(),
        reason: error.to_string(),
    })?;
    digest.list(bytes.iter().map(|byte| [*byte]));
    Ok(bytes)
}

/// Notes the digest of the files of a section, or holds them against the one that is written.
pub(in crate::scene) fn digest(
    section: &mut PorePressureSection,
    name: &str,
    folder: &Path,
    here: &[&str; 3],
) -> Result<(), Located> {
    let (files, key) = files(section);
    if files.is_empty() && section.grid.is_none() {
        return Ok(());
    }
    let mut hash = Hash::default();
    for file in files {
        let path = [here[0], here[1], here[2], key];
        open(file, (section, folder), &mut hash).map_err(|problem| at(&path, problem))?;
    }
    agrees(section.digest.as_ref(), hash, name).map_err(|problem| at(here, problem))?;
    section.digest = Some(hash.to_string());
    Ok(())
}

/// Files are those of the digest, where there is one.
fn agrees(digest: Option<&String>, hash: Hash, name: &str) -> Result<(), PoreProblem> {
    let found = hash.to_string();
    match digest {
        Some(digest) if *digest != found => Err(PoreProblem::Changed {
            name: name.into(),
            digest: digest.clone(),
            found,
        }),
        _ => Ok(()),
    }
}

/// Whether the pressure of one material goes on in the other: that of the same files does.
pub(in crate::scene) fn alike(a: &MaterialSection, b: &MaterialSection) -> bool {
    let biot = |m: &MaterialSection| m.biot.as_ref().map_or(1.0, Measure::si);
    let [own, other] = [a, b].map(|m| m.pore_pressure.as_ref().filter(|p| p.is_spatial()));
    match (own, other) {
        (None, None) => true,
        (Some(own), Some(other)) => own == other && own.drawdown.is_none() && biot(a) == biot(b),
        _ => false,
    }
}

/// The changes of pressure that differ from element to element.
pub(in crate::scene) fn fields(
    sections: &SceneSections,
    mesh: &HexMesh,
    folder: &Path,
) -> Result<Vec<PoreField>, Located> {
    let mut all = Vec::new();
    for (i, material) in sections.material.iter().enumerate() {
        let spatial = material.pore_pressure.as_ref().filter(|p| p.is_spatial());
        let Some(section) = spatial else { continue };
        let number = i.to_string();
        let own = mesh.regions.iter().zip(0u32..);
        let elements: Vec<u32> = own
            .filter(|(region, _)| usize::from(**region) == i)
            .map(|(_, e)| e)
            .collect();
        let (change, origin) = match &section.drawdown {
            Some(drawdown) => {
                let path = ["material", &number, "pore_pressure", "drawdown"];
                let found = drawdown.drawdown(material, mesh, &elements);
                let found = found.map_err(|problem| at(&path, problem))?;
                let origin = found.origin();
                (Change::Drawdown(found), origin)
            }
            None => {
                let key = files(section).1;
                let reader = Reader {
                    section,
                    name: &material.name,
                    mesh,
                    elements: &elements,
                    folder,
                };
                let path = ["material", &number, "pore_pressure", key];
                let (first, fields, origin) =
                    reader.read().map_err(|problem| at(&path, problem))?;
                if fields.times.len() > 1 {
                    require_time_for(sections, i, &first)?;
                }
                (Change::Fields(fields), origin)
            }
        };
        all.push(PoreField {
            region: i,
            biot: material.biot.as_ref().map_or(1.0, Measure::si),
            elements,
            change,
            origin,
            latest: Latest::default(),
        });
    }
    Ok(all)
}

/// What the files of a material are read for.
struct Reader<'a> {
    section: &'a PorePressureSection,
    name: &'a str,
    mesh: &'a HexMesh,
    elements: &'a [u32],
    folder: &'a Path,
}

/// What elements take of points that one file after another may have.
#[derive(Default)]
struct Mapping {
    places: Option<Places>,
    /// Point of every element, where each takes that of one.
    own: Vec<u32>,
    origin: String,
}

impl Reader<'_> {
    /// The first time, changes at all times, and what elements take, in words.
    fn read(&self) -> Result<(Measure<Duration>, Fields, String), Problem> {
        let mut hash = Hash::default();
        let mut mapping = Mapping::default();
        let mut values = Vec::new();
        let here = (self.section, self.folder);
        let times = match (&self.section.fields, &self.section.grid) {
            (Some(fields), _) => {
                let place = || format!("`fields` of material \"{}\"", self.name);
                increasing(fields.iter().map(|(t, _)| t.si()), place, |k| {
                    ("row", k + 1)
                })?;
                let unit = self.unit()?;
                for (_, file) in fields {
                    let bytes = open(file, here, &mut hash)?;
                    let array = self.section.array.as_deref().unwrap_or(ARRAY);
                    let cloud = vtu::read(&bytes, &file.display().to_string(), array)?;
                    let cloud = in_pascals(cloud, array, unit)?.distinct()?;
                    values.extend(self.taken(cloud, &mut mapping)?);
                }
                fields.iter().map(|(time, _)| time.clone()).collect()
            }
            (None, Some(file)) => {
                let bytes = open(file, here, &mut hash)?;
                let (times, cloud) = csv_grid::read(&bytes, &file.display().to_string())?;
                values = self.taken(cloud.distinct()?, &mut mapping)?;
                times
            }
            (None, None) => Vec::new(),
        };
        agrees(self.section.digest.as_ref(), hash, self.name)?;
        let Some(first) = times.first().cloned() else {
            let place = format!("`fields` of material \"{}\"", self.name);
            return Err(TableProblem::Empty { place }.into());
        };
        let at_first = values[0].clone();
        for own in &mut values {
            own.iter_mut().zip(&at_first).for_each(|(p, p0)| *p -= p0);
        }
        let fields = Fields {
            times: times.iter().map(Measure::si).collect(),
            changes: values,
            steps: self.section.between == Between::Steps,
        };
        Ok((first, fields, mapping.origin))
    }

    /// Pascals per unit of the array.
    fn unit(&self) -> Result<f64, Problem> {
        let Some(unit) = &self.section.unit else {
            let what = format!("`fields` of material \"{}\"", self.name);
            return Err(Problem::MissingKey { what, key: "unit" });
        };
        let one = measured::<PorePressure>("1", unit);
        let one = one.map_err(|reason| PoreProblem::Unit { reason })?;
        Ok(one.si())
    }

    /// Per time the pressure of every element.
    fn taken(&self, mut cloud: Cloud, mapping: &mut Mapping) -> Result<Vec<Vec<f64>>, PoreProblem> {
        let known = mapping.places.take().filter(|places| places.are_of(&cloud));
        let places = match known {
            Some(places) => places,
            None => self.places(&mut cloud, mapping)?,
        };
        let of_field = |pressures: &Vec<f64>| -> Vec<f64> {
            if !mapping.own.is_empty() {
                let own = mapping.own.iter();
                return own.map(|p| pressures[*p as usize]).collect();
            }
            let value = |e: &u32| places.between(self.center(*e), pressures).unwrap_or(0.0);
            let elements = self.elements.par_iter().with_min_len(ELEMENTS_PER_TASK);
            elements.map(value).collect()
        };
        let values = cloud.pressures.iter().map(of_field).collect();
        mapping.places = Some(places);
        Ok(values)
    }

    /// Where the points of a cloud lie, unless an element is too far from them.
    fn places(&self, cloud: &mut Cloud, mapping: &mut Mapping) -> Result<Places, PoreProblem> {
        let places = Places::new(cloud, self.section.interpolation)?;
        let all: Vec<Taken> = (self.elements.par_iter())
            .with_min_len(ELEMENTS_PER_TASK)
            .map(|e| places.at(self.center(*e)))
            .collect();
        let within = self.section.within.as_ref().map(Measure::si);
        mapping.own.clear();
        let mut farthest = 0.0f64;
        for (e, taken) in self.elements.iter().zip(all) {
            let distance = match taken {
                Taken::One(p, distance) => {
                    mapping.own.push(p);
                    distance
                }
                Taken::Between(distance) => distance,
            };
            farthest = farthest.max(distance);
            let least = within.unwrap_or_else(|| places.bound(0.0));
            if distance > least {
                self.require_near(*e, distance, &places, &cloud.file)?;
            }
        }
        mapping.origin = format!("{}, none farther than {farthest:.6} m", places.text());
        Ok(places)
    }

    fn corners(&self, e: u32) -> [[f64; 3]; 8] {
        self.mesh.elements[e as usize].map(|a| self.mesh.nodes[a as usize])
    }

    fn center(&self, e: u32) -> [f64; 3] {
        mean(self.corners(e).into_iter())
    }

    /// Refuses an element that is too far from the points.
    fn require_near(
        &self,
        e: u32,
        distance: f64,
        places: &Places,
        file: &str,
    ) -> Result<(), PoreProblem> {
        let x = self.corners(e);
        let square = |a: &[f64; 3], b: &[f64; 3]| -> f64 {
            (0..3).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum()
        };
        let all = x.iter().flat_map(|a| x.iter().map(move |b| square(a, b)));
        let diameter = all.fold(0.0, f64::max).sqrt();
        let own = self.section.within.as_ref().map(Measure::si);
        let bound = own.unwrap_or_else(|| places.bound(diameter));
        if distance <= bound {
            return Ok(());
        }
        Err(PoreProblem::Far {
            element: e as usize,
            name: self.name.into(),
            center: mean(x.into_iter()),
            distance,
            bound,
            file: file.into(),
        })
    }
}

/// The numbers of a file of VTK as pressures, which are not negative.
fn in_pascals(mut cloud: Cloud, array: &str, unit: f64) -> Result<Cloud, PoreProblem> {
    let origin = cloud.origin;
    let senseless = |p: usize, what: String, value: f64, advice: &'static str| PoreProblem::Value {
        file: cloud.file.clone(),
        place: Cloud::name(origin, p),
        what,
        value,
        advice,
    };
    for (p, value) in cloud.pressures.iter().flatten().enumerate() {
        let what = || format!("`{array}`");
        if !value.is_finite() {
            let advice = "give it a pressure, or leave it out of the grid";
            return Err(senseless(p, what(), *value, advice));
        }
        if *value < 0.0 {
            let advice = "a pore pressure is zero or positive";
            return Err(senseless(p, what(), *value, advice));
        }
    }
    let places = cloud.points.iter().enumerate();
    for (p, x) in places.flat_map(|(p, x)| x.iter().map(move |x| (p, *x))) {
        if !x.is_finite() {
            let what = match origin {
                Origin::Cell => "a coordinate of its centre",
                Origin::Point | Origin::Record => "a coordinate",
            };
            let advice = "places are numbers in m";
            return Err(senseless(p, what.into(), x, advice));
        }
    }
    (cloud.pressures.iter_mut().flatten()).for_each(|p| *p *= unit);
    Ok(cloud)
}
