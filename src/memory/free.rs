//! Memory that this process may still take: that of the machine, of its control groups, of its address space.

use std::path::Path;

/// Memory that can be taken without swapping and without passing a limit [bytes], where the system tells (Linux).
pub fn available_bytes() -> Option<u64> {
    available_below(Path::new("/"))
}

/// The least of what `/proc` and `/sys/fs/cgroup` below `root` leave.
fn available_below(root: &Path) -> Option<u64> {
    let machine = kibibytes(&root.join("proc/meminfo"), "MemAvailable:");
    let limits = [address_space(root), groups(root)];
    limits.into_iter().flatten().chain(machine).min()
}

/// True where this process has a limit of addresses (RLIMIT_AS).
pub fn limits_addresses() -> bool {
    address_limit(Path::new("/")).is_some()
}

/// RLIMIT_AS [bytes], where it is set.
fn address_limit(root: &Path) -> Option<u64> {
    let limits = std::fs::read_to_string(root.join("proc/self/limits")).ok()?;
    let line = limits
        .lines()
        .find_map(|l| l.strip_prefix("Max address space"))?;
    // "unlimited" is none
    line.split_ascii_whitespace().next()?.parse().ok()
}

/// What RLIMIT_AS leaves.
fn address_space(root: &Path) -> Option<u64> {
    let limit = address_limit(root)?;
    let taken = kibibytes(&root.join("proc/self/status"), "VmSize:")?;
    Some(limit.saturating_sub(taken))
}

/// What the control groups of this process leave, v2 and v1, those around them included.
fn groups(root: &Path) -> Option<u64> {
    let list = std::fs::read_to_string(root.join("proc/self/cgroup")).ok()?;
    let mount = root.join("sys/fs/cgroup");
    let left = list.lines().filter_map(|line| {
        // hierarchy:controllers:path
        let mut parts = line.splitn(3, ':').skip(1);
        let (controllers, path) = (parts.next()?, parts.next()?);
        let path = Path::new(path.trim_start_matches('/'));
        if controllers.is_empty() {
            [mount.clone(), mount.join("unified")]
                .iter()
                .filter_map(|mount| least(mount, path, &V2))
                .min()
        } else if controllers.split(',').any(|c| c == "memory") {
            least(&mount.join("memory"), path, &V1)
        } else {
            None
        }
    });
    left.min()
}

/// Files of a version.
struct Version {
    limits: &'static [&'static str],
    usage: &'static str,
    /// What is given back when it is needed, in `memory.stat`.
    cache: &'static str,
}

const V2: Version = Version {
    limits: &["memory.max", "memory.high"],
    usage: "memory.current",
    cache: "inactive_file ",
};

const V1: Version = Version {
    limits: &["memory.limit_in_bytes"],
    usage: "memory.usage_in_bytes",
    cache: "total_inactive_file ",
};

/// The least that a group and those around it leave; inside a container its own group is the root of the mount.
fn least(mount: &Path, path: &Path, version: &Version) -> Option<u64> {
    path.ancestors()
        .filter_map(|group| left(&mount.join(group), version))
        .min()
}

/// What one group leaves, where it has a limit.
fn left(group: &Path, version: &Version) -> Option<u64> {
    let number = |name: &str| -> Option<u64> {
        let text = std::fs::read_to_string(group.join(name)).ok()?;
        // "max" is none
        text.trim().parse().ok()
    };
    let limit = version
        .limits
        .iter()
        .filter_map(|name| number(name))
        .min()?;
    let stat = std::fs::read_to_string(group.join("memory.stat")).unwrap_or_default();
    let cache = stat
        .lines()
        .find_map(|line| line.strip_prefix(version.cache)?.trim().parse().ok())
        .unwrap_or(0);
    let usage = number(version.usage)?.saturating_sub(cache);
    Some(limit.saturating_sub(usage))
}

/// Value of a line `key 123 kB` [bytes].
pub(super) fn kibibytes(file: &Path, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    let kibibytes: u64 = line.split_ascii_whitespace().next()?.parse().ok()?;
    Some(1024 * kibibytes)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// Free memory on a machine with these files.
    fn free(name: &str, files: &[(&str, &str)]) -> Option<u64> {
        let root = format!("fracas-free-{}-{name}", std::process::id());
        let root = std::env::temp_dir().join(root);
        std::fs::create_dir_all(&root).unwrap();
        for (name, text) in files {
            let path = root.join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let found = available_below(&root);
        std::fs::remove_dir_all(&root).unwrap();
        found
    }

    const MACHINE: (&str, &str) = ("proc/meminfo", "MemTotal: 900 kB\nMemAvailable:  800 kB\n");
    const SIZE: (&str, &str) = ("proc/self/status", "Name: x\nVmSize:    100 kB\n");
    const IN_GROUP: (&str, &str) = ("proc/self/cgroup", "0::/a/b\n");

    #[test]
    fn without_limits_it_is_that_of_the_machine() {
        assert_eq!(free("none", &[]), None);
        assert_eq!(free("machine", &[MACHINE]), Some(800 * 1024));
        let unlimited = (
            "proc/self/limits",
            "Max address space         unlimited            unlimited            bytes\n",
        );
        let files = [
            MACHINE,
            SIZE,
            unlimited,
            IN_GROUP,
            ("sys/fs/cgroup/a/memory.max", "max\n"),
        ];
        assert_eq!(free("unlimited", &files), Some(800 * 1024));
    }

    #[test]
    fn an_address_space_leaves_what_is_not_mapped() {
        let limited = (
            "proc/self/limits",
            "Limit  Soft Limit  Hard Limit  Units\nMax address space         512000            unlimited            bytes\n",
        );
        assert_eq!(
            free("address", &[MACHINE, SIZE, limited]),
            Some(512_000 - 102_400)
        );
    }

    #[test]
    fn the_tightest_group_counts_and_its_file_cache_does_not() {
        let files = [
            MACHINE,
            IN_GROUP,
            ("sys/fs/cgroup/a/b/memory.max", "max\n"),
            ("sys/fs/cgroup/a/b/memory.high", "300000\n"),
            ("sys/fs/cgroup/a/b/memory.current", "100000\n"),
            (
                "sys/fs/cgroup/a/b/memory.stat",
                "anon 5\ninactive_file 40000\nactive_file 9\n",
            ),
            ("sys/fs/cgroup/a/memory.max", "250000\n"),
            ("sys/fs/cgroup/a/memory.current", "200000\n"),
        ];
        assert_eq!(free("groups", &files), Some(50_000));
        assert_eq!(free("group", &files[..6]), Some(240_000));
    }

    #[test]
    fn the_first_version_is_known_too_and_a_container_sees_its_group_as_the_root() {
        let files = [
            MACHINE,
            (
                "proc/self/cgroup",
                "5:devices:/d\n4:cpu,memory:/far/away\n0::/\n",
            ),
            ("sys/fs/cgroup/memory/memory.limit_in_bytes", "90000\n"),
            ("sys/fs/cgroup/memory/memory.usage_in_bytes", "50000\n"),
            (
                "sys/fs/cgroup/memory/memory.stat",
                "inactive_file 1\ntotal_inactive_file 10000\n",
            ),
        ];
        assert_eq!(free("first", &files), Some(50_000));
    }
}
