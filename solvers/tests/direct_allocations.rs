//! A solve with any direct backend allocates nothing: its work array is the caller's.
#![allow(unsafe_code, reason = "an allocator that counts")]

mod lattice;

use fracas_operators::laws::probe;
use fracas_solvers::direct::{DirectChoice, Kind};
use lattice::{Lattice, Support};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// Safety: forwards to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|n| n.set(n.get() + 1));
        // Safety: as for the caller.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // Safety: as for the caller.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn solves_do_not_allocate() {
    let lattice = Lattice::new([8, 8, 8]);
    let held = lattice.stiffness(Support::Clamped);
    assert!(lattice.stiffness(Support::Springs(1.0)).nnz() == held.nnz());
    assert!(lattice.stiffness(Support::Floating).nnz() == held.nnz());
    for (kind, a) in [
        (Kind::Spd, held),
        (Kind::QuasiDefinite, lattice.saddle(Some(0.3), 1.0)),
        (Kind::General, lattice.saddle(None, 0.7)),
    ] {
        for choice in DirectChoice::BACKENDS {
            let Ok(factors) = choice
                .solver()
                .and_then(|solver| solver.analyze(&a, kind)?.factor(&a))
            else {
                continue;
            };
            let r = probe::<f64>(a.rows(), 1);
            let (mut z, mut work) = (vec![0.0; r.len()], vec![0.0; factors.work_len()]);
            // thread-local buffers of the dense kernels appear with the first solve
            factors.solve(&r, &mut z, &mut work);
            factors.solve_adjoint(&r, &mut z, &mut work);
            let before = ALLOCATIONS.with(Cell::get);
            factors.solve(&r, &mut z, &mut work);
            let after = ALLOCATIONS.with(Cell::get);
            assert_eq!(after, before, "{choice:?} {kind:?}");
            factors.solve_adjoint(&r, &mut z, &mut work);
            assert_eq!(
                ALLOCATIONS.with(Cell::get),
                before,
                "{choice:?} {kind:?} adjoint"
            );
        }
    }
}
