//! Large products have the same bits for any number of threads.
#![allow(unsafe_code, reason = "calls routines as C does")]

use fracas_blas::symbols::*;
use std::ffi::c_char;

fn wave(n: usize, phase: f64) -> Vec<f64> {
    (0..n).map(|i| ((i * i) as f64 + phase).sin()).collect()
}

fn flag(f: &u8) -> *const c_char {
    std::ptr::from_ref(f).cast()
}

/// gemm, syrk, trsm and potrf one after the other on matrices of these sizes.
fn bits(m: usize, n: usize, k: usize) -> Vec<u64> {
    let (a, b) = (wave(m * k, 0.1), wave(k * n, 0.2));
    let (mut c, mut s, mut x) = (wave(m * n, 0.3), vec![0.0; m * m], wave(m * n, 0.4));
    (0..m).for_each(|i| s[i * m + i] = k as f64);
    let mut info = -1;
    let (mi, ni, ki) = (m as i32, n as i32, k as i32);
    // Safety: arrays of the stated sizes.
    unsafe {
        dgemm_ffm_(
            flag(&b'N'),
            flag(&b'N'),
            &mi,
            &ni,
            &ki,
            &-1.0,
            a.as_ptr(),
            &mi,
            b.as_ptr(),
            &ki,
            &1.0,
            c.as_mut_ptr(),
            &mi,
        );
        dsyrk_ffm_(
            flag(&b'L'),
            flag(&b'N'),
            &mi,
            &ki,
            &1.0,
            a.as_ptr(),
            &mi,
            &1.0,
            s.as_mut_ptr(),
            &mi,
        );
        dpotrf_ffm_(flag(&b'L'), &mi, s.as_mut_ptr(), &mi, &mut info);
        dtrsm_ffm_(
            flag(&b'L'),
            flag(&b'L'),
            flag(&b'C'),
            flag(&b'N'),
            &mi,
            &ni,
            &1.0,
            s.as_ptr(),
            &mi,
            x.as_mut_ptr(),
            &mi,
        );
        // on the right, with the first columns of the triangle
        dtrsm_ffm_(
            flag(&b'R'),
            flag(&b'L'),
            flag(&b'C'),
            flag(&b'N'),
            &mi,
            &ni.min(mi),
            &1.0,
            s.as_ptr(),
            &mi,
            c.as_mut_ptr(),
            &mi,
        );
    }
    assert_eq!(info, 0);
    [c, s, x].concat().iter().map(|v| v.to_bits()).collect()
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    for (m, n, k) in [
        (600, 1, 400),
        (600, 2, 600),
        (513, 17, 257),
        (700, 129, 33),
        (301, 300, 299),
        (130, 650, 97),
        (1100, 64, 64),
    ] {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| bits(m, n, k))
        };
        let one = run(1);
        for threads in [2, 3, 5, 8] {
            assert!(run(threads) == one, "{m} × {n} × {k} on {threads} threads");
        }
    }
}
