//! A host's thread used the library, the library was unloaded, the thread ends: nothing of the library
//! may be called then. A thread-local with a destructor anywhere in it would be, and crash the host.

use crate::fmu::*;
use crate::memory::alone;
use libloading::{Library, Symbol};
use std::ffi::{CString, c_char, c_int};
use std::path::Path;

/// On a thread that loads the library, uses it, unloads it and ends.
fn on_a_thread(use_it: impl FnOnce(&Path) + Send + 'static) {
    std::thread::spawn(move || use_it(&library_path())).join().expect("the thread ended in order");
}

fn crowd_mechanics(library: &Path, names: [&str; 5]) -> c_int {
    type CrowdMechanics = unsafe extern "C" fn(*const *const c_char) -> c_int;
    let names = names.map(|name| CString::new(name).unwrap());
    let pointers = names.each_ref().map(|name| name.as_ptr());
    unsafe {
        let library = Library::new(library).unwrap();
        let function: Symbol<CrowdMechanics> = library.get(b"CrowdMechanics\0").unwrap();
        function(pointers.as_ptr())
    }
}

#[test]
fn a_thread_that_stepped_may_end_after_the_library() {
    if !alone("unloading::a_thread_that_stepped_may_end_after_the_library") {
        return;
    }
    for _ in 0..20 {
        on_a_thread(|path| {
            let output = tempfile::tempdir().unwrap();
            let fmu = Fmu::load(path);
            let instance = Instance::new(&fmu);
            instance.must(instance.set_string("OutputDirectory", output.path().to_str().unwrap()));
            instance.push_and_initialize();
            instance.steps(0, 4);
            let bytes = instance.bytes();
            instance.must(instance.restore_bytes(&bytes));
            instance.refused(instance.set("agent[0].Mass", f64::NAN));
            assert!(instantiate(&fmu, "{}", shared_uri()).is_err());
        });
    }
}

#[test]
fn a_thread_that_called_crowd_mechanics_may_end_after_the_library() {
    if !alone("unloading::a_thread_that_called_crowd_mechanics_may_end_after_the_library") {
        return;
    }
    for _ in 0..20 {
        on_a_thread(|path| {
            let trial = tempfile::tempdir().unwrap();
            copy_tree(&paper(), trial.path());
            let parameters = trial.path().join("Parameters.xml");
            let parameters = parameters.to_str().unwrap();
            let names = |dynamics| [parameters, "Materials.xml", "Geometry.xml", "Agents.xml", dynamics];
            assert_eq!(crowd_mechanics(path, names("AgentDynamics.xml")), 0);
            // The message on standard error must not leave anything behind either.
            assert_eq!(crowd_mechanics(path, names("Nothing.xml")), 1);
        });
    }
}
