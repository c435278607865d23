//! Claim: the augmented Lagrangian is the product that its formula says, and its spectrum the known one.

use crate::oracle::{
    DenseInverse, Full, assert_spectrum, full, inverse, operator, real_eigenvalues, spectrum,
    stacked, unsymmetric,
};
use crate::samples::{random, trusses, two_chains};
use faer::Mat;
use fracas_operators::laws::check_preconditioner;
use fracas_operators::{Counted, Preconditioner};
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::saddle::{
    AugmentationChoice, AugmentationMatrix, AugmentedLagrangian, AugmentedLagrangianInverse,
    SaddleBlocks, SaddleSettings,
};

fn choose(blocks: &SaddleBlocks, choice: AugmentationChoice) -> AugmentationMatrix {
    let direct = DirectChoice::Faer.solver().unwrap();
    choice.compute(blocks, direct.as_ref()).unwrap().matrix
}

#[test]
fn exact_parts_invert_the_triangle_of_the_augmented_system() {
    for blocks in [
        random(13, 6, 0.0, 3),
        random(13, 6, 0.6, 4),
        unsymmetric(random(13, 6, 0.6, 5)),
        two_chains(7, 3, 100.0, true),
    ] {
        for choice in [AugmentationChoice::Global, AugmentationChoice::FaceBlock] {
            let settings = AugmentedLagrangian {
                augmentation: choice,
                ..AugmentedLagrangian::default()
            };
            let m = settings.ready(&blocks).unwrap().inverse;
            let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
            let full_blocks = Full::new(&blocks);
            let c = choose(&blocks, choice).to_dense();
            // E⁻¹ [S_u B(I − C⁻¹H); 0 −C], E = [I BC⁻¹; 0 I]
            let bc = &full_blocks.b1 * inverse(&c);
            let s_u = &full_blocks.a + &bc * full_blocks.b1.transpose();
            let zero = Mat::<f64>::zeros(n_t, n_u);
            let corner = &full_blocks.b1 - &bc * &full_blocks.h;
            let triangle = stacked(&s_u, &corner, &zero, &(faer::Scale(-1.0) * &c));
            let e = stacked(
                &Mat::identity(n_u, n_u),
                &(faer::Scale(-1.0) * bc),
                &zero,
                &Mat::identity(n_t, n_t),
            );
            let matrix = operator(&(e * triangle));
            check_preconditioner("augmented Lagrangian", &m, Some(&matrix), 1e-9).unwrap();
        }
    }
}

#[test]
fn exact_parts_have_the_spectrum_of_racp() {
    for h in [0.0, 0.6] {
        let blocks = random(12, 5, h, 8);
        let f = Full::new(&blocks);
        for choice in [AugmentationChoice::Global, AugmentationChoice::LocalH] {
            let settings = AugmentedLagrangian {
                augmentation: choice,
                ..AugmentedLagrangian::default()
            };
            let m = settings.ready(&blocks).unwrap().inverse;
            let s = f.b1.transpose() * (inverse(&f.a) * &f.b1);
            let c = choose(&blocks, choice).to_dense();
            let mut expected = vec![1.0; 12];
            expected.extend(real_eigenvalues(&(inverse(&(&s + &c)) * (&s + &f.h))));
            assert_spectrum(&spectrum(&m, &blocks).unwrap(), expected, 1e-6);
        }
    }
}

#[test]
fn the_flops_are_those_of_the_parts_as_often_as_they_run() {
    for with_h in [false, true] {
        let mut blocks = trusses(3, 10.0, false);
        blocks.h = with_h.then(|| random(9, 27, 1.0, 3).h.unwrap());
        let c = choose(&blocks, AugmentationChoice::Local);
        let c_flops = Preconditioner::flops(&c);
        let p = Counted::new(DenseInverse::of(&full(&blocks.a)));
        let m = AugmentedLagrangianInverse::new(blocks.b1.clone(), blocks.h.clone(), c, &p);
        let n = m.size();
        m.solve(
            &vec![1.0; n],
            &mut vec![0.0; n],
            &mut vec![0.0; m.work_len()],
        );
        let b = 2 * (blocks.b1.nnz() + blocks.n_u()) as u64;
        let h = blocks
            .h
            .as_ref()
            .map_or(0, |h| 2 * (h.nnz() + 27) as u64 + c_flops);
        assert_eq!(
            m.flops(),
            p.applications() * p.inner().flops() + c_flops + b + h
        );
    }
}
