//! The section of a scene file that describes rock by layers, as it is written.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::SurfaceSection;
use crate::units::{Length, Measure};

/// Layers from the top down, which fractures across x and y may offset (`throw`) and lean through (`dip`); grid lines follow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GeologySection {
    /// Layers, the highest first; its top is that of the box.
    pub layers: Vec<LayerSection>,
    /// Level z of the base of the last layer: the bottom of the box.
    pub bottom: Measure<Length>,
    /// Parts of layers with a material of their own; where two overlap the later one wins.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub compartments: Vec<CompartmentSection>,
}

/// A layer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LayerSection {
    /// Its top before faults offset it, that in the corner of lowest x and y: a level z, or a surface: pairs `{ x = [[x, z], …] }` or
    /// `{ y = [[y, z], …] }`, or a table `{ x = […], y = […], z = [[…], …] }` with a row per y; straight between points and constant beyond.
    pub top: SurfaceSection,
    /// Name of its material.
    pub material: String,
}

/// The part of a layer in a rectangle: give `between`, `x`, `y`, or two of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompartmentSection {
    /// Name of its material.
    pub material: String,
    /// Material of the layer that it is a part of.
    pub layer: String,
    /// Names of two fractures across one axis, between which it lies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub between: Option<[String; 2]>,
    /// Span in x; the full width if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<[Measure<Length>; 2]>,
    /// Span in y; the full width if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<[Measure<Length>; 2]>,
}
