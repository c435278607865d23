//! The ranks of `mpirun`, each with a part of one system: sums, messages, and one sentence for what goes wrong on any of them.
#![allow(unsafe_code, reason = "calls a C library")]

use super::library::Turn;
use crate::SetupError;
use fracas_petsc_sys as sys;
use std::ffi::c_int;
use std::fmt::Display;
use std::io::Write;

/// Sums that travel in one message, so that no memory is asked for in an iteration.
const SUMS: usize = 256;

/// Seconds that a rank with bad news waits for others to hear them before it ends all.
const PATIENCE: f64 = 30.0;

/// Exit status of bad input.
const BAD_INPUT: c_int = 2;

/// This rank among all that `mpirun` started; one where it did not.
///
/// Everything but [`rank`](Self::rank) and its like is done by all ranks together, in the same order. A rank that exits before
/// [`leave`](Self::leave) ends the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ranks {
    rank: usize,
    size: usize,
    beside: usize,
}

/// What went wrong on some rank, in its sentence; all ranks have the same one.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{said}{}", rank.map_or_else(String::new, |(rank, size)| format!(" (on rank {rank} of {size})")))]
pub struct OnRank {
    /// The sentence.
    pub said: String,
    /// The first rank with it and the number of ranks, where that is another one than the first.
    pub rank: Option<(usize, usize)>,
}

impl Ranks {
    /// Starts MPI and PETSc, once.
    ///
    /// # Errors
    /// [`SetupError::NotApplicable`] where they do not start, or PETSc serves this process alone already.
    pub fn begin() -> Result<Self, SetupError> {
        let not = |reason: &str| SetupError::NotApplicable {
            method: "MPI",
            reason: reason.to_owned(),
        };
        let _turn = Turn::begun("PETSc", true)?;
        let (mut rank, mut size, mut beside) = (0, 0, 0);
        // Safety: three outputs, under the lock.
        let code = unsafe { sys::fracas_ranks_begin(&mut rank, &mut size, &mut beside) };
        if code == sys::ALONE {
            return Err(not(
                "PETSc serves this process alone already; begin ranks before anything else",
            ));
        }
        if code != 0 || size < 1 {
            return Err(not("its ranks do not find each other"));
        }
        Ok(Self {
            rank: rank as usize,
            size: size as usize,
            beside: beside as usize,
        })
    }

    /// From here on every rank may exit in its own time.
    pub fn leave(self) {
        let _turn = Turn::take("PETSc");
        // Safety: under the lock, after `begin`.
        unsafe { sys::fracas_ranks_leave() }
    }

    /// Number of this rank, from 0.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// How many there are.
    pub fn size(&self) -> usize {
        self.size
    }

    /// How many of them are on this machine.
    pub fn beside(&self) -> usize {
        self.beside
    }

    /// True for the rank that speaks.
    pub fn is_first(&self) -> bool {
        self.rank == 0
    }

    /// Sums of every rank become those of all: the same bits on every rank, and in every run with as many ranks.
    ///
    /// # Cost
    /// 2 ⌈log₂ ranks⌉ messages one after the other.
    pub fn sum(&self, sums: &mut [f64]) {
        if self.size == 1 {
            return;
        }
        let _turn = Turn::take("PETSc");
        let mut other = [0.0; SUMS];
        for part in sums.chunks_mut(SUMS) {
            let n = part.len() as c_int;
            // Safety: both have n entries, under the lock.
            unsafe { sys::fracas_ranks_sum(part.as_mut_ptr(), other.as_mut_ptr(), n) }
        }
    }

    /// Numbers of every rank, rank after rank.
    pub fn gather(&self, own: &[f64]) -> Vec<f64> {
        let _turn = Turn::take("PETSc");
        let mut all = vec![0.0; own.len() * self.size];
        // Safety: every rank gives as many, under the lock.
        unsafe { sys::fracas_ranks_gather(own.as_ptr(), own.len() as c_int, all.as_mut_ptr()) }
        all
    }

    /// The largest of every rank's number; NaN where one is.
    pub fn max(&self, own: f64) -> f64 {
        let all = self.gather(&[own]).into_iter();
        let larger = |m: f64, v: f64| if v.is_nan() || v > m { v } else { m };
        all.fold(f64::NEG_INFINITY, larger)
    }

