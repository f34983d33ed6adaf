//! Nothing is left behind by instances, their threads and the library: memory, threads, and what runs when a thread of
//! the host ends. Each test is a process of its own: the other tests of this one allocate at the same time.

use crate::fmu::*;
use crate::instances::{large, start_large};
use libloading::{Library, Symbol};
use std::ffi::{CString, c_char, c_int};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

const CHILD: &str = "FMI_CHILD";

/// \[bytes\] The allocator's habits are some 20 kB; one leaked state in each life is 900 kB.
const SLACK: i64 = 256 << 10;

/// Runs the test again, alone in a process; whether this is that process.
fn alone(test: &str) -> bool {
    if std::env::var_os(CHILD).is_some() {
        return true;
    }
    let mut child = Command::new(std::env::current_exe().unwrap());
    let test = format!("processes::{test}");
    child.args(["--exact", &test, "--nocapture"]).env(CHILD, "1").env(PACKED, packed());
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

/// Repeats a life and compares the memory \[bytes\] after `warm` ones with that at the end.
fn does_not_grow(slack: i64, times: usize, warm: usize, mut life: impl FnMut()) {
    (0..warm).for_each(|_| life());
    let before = resident();
    (warm..times).for_each(|_| life());
    let grown = resident() - before;
    assert!(grown < slack, "{grown} bytes more after {} further ones", times - warm);
}

fn one_life(fmu: &Fmu, version: Version) {
    let crowd = Crowd::of(fmu, version, &packed().join("resources"));
    crowd.push_and_initialize();
    crowd.steps(0, 2);
    let bytes = crowd.bytes();
    crowd.must(crowd.restore(&bytes));
    crowd.discarded(crowd.set("agent[0].Fp.x", f64::NAN));
    crowd.must(crowd.terminate());
}

#[test]
fn instances_leave_nothing_behind() {
    if !alone("instances_leave_nothing_behind") {
        return;
    }
    let broken = Resources::edited("static/Agents.xml", "89.0", "much");
    for version in BOTH {
        does_not_grow(SLACK, 300, 100, || {
            one_life(Fmu::get(), version);
            assert!(Crowd::try_of(Fmu::get(), version, &broken.directory()).is_err());
            let location = version.location(&packed().join("resources"));
            assert!(instantiate(Fmu::get(), version, "{}", &location).is_err());
        });
    }
}

/// More often than glibc has keys for thread-local data (1024): hosts load anew for each run.
#[test]
fn the_library_can_be_loaded_and_unloaded_without_end() {
    if !alone("the_library_can_be_loaded_and_unloaded_without_end") {
        return;
    }
    let path = library_path();
    let mapped =
        |path: &Path| std::fs::read_to_string("/proc/self/maps").unwrap().contains(path.to_str().unwrap());
    let mut version = BOTH.into_iter().cycle();
    does_not_grow(SLACK, 1100, 100, || {
        let fmu = Fmu::load(&path);
        assert!(mapped(&path));
        one_life(&fmu, version.next().unwrap());
        drop(fmu);
        assert!(!mapped(&path), "the library stays loaded");
    });
}

/// Of this process.
fn threads_now() -> usize {
    std::fs::read_dir("/proc/self/task").unwrap().count()
}

/// \[s\] The system lists a thread for a moment after whoever joined it has gone on.
const LISTED: u64 = 600;

/// Waits for the system to list no more threads than `expected`, and requires that many.
fn threads_are(expected: usize, what: &str) {
    let end = Instant::now() + Duration::from_secs(LISTED);
    while threads_now() > expected && Instant::now() < end {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(threads_now(), expected, "{what}");
}

/// A pool is there only where it is asked for and of use, and gone when the instance is.
#[test]
fn threads_end_with_their_instance() {
    if !alone("threads_end_with_their_instance") {
        return;
    }
    let before = threads_now();
    let fmu = Fmu::load(&library_path());
    for _ in 0..10 {
        let (one, two, three) = (start_large(&fmu, 1), start_large(&fmu, 2), start_large(&fmu, 3));
        threads_are(before + 2 + 3, "each instance has its own");
        two.steps(0, 1);
        let state = two.save();
        two.steps(1, 2);
        two.must(two.set_state(state));
        two.free(state);
        threads_are(before + 2 + 3, "a state that is set keeps the threads");
        drop(two);
        threads_are(before + 3, "an instance ends with its threads");
        three.reset();
        threads_are(before, "a reset ends them");
        let small = Crowd::of(&fmu, V2, &packed().join("resources"));
        small.must(small.try_integer("Threads", 8));
        small.push_and_initialize();
        small.steps(0, 1);
        threads_are(before, "five people are not shared out");
        drop(one);
    }
}

fn crowd_mechanics(library: &Path, names: [&str; 5]) -> c_int {
    type CrowdMechanics = unsafe extern "C" fn(*const *const c_char) -> c_int;
    let names = names.map(|name| CString::new(name).unwrap());
    let pointers = names.each_ref().map(|name| name.as_ptr());
    // SAFETY: five texts that end with a zero.
    unsafe {
        let library = Library::new(library).unwrap();
        let function: Symbol<CrowdMechanics> = library.get(b"CrowdMechanics\0").unwrap();
        function(pointers.as_ptr())
    }
}

/// Threads that outlived the library would run into nothing. Nor may anything of the library be called when a host's
/// thread ends after it: a thread-local with a destructor anywhere in it would be, and crash the host.
#[test]
fn the_library_may_be_unloaded_right_after() {
    if !alone("the_library_may_be_unloaded_right_after") {
        return;
    }
    large();
    let trial = tempfile::tempdir().unwrap();
    copy_tree(&paper(), trial.path());
    edit(&trial.path().join("Parameters.xml"), "2e-6", "1e-4");
    let parameters = trial.path().join("Parameters.xml");
    let use_it = || {
        let (path, output) = (library_path(), tempfile::tempdir().unwrap());
        let fmu = Fmu::load(&path);
        let crowd = Crowd::of(&fmu, V2, &packed().join("resources"));
        crowd.must(crowd.set_text("OutputDirectory", output.path().to_str().unwrap()));
        crowd.push_and_initialize();
        crowd.steps(0, 4);
        let bytes = crowd.bytes();
        crowd.must(crowd.restore(&bytes));
        crowd.discarded(crowd.set("agent[0].Fp.x", f64::NAN));
        assert!(instantiate(&fmu, V2, "{}", "").is_err());
        let crowd = start_large(&fmu, 4);
        crowd.must(crowd.try_step(0.0, 5e-5));
        let names = |dynamics| {
            [parameters.to_str().unwrap(), "Materials.xml", "Geometry.xml", "Agents.xml", dynamics]
        };
        assert_eq!(crowd_mechanics(&path, names("AgentDynamics.xml")), 0);
        // The message on standard error must not leave anything behind either.
        assert_eq!(crowd_mechanics(&path, names("Nothing.xml")), 1);
    };
    // The allocator keeps something for each thread that runs at once, 2 MB of it in unlucky runs; four stacks left
    // behind in each life, or an instance, are 5 MB and more.
    does_not_grow(4 << 20, 60, 20, || {
        std::thread::scope(|scope| scope.spawn(use_it).join().expect("the thread ended in order"));
    });
}
