//! What a linear operator *is*: scalars, vectors, operators, preconditioners, block algebra, sparse formats,
//! Matrix Market files and the laws that every operator obeys.
//!
//! No mesh lives here and no algorithm that inverts: those are `fracas` and `fracas-solvers`.
//!
//! ```
//! use fracas_operators::{LinearOperator, sparse::Diagonal};
//! let d = Diagonal::new(vec![2.0, 3.0]);
//! let mut y = [0.0; 2];
//! d.apply(&[1.0, 1.0], &mut y, &mut []);
//! assert_eq!(y, [2.0, 3.0]);
//! ```

pub mod adjoint;
pub mod block;
pub mod count;
pub mod dense;
pub mod fields;
pub mod free_entries;
pub mod laws;
pub mod matrix_market;
pub mod operator;
pub mod preconditioner;
pub mod random;
pub mod real;
pub mod shape;
pub mod shared;
pub mod simd;
pub mod small;
pub mod sparse;
pub mod tally;
pub mod twofold;
pub mod vector;

pub use adjoint::Adjoint;
pub use block::BlockOperator;
pub use count::Counted;
pub use dense::Dense;
pub use fields::{Field, Fields, Layout};
pub use operator::{AdjointOperator, LinearOperator};
pub use preconditioner::{Identity, Preconditioner, Properties};
pub use real::{Make, Real};
pub use shape::Shape;
pub use twofold::Twofold;
