//! Nothing is left behind by instances, nor by the library. Each test measures a process of its own: the
//! other tests of this one allocate at the same time.

use crate::fmu::*;
use std::path::Path;
use std::process::Command;

const CHILD: &str = "FMI2_MEMORY_CHILD";

/// \[bytes\] The allocator's habits are some 20 kB; one leaked state in each life is 900 kB.
const SLACK: i64 = 256 << 10;

/// Runs the test again, alone in a process; whether this is that process.
pub fn alone(test: &str) -> bool {
    if std::env::var_os(CHILD).is_some() {
        return true;
    }
    let executable = std::env::current_exe().unwrap();
    let mut child = Command::new(executable);
    child.args(["--exact", test, "--nocapture"]).env(CHILD, "1").env(PACKED, packed());
    let output = child.output().unwrap();
    let told = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && told.contains("1 passed"), "{:?}\n{told}", output.status);
    false
}

/// \[bytes\] resident set of this process.
fn resident() -> i64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    let kilobytes: i64 = line.trim().trim_end_matches(" kB").parse().unwrap();
    kilobytes << 10
}

fn one_life(fmu: &Fmu) {
    let instance = Instance::pushed(fmu);
    instance.steps(0, 2);
    let bytes = instance.bytes();
    instance.must(instance.restore_bytes(&bytes));
    instance.refused(instance.set("agent[0].Mass", -1.0));
    instance.must(unsafe { (instance.fmu.c.fmi2Terminate)(instance.raw) });
}

/// Repeats a life and compares the memory \[bytes\] after `warm` ones with that at the end.
pub fn does_not_grow(slack: i64, times: usize, warm: usize, mut life: impl FnMut()) {
    (0..warm).for_each(|_| life());
    let before = resident();
    (warm..times).for_each(|_| life());
    let grown = resident() - before;
    assert!(grown < slack, "{grown} bytes more after {} further ones", times - warm);
}

#[test]
fn instances_leave_nothing_behind() {
    if !alone("memory::instances_leave_nothing_behind") {
        return;
    }
    does_not_grow(SLACK, 1000, 50, || one_life(Fmu::get()));
}

#[test]
fn refused_instances_leave_nothing_behind() {
    if !alone("memory::refused_instances_leave_nothing_behind") {
        return;
    }
    let broken = Resources::edited("static/Agents.xml", "89.0", "much");
    does_not_grow(SLACK, 1000, 200, || {
        assert!(instantiate(Fmu::get(), &Model::paper().guid, &broken.uri()).is_err());
        assert!(instantiate(Fmu::get(), "{}", shared_uri()).is_err());
    });
}

/// More often than glibc has keys for thread-local data (1024): hosts load anew for each run.
#[test]
fn the_library_can_be_loaded_and_unloaded_without_end() {
    if !alone("memory::the_library_can_be_loaded_and_unloaded_without_end") {
        return;
    }
    let path = library_path();
    let mapped =
        |path: &Path| std::fs::read_to_string("/proc/self/maps").unwrap().contains(path.to_str().unwrap());
    does_not_grow(SLACK, 1100, 100, || {
        let fmu = Fmu::load(&path);
        assert!(mapped(&path));
        one_life(&fmu);
        drop(fmu);
        assert!(!mapped(&path), "the library stays loaded");
    });
}
