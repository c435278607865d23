//! C piece by piece, for an A that nobody assembles as a whole.

use super::custom::Custom;
use super::fitted::{Share, fitted_h, shares};
use super::support::Columns;
use super::{Augmentation, AugmentationChoice, AugmentationMatrix, Block, SaddleBlocks};
use crate::SetupError;
use crate::direct::DirectChoice;
use fracas_operators::sparse::SparseMatrix;
use rayon::prelude::*;

impl AugmentationChoice {
    /// True where the rows of C of a face need A on the supports of that face's columns of B alone.
    pub fn is_local(self) -> bool {
        match self {
            Self::Local | Self::LocalH | Self::HalfH | Self::FittedH | Self::FaceBlock => true,
            Self::Global | Self::GlobalTimes(_) | Self::Exact | Self::ExactH => false,
            Self::Other(rule) => rule.0.is_local(),
        }
    }

    /// C of a saddle point given in pieces: faces in order, every piece with the columns of B and the diagonal blocks of H
    /// of some faces, and with all entries of A between the rows that those columns touch; `h` is H of all of them.
    ///
    /// Equal to [`compute`](Self::compute) of the whole.
    ///
    /// # Cost
    /// Pieces in parallel: memory of one per thread at a time.
    ///
    /// # Errors
    /// [`SetupError::NotApplicable`] for a choice that needs all of A; those of [`compute`](Self::compute), rows counted
    /// within their piece; those of the pieces.
    pub fn compute_in_parts<E: From<SetupError> + Send>(
        self,
        parts: impl IndexedParallelIterator<Item = Result<SaddleBlocks, E>>,
        h: Option<&SparseMatrix<f64>>,
    ) -> Result<Augmentation, E> {
        self.require_local()?;
        // never asked by a local choice
        let direct = DirectChoice::Faer.solver()?;
        let mut whole = Augmentation {
            matrix: AugmentationMatrix::diagonal(Vec::new()),
            empty_columns: Vec::new(),
        };
        // fractures may end in another piece
        let (base, is_fitted) = match self {
            Self::FittedH => (Self::Local, true),
            other => (other, false),
        };
        let computed = parts.map(|part| {
            let part = part?;
            let shares = match is_fitted {
                true => shares(&part, &Columns::new(&part.b1)),
                false => Vec::new(),
            };
            Ok((base.compute(&part, direct.as_ref())?, shares))
        });
        let computed: Vec<Result<(Augmentation, Vec<Share>), E>> = computed.collect();
        let mut shares = Vec::new();
        for part in computed {
            let (part, of_part) = part?;
            if !part.matrix.is_by_faces() {
                return Err(SetupError::NotApplicable {
                    method: self.name(),
                    reason: "C couples faces, so that it cannot be had piece by piece: its is_local has to be false".to_owned(),
                }
                .into());
            }
            let before = whole.matrix.size();
            let empty = part.empty_columns.iter().map(|i| before + i);
            whole.empty_columns.extend(empty);
            whole.matrix.append(part.matrix);
            shares.extend(of_part);
        }
        if is_fitted {
            whole.matrix = fitted_h(whole.matrix.diagonal_entries(), &shares, h);
            whole.matrix.factor()?;
        }
        Ok(whole)
    }

    /// Refuses a choice that needs all of A.
    ///
    /// # Errors
    /// [`SetupError::NotApplicable`] with what to take instead.
    pub fn require_local(self) -> Result<(), SetupError> {
        if self.is_local() {
            return Ok(());
        }
        Err(SetupError::NotApplicable {
            method: "an augmentation without an assembled A",
            reason: format!(
                "{} needs all of A; take local, local_h, half_h, fitted_h or face_block, or an inner solver of assembled matrices such as amg",
                self.name()
            ),
        })
    }
}

impl AugmentationMatrix {
    /// `C ← diag(C, next)`, both sparse.
    fn append(&mut self, next: Self) {
        match (&mut *self, next) {
            (Self::Diagonal { c }, Self::Diagonal { c: next }) => c.extend(next),
            (
                Self::FaceBlocks { c, inverse },
                Self::FaceBlocks {
                    c: next,
                    inverse: next_inverse,
                },
            ) => {
                c.extend(next);
                inverse.extend(next_inverse);
            }
            (empty, next) if empty.size() == 0 => *empty = next,
            // aligned faces beside others
            (before, next) => {
                assert!(
                    before.is_by_faces() && next.is_by_faces(),
                    "pieces of a C that couples faces"
                );
                *before = std::mem::replace(before, Self::diagonal(Vec::new())).in_blocks();
                before.append(next.in_blocks());
            }
        }
    }

    /// The same as 3×3 blocks.
    fn in_blocks(self) -> Self {
        let (c, inverse) = self.of_faces().into_iter().map(<[Block; 2]>::into).unzip();
        Self::FaceBlocks { c, inverse }
    }
}

impl AugmentationMatrix {
    /// `factor · C`: C for tractions counted in other units, `factor` > 0.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        assert!(factor > 0.0, "C times {factor}");
        let blocks = |blocks: Vec<Block>, factor: f64| -> Vec<Block> {
            let scaled = |block: Block| block.map(|row| row.map(|v| v * factor));
            blocks.into_iter().map(scaled).collect()
        };
        match self {
            Self::Diagonal { c } => Self::Diagonal {
                c: c.into_iter().map(|v| v * factor).collect(),
            },
            Self::FaceBlocks { c, inverse } => Self::FaceBlocks {
                c: blocks(c, factor),
                inverse: blocks(inverse, 1.0 / factor),
            },
            Self::Dense { c, inverse } => Self::Dense {
                c: c * faer::Scale(factor),
                inverse: inverse * faer::Scale(1.0 / factor),
            },
            Self::Custom(custom) => Self::Custom(Custom {
                factor: custom.factor * factor,
                ..custom
            }),
        }
    }
}
