//! Named scenes: a question each, and what is known of the answer.

use super::{Scene, SceneError};

/// A scene of the gallery.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GalleryScene {
    /// Name on the command line.
    pub name: &'static str,
    /// What it asks.
    pub question: &'static str,
    /// What is known of the answer.
    pub expected: &'static str,
    /// The scene file.
    pub toml: &'static str,
    /// Overrides for a version of a few hundred to a few thousand unknowns.
    pub small: &'static [&'static str],
}

impl GalleryScene {
    /// The scene at its default size.
    ///
    /// # Errors
    /// [`SceneError`]; a test reads and builds every scene.
    pub fn scene(&self) -> Result<Scene, SceneError> {
        Scene::from_toml(self.toml, &format!("{}.toml", self.name))
    }

    /// The small version.
    ///
    /// # Errors
    /// As [`GalleryScene::scene`].
    pub fn small_scene(&self) -> Result<Scene, SceneError> {
        self.scene()?.with_overrides(self.small)
    }
}

macro_rules! gallery {
    ($($name:literal: $question:literal, $expected:literal, [$($small:literal),*];)*) => {
        /// The list; adding a scene touches it and one file.
        const GALLERY: &[GalleryScene] = &[$(GalleryScene {
            name: $name,
            question: $question,
            expected: $expected,
            toml: include_str!(concat!("gallery/", $name, ".toml")),
            small: &[$($small),*],
        }),*];
    };
}

