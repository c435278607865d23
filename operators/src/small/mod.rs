//! Small dense matrices by rows: the blocks of nodes, faces and aggregates.
//!
//! | what | file |
//! |---|---|
//! | `M v`, `Y + A X`, `C + PᵀX` | `products` |
//! | a symmetric 3×3 block by six numbers | `symmetric` |
//! | `L Lᵀ`, inverses of positive definite matrices | `cholesky` |
//! | `V Λ Vᵀ` | `eigen` |

mod cholesky;
mod eigen;
mod products;
mod symmetric;

pub use cholesky::{cholesky, equilibrated_inverse, gram, invert_equilibrated, lower_inverse};
pub use eigen::symmetric_eigen;
pub use products::{
    Matrix3, add, add_product, add_transposed_product, cast, diagonal, norm_squared, times,
    transposed,
};
pub use symmetric::{Symmetric, full, upper};
