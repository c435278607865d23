//! Parts of a graph, of like size and with few edges between them, by METIS.
#![allow(unsafe_code, reason = "calls a C library")]

use super::nested_dissection::{GENERATOR, SEED, fracas_metis_errors};
use crate::SetupError;
use metis_sys as m;

/// Parts from which METIS divides at once and not by halves, as its manual advises.
const AT_ONCE: usize = 8;

/// The part of every node of an undirected graph without loops, given by the neighbours of node after node; every part has a node.
///
/// # Errors
/// [`SetupError::NotApplicable`] for more parts than METIS finds nodes for; [`SetupError::OutOfMemory`] beyond 2³¹ − 1 edges.
///
/// # Panics
/// Where the offsets are none of the lists: they begin with 0, ascend and end with the number of neighbours; and where a neighbour is no node.
///
/// # Source
/// G. Karypis, V. Kumar, SIAM J. Sci. Comput. 20 (1998) 359–392.
pub fn partition(
    offsets: &[usize],
    neighbours: &[u32],
    parts: usize,
) -> Result<Vec<u32>, SetupError> {
    let n = offsets.len() - 1;
    assert_eq!(offsets[n], neighbours.len(), "neighbours of {n} nodes");
    assert!(
        neighbours.iter().all(|i| (*i as usize) < n) && offsets.is_sorted(),
        "neighbours among {n} nodes"
    );
    if parts == 1 {
        return Ok(vec![0; n]);
    }
    let too_many = || SetupError::NotApplicable {
        method: "a partition",
        reason: format!("{n} nodes make no {parts} parts; take fewer ranks"),
    };
    if parts > n {
        return Err(too_many());
    }
    let refused = |why: String| SetupError::OutOfMemory {
        method: "METIS",
        n,
        bytes: None,
        advice: why,
    };
    let index = |i: usize| {
        m::idx_t::try_from(i).map_err(|_| refused("its indices have 32 bits".to_owned()))
    };
    let mut offsets = (offsets.iter().map(|i| index(*i))).collect::<Result<Vec<_>, _>>()?;
    let mut neighbours: Vec<m::idx_t> = neighbours.iter().map(|i| *i as m::idx_t).collect();
    let (mut count, mut constraints, mut wanted) = (index(n)?, 1, index(parts)?);
    let mut options: [m::idx_t; m::METIS_NOPTIONS as usize] = [-1; m::METIS_NOPTIONS as usize];
    options[m::moptions_et_METIS_OPTION_SEED as usize] = SEED;
    let (mut cut, mut part) = (0, vec![0; n]);
    let null = std::ptr::null_mut;
    let turn = GENERATOR
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner());
    // Safety: the graph is as METIS documents it, lists have their lengths, and null stands for what has a default.
    let status = unsafe {
        fracas_metis_errors();
        let divide = match parts < AT_ONCE {
            true => m::METIS_PartGraphRecursive,
            false => m::METIS_PartGraphKway,
        };
        divide(
            &mut count,
            &mut constraints,
            offsets.as_mut_ptr(),
            neighbours.as_mut_ptr(),
            null(),
            null(),
            null(),
            &mut wanted,
            std::ptr::null_mut(),
            std::ptr::null_mut(),
            options.as_mut_ptr(),
            &mut cut,
            part.as_mut_ptr(),
        )
    };
    drop(turn);
    if status != m::rstatus_et_METIS_OK {
        return Err(refused(format!("it stopped with status {status}")));
    }
    let part: Vec<u32> = part.into_iter().map(|p| p as u32).collect();
    let mut is_met = vec![false; parts];
    part.iter().for_each(|p| is_met[*p as usize] = true);
    match is_met.into_iter().all(|met| met) {
        true => Ok(part),
        false => Err(too_many()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_falls_into_pieces_of_like_length() {
        let n = 120;
        let (mut offsets, mut neighbours) = (vec![0], Vec::new());
        for i in 0..n as u32 {
            neighbours.extend(i.checked_sub(1));
            neighbours.extend((i + 1 < n as u32).then_some(i + 1));
            offsets.push(neighbours.len());
        }
        for parts in [1, 2, 3, 4, 9] {
            let part = partition(&offsets, &neighbours, parts).unwrap();
            assert_eq!(part, partition(&offsets, &neighbours, parts).unwrap());
            for p in 0..parts as u32 {
                let size = part.iter().filter(|q| **q == p).count();
                assert!(
                    size * parts >= n * 8 / 10,
                    "{size} of {n} for one of {parts}"
                );
            }
            let cuts = part.windows(2).filter(|w| w[0] != w[1]).count();
            assert!(cuts < 2 * parts, "{cuts} cuts for {parts} parts");
        }
        let error = partition(&offsets, &neighbours, n + 1).unwrap_err();
        assert!(error.to_string().contains("fewer ranks"), "{error}");
    }
}
