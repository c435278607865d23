//! Claim: a build without PETSc says which feature brings it.

use fracas_operators::sparse::SparseMatrix;
use fracas_solvers::SetupError;
use fracas_solvers::saddle::InnerChoice;

#[test]
fn a_build_without_petsc_says_which_feature_brings_it() {
    for (name, backend) in [
        ("gamg", "GAMG"),
        ("boomeramg", "BoomerAMG"),
        ("mumps", "MUMPS"),
    ] {
        let inner: InnerChoice = name.parse().unwrap();
        let error = inner.of_matrix(&SparseMatrix::eye(3), None).err().unwrap();
        assert!(matches!(error, SetupError::NotBuilt { .. }));
        assert_eq!(
            error.to_string(),
            format!(
                "{backend} is not part of this build; compile with --features petsc, or choose another backend"
            )
        );
    }
}
