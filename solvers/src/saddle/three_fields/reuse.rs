//! Factors of S_p whose ordering outlives a change of values.

use super::PressureSystem;
use crate::SetupError;
use crate::direct::{DirectChoice, Kind, Symbolic};
use crate::saddle::leading::Leading;
use fracas_operators::Preconditioner;
use fracas_operators::sparse::SparseMatrix;

/// Makes `S_p⁻¹` by sparse LU factorization, definite or not; ordering and symbolic factorization are kept as long as the pattern
/// stays.
#[derive(Debug, Default)]
pub struct PressureFactors {
    backend: DirectChoice,
    known: Option<Analysed>,
    analyses: usize,
}

/// A pattern and its ordering.
#[derive(Debug)]
struct Analysed {
    starts: Vec<usize>,
    columns: Vec<u32>,
    symbolic: Box<dyn Symbolic>,
}

impl PressureFactors {
    /// By this backend.
    pub fn new(backend: DirectChoice) -> Self {
        Self {
            backend,
            ..Self::default()
        }
    }

    /// Times that a pattern was analysed.
    pub fn analyses(&self) -> usize {
        self.analyses
    }

    /// S_p⁻¹.
    ///
    /// # Errors
    /// [`SetupError::Singular`] for S_p, with what may make it so.
    pub fn factor(
        &mut self,
        system: &PressureSystem,
    ) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        let matrix = system.matrix();
        let factors = self.symbolic(matrix)?.factor(matrix).map_err(about_s_p)?;
        Ok(match system.auxiliary() {
            0 => factors,
            _ => Box::new(Leading::new(system.size(), factors)),
        })
    }

    fn symbolic(&mut self, matrix: &SparseMatrix<f64>) -> Result<&dyn Symbolic, SetupError> {
        let starts: Vec<usize> = matrix.indptr().to_proper().to_vec();
        let is_same =
            |known: &Analysed| known.starts == starts && known.columns == matrix.indices();
        let known = match self.known.take().filter(is_same) {
            Some(known) => known,
            None => {
                self.analyses += 1;
                let symbolic = self.backend.solver()?.analyze(matrix, Kind::General)?;
                Analysed {
                    starts,
                    columns: matrix.indices().to_vec(),
                    symbolic,
                }
            }
        };
        Ok(&*self.known.insert(known).symbolic)
    }
}

/// Says what makes S_p singular.
fn about_s_p(error: SetupError) -> SetupError {
    let mut error = error.in_block("S_p = T − Q2 S_u⁻¹ Q1");
    if let SetupError::Singular { advice, .. } = &mut error {
        "pressures of a part of the fractures are determined by no prescribed pressure, no open face and no storage, or by a storage \
         that rounding loses beside what the fracture lets through in the step; add one of them, or take a smaller conductivity or \
         shorter steps"
            .clone_into(advice);
    }
    error
}
