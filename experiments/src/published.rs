//! Tests A, B and C of the lecture (M. Ferronato, SNA'25): sizes, and the table of efficiency.

/// What a published row says of a method that converged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// n_it.
    pub n_it: usize,
    /// c_app.
    pub c_app: f64,
    /// C_s.
    pub c_s: f64,
}

/// A published test and the scene that stands for it; the meshes are not public.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Test {
    /// Letter of the lecture.
    pub name: &'static str,
    /// Scene of the gallery.
    pub scene: &'static str,
    /// Displacement unknowns.
    pub n_u: usize,
    /// Traction unknowns.
    pub n_t: usize,
    /// RACP.
    pub racp: Row,
    /// MCP with multigrid; `None`: not converged in 1000 iterations, or not applicable.
    pub mcp_amg: Option<Row>,
    /// MCP with FSAI.
    pub mcp_fsai: Option<Row>,
}

/// `C_s = n_it (1 + c_app)`, relative residual 1e-8.
///
/// # Source
/// The lecture, slides on the conditioning and on the efficiency of tests A, B, C.
pub const TESTS: [Test; 3] = [
    Test {
        name: "A",
        scene: "analogue_a",
        n_u: 218_790,
        n_t: 6_336,
        racp: Row {
            n_it: 17,
            c_app: 5.36,
            c_s: 108.12,
        },
        mcp_amg: None,
        mcp_fsai: None,
    },
    Test {
        name: "B",
        scene: "analogue_b",
        n_u: 194_208,
        n_t: 6_936,
        racp: Row {
            n_it: 61,
            c_app: 4.21,
            c_s: 317.81,
        },
        mcp_amg: Some(Row {
            n_it: 153,
            c_app: 8.43,
            c_s: 1442.79,
        }),
        mcp_fsai: None,
    },
    Test {
        name: "C",
        scene: "analogue_c",
        n_u: 379_983,
        n_t: 167_799,
        racp: Row {
            n_it: 89,
            c_app: 4.52,
            c_s: 491.28,
        },
        mcp_amg: None,
        mcp_fsai: Some(Row {
            n_it: 270,
            c_app: 3.18,
            c_s: 1128.60,
        }),
    },
];