gallery! {
    "checkerboard": "How many tractions does the unstabilised pair not see on a closed N x N fracture with tips not split?",
        "2N - 1 per component (N = 8: 45 in all); none with H",
        ["mesh.x.cells=6", "mesh.y.cells=6", "mesh.z.cells=6"];
    "patch": "Do two blocks under uniform pressure carry it through the fracture between them?",
        "t_N = -p on every face, no jump, to rounding",
        [];
    "clamped": "What does theorem 1 say where it applies: A regular, B of full rank, H = 0?",
        "with C = BᵀA⁻¹B and exact S_u the eigenvalues are 1 (n_u times) and 1/2 (n_t times)",
        ["mesh.x.cells=8", "mesh.y.cells=4", "mesh.z.cells=4"];
    "inclined": "How do tractions and slip develop on a through-going fracture of 60 deg dip?",
        "stick or slip of the whole plane by tan(30 deg) against tan(phi): A is singular, K is not",
        ["mesh.x.cells=8", "mesh.y.cells=4", "mesh.z.cells=8"];
    "crossing": "Do two crossing fractures (X) need a special case?",
        "four copies of every node on the crossing line, junction edges left out of H",
        ["mesh.x.cells=8", "mesh.y.cells=4", "mesh.z.cells=8"];
    "tee": "Does a fracture that ends on another one (T) need a special case?",
        "three copies of every node on the meeting line",
        ["mesh.x.cells=8", "mesh.y.cells=4", "mesh.z.cells=8"];
    "floating": "What if a block is held by closed fractures alone?",
        "A has six zero eigenvalues per floating block, the saddle point none",
        ["mesh.x.cells=9", "mesh.y.cells=4", "mesh.z.cells=4"];
    "analogue_a": "Which preconditioner survives a singular A (published test A, n_t/n_u = 2.9 %)?",
        "RACP converges in a few tens of iterations; MCP is not applicable (analogue: the mesh of the publication is not public)",
        ["mesh.x.cells=20", "mesh.y.cells=4", "mesh.z.cells=4"];
    "analogue_b": "How do RACP and MCP compare on a well posed body with few fractures (published test B, n_t/n_u = 3.6 %)?",
        "RACP takes fewer iterations than MCP (analogue: the mesh of the publication is not public)",
        ["mesh.x.cells=10", "mesh.y.cells=8", "mesh.z.cells=8"];
    "analogue_c": "How do RACP and MCP compare on a dense fracture network (published test C, n_t/n_u = 44.2 %)?",
        "RACP keeps converging where MCP-AMG fails (analogue: the mesh of the publication is not public)",
        ["mesh.x.cells=6", "mesh.y.cells=6", "mesh.z.cells=6",
            "fracture.joint_x.z=['8 m', '16 m']", "fracture.joint_y.z=['8 m', '16 m']"];
    "analogue_c_blocks": "The same density of fractures, no block one cell wide in two directions: what does a network without mechanisms cost?",
        "RACP takes a few tens of iterations; columns one cell wide (analogue_c) turn like gears, which constant tractions do not see",
        ["mesh.x.cells=6", "mesh.y.cells=6", "mesh.z.cells=6",
            "fracture.joint_x.z=['8 m', '16 m']", "fracture.joint_y.z=['8 m', '16 m']"];
    "layered": "What does a stiffness contrast of 1000 between layers do to the spectrum?",
        "C_local alone lets it grow with the contrast; C_local + diag(H) does not",
        ["mesh.x.cells=6", "mesh.y.cells=6", "mesh.z.cells=6"];
    "layered_crossing": "What does a body cost from a hundred thousand to tens of millions of unknowns?",
        "time and memory per unknown, and iterations, do not grow without an assembled A",
        ["mesh.x.cells=8", "mesh.y.cells=8", "mesh.z.cells=8"];
    "stretched": "What do cells of 1:50 do to iterations?",
        "local augmentation follows the anisotropy, a global one does not",
        ["mesh.x.cells=6", "mesh.y.cells=6", "mesh.z.cells=6"];
    "cycle": "Does a fracture find its way through stick, slip and opening and back?",
        "rows of faces slip, then all, all open at once, close in stick and slip back",
        ["mesh.x.cells=4", "mesh.y.cells=5", "mesh.z.cells=5"];
    "inclined_crack": "Does a closed crack under inclined compression slide as the closed form says?",
        "t_N = -11.698 MPa all along, slip an ellipse of 3.808 mm in the middle",
        ["mesh.x.size=0.2 m", "mesh.x.growth=1.8", "mesh.z.size=0.2 m", "mesh.z.growth=1.8"];
    "line_crack": "Does a crack that 2 MPa open in plane strain have the width of Sneddon's?",
        "an ellipse of 0.3 mm in the middle",
        ["mesh.x.size=0.2 m", "mesh.x.growth=1.8", "mesh.z.size=0.2 m", "mesh.z.growth=1.8"];
    "penny_crack": "Does a disc that 2 MPa open have the width of Sneddon's?",
        "an ellipsoid of 0.191 mm in the centre",
        ["mesh.x.size=0.25 m", "mesh.y.size=0.25 m", "mesh.z.size=0.25 m",
            "mesh.x.growth=1.8", "mesh.y.growth=1.8", "mesh.z.growth=1.8"];
    "injection": "Does a fluid that is pumped into a closed fracture stay in it, and come back?",
        "the fracture opens at the pressure that closes it and takes every litre; the volume balance closes to rounding",
        ["mesh.x.cells=6", "mesh.y.cells=6", "mesh.z.cells=6",
            "fracture.branch.x=['-4 m', '4 m']", "fracture.branch.y=['-4 m', '4 m']"];
    "storage": "When do faults around gas stores slip: in primary production, as cushion gas comes in, in storage?",
        "faults slip while the blocks are produced; with horizontal stresses of 0.4 they slip back when cushion gas turns the load round, and to and fro in storage",
        ["mesh.x.size=250 m", "mesh.x.growth=1.6", "mesh.y.size=500 m", "mesh.y.growth=1.6", "mesh.z.size=100 m", "mesh.z.growth=1.7"];
    "rupture_bedrock": "At which drawdown does the ground tear where bedrock emerges?",
        "sediments slip down along its flank from the first drawdown on, and come off it at the ground",
        ["mesh.x.size=20 m", "mesh.z.size=20 m"];
    "rupture_step": "At which drawdown does the ground tear above a step in the thickness of an aquifer?",
        "a vertical plane above the step opens from the ground down and shears",
        ["mesh.x.size=20 m", "mesh.z.size=20 m"];
    "rupture_ridge": "At which drawdown does the ground tear above a buried ridge?",
        "a vertical plane above the ridge opens from the ground down, without shear",
        ["mesh.x.size=20 m", "mesh.z.size=20 m"];
    "incompressible": "Does a Poisson ratio of 0.49 spoil the augmentation?",
        "iterations grow with the inner solver for S_u, not with C",
        ["mesh.x.cells=6", "mesh.y.cells=6", "mesh.z.cells=6"];
}

/// Every scene of the gallery.
pub fn gallery() -> &'static [GalleryScene] {
    GALLERY
}

/// The scene of that name.
pub fn named(name: &str) -> Option<&'static GalleryScene> {
    GALLERY.iter().find(|scene| scene.name == name)
}