    /// Numbers of every rank, rank after rank, on the first one; the others get none.
    ///
    /// # Panics
    /// Where a rank has more numbers than 31 bits count.
    pub fn collect(&self, own: &[f64]) -> Vec<f64> {
        let lengths = self.gather(&[own.len() as f64]);
        let _turn = Turn::take("PETSc");
        let total: f64 = lengths.iter().sum();
        assert!(
            total <= f64::from(c_int::MAX),
            "{total} numbers in one message"
        );
        let lengths: Vec<c_int> = lengths.iter().map(|n| *n as c_int).collect();
        let first = |k: usize| lengths[..k].iter().sum();
        let firsts: Vec<c_int> = (0..self.size).map(first).collect();
        let mut all = vec![0.0; if self.is_first() { total as usize } else { 0 }];
        // Safety: the first rank has room for all, where its lists say, under the lock.
        unsafe {
            sys::fracas_ranks_collect(
                own.as_ptr(),
                own.len() as c_int,
                all.as_mut_ptr(),
                lengths.as_ptr(),
                firsts.as_ptr(),
            );
        }
        all
    }

    /// Numbers of the first rank on all of them.
    pub fn tell(&self, numbers: &mut [u32]) {
        let _turn = Turn::take("PETSc");
        // messages are counted in 31 bits
        for part in numbers.chunks_mut(1 << 28) {
            let bytes = size_of_val(part) as c_int;
            // Safety: plain numbers of that many bytes, under the lock.
            unsafe { sys::fracas_ranks_tell(0, part.as_mut_ptr().cast(), bytes) }
        }
    }

    /// The result where every rank has one; else the sentence of the first rank that failed, on all of them.
    ///
    /// A rank that failed where others do not ask says its sentence after 30 s and ends all with status 2: nobody waits for ever.
    ///
    /// # Errors
    /// [`OnRank`].
    pub fn agree<T, E: Display>(&self, result: Result<T, E>) -> Result<T, OnRank> {
        let own = result.as_ref().err().map(E::to_string);
        let mut all = vec![0; self.size];
        let turn = Turn::take("PETSc");
        // Safety: `all` has an entry for every rank, under the lock.
        let alone = unsafe {
            sys::fracas_ranks_failed(c_int::from(own.is_some()), PATIENCE, all.as_mut_ptr())
        };
        if alone != 0 {
            let said = own.as_deref().unwrap_or_default();
            let (rank, size) = (self.rank, self.size);
            let _ = writeln!(
                std::io::stderr(),
                "error: {said} (on rank {rank} of {size})"
            );
            // Safety: ends the process.
            unsafe { sys::fracas_ranks_abort(BAD_INPUT) }
        }
        drop(turn);
        let Some(first) = all.iter().position(|failed| *failed != 0) else {
            return match result {
                Ok(value) => Ok(value),
                Err(error) => unreachable!("{error}, and no rank failed"),
            };
        };
        let mut said = own.unwrap_or_default().into_bytes();
        let _turn = Turn::take("PETSc");
        let mut length = said.len() as u32;
        // Safety: a number of four bytes, then as many bytes as it says, under the lock.
        unsafe {
            sys::fracas_ranks_tell(first as c_int, (&raw mut length).cast(), 4);
            said.resize(length as usize, 0);
            sys::fracas_ranks_tell(first as c_int, said.as_mut_ptr(), length as c_int);
        }
        Err(OnRank {
            said: String::from_utf8_lossy(&said).into_owned(),
            rank: (first > 0).then_some((first, self.size)),
        })
    }

    /// Half the time of a message of `n` numbers and its answer between the first two ranks, a mean of so many [s]; 0 for one rank.
    pub fn ping(&self, n: usize, times: usize) -> f64 {
        let _turn = Turn::take("PETSc");
        let mut numbers = vec![0.0; n];
        // Safety: n entries, under the lock.
        unsafe { sys::fracas_ranks_ping(numbers.as_mut_ptr(), n as c_int, times as c_int) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_do_not_begin_behind_a_solver_of_one_process() {
        drop(Turn::take("PETSc").expect("PETSc of this process"));
        let error = Ranks::begin().expect_err("PETSC_COMM_WORLD is this process");
        assert!(error.to_string().contains("alone already"), "{error}");
    }
}
