//! krylov
