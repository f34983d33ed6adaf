//! The built library, an unpacked FMU of it, and an instance with its log.

use crowd_mechanics::arrays::{SIZES, arrays};
use crowd_mechanics::model::CrowdModel;
use lemons_fmi::v3::arrays::{array_reference, size_reference};
use lemons_fmi::v3::token;
use lemons_testing::fmi3::{Functions, IntermediateUpdate, Log, log};
use lemons_testing::{copy_tree, trial_push};
use libloading::Library;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};
use std::sync::OnceLock;
use tempfile::TempDir;

pub const OK: c_int = 0;
pub const ERROR: c_int = 3;
/// \[s\] a communication step
pub const STEP: f64 = 0.05;
/// Agents of the paper's Trial.
pub const AGENTS: usize = 5;

/// Where cargo puts the library: beside the test executable, or one directory up.
pub fn library_path() -> PathBuf {
    let executable = std::env::current_exe().expect("the test's own path");
    let mut places = executable.ancestors().skip(1).take(2).map(|d| d.join("libcrowd_mechanics.so"));
    places.find(|path| path.is_file()).expect("`cargo test` builds the library")
}

/// A loaded library.
pub struct Fmu {
    pub c: Functions,
    _library: Library,
}

impl Fmu {
    pub fn load() -> Fmu {
        let library = unsafe { Library::new(library_path()) }.expect("a library");
        Fmu { c: Functions::of(&library), _library: library }
    }

    /// One for all tests.
    pub fn get() -> &'static Fmu {
        static FMU: OnceLock<Fmu> = OnceLock::new();
        FMU.get_or_init(Fmu::load)
    }
}

/// Resources with the paper's Trial, and one of three of its agents and the same materials.
pub struct Resources(TempDir);

impl Resources {
    pub fn new() -> Resources {
        let root = tempfile::tempdir().unwrap();
        copy_tree(&trial_push(), &root.path().join("Trial_push"));
        copy_tree(&trial_push(), &root.path().join("Trial_three"));
        for file in ["static/Agents.xml", "dynamic/AgentDynamics.xml"] {
            let path = root.path().join("Trial_three").join(file);
            let text = std::fs::read_to_string(&path).unwrap();
            let fourth = text.match_indices("<Agent ").nth(3).unwrap().0;
            let end = text.rfind("</Agents>").unwrap();
            std::fs::write(&path, text[..fourth].to_owned() + &text[end..]).unwrap();
        }
        Resources(root)
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Of all tests.
    pub fn shared() -> &'static Resources {
        static RESOURCES: OnceLock<Resources> = OnceLock::new();
        RESOURCES.get_or_init(Resources::new)
    }
}

/// The value reference of a variable.
pub fn reference(name: &str) -> u32 {
    if name == "time" {
        return 0;
    }
    if let Some(place) = SIZES.iter().position(|size| size.name == name) {
        return size_reference(place);
    }
    let place = arrays().iter().position(|array| array.name == name);
    array_reference::<CrowdModel>(place.unwrap_or_else(|| panic!("no variable {name}")))
}

/// An instance; freed when dropped.
pub struct Instance<'f> {
    pub raw: *mut c_void,
    pub c: &'f Functions,
    pub log: Box<Log>,
}

impl Drop for Instance<'_> {
    fn drop(&mut self) {
        unsafe { (self.c.fmi3FreeInstance)(self.raw) };
    }
}

impl<'f> Instance<'f> {
    pub fn new() -> Instance<'static> {
        Instance::of(Fmu::get(), None, false).expect("an instance")
    }

    /// With a callback within steps, whose environment is the log.
    pub fn of(fmu: &'f Fmu, update: Option<IntermediateUpdate>, early: bool) -> Result<Self, String> {
        let token = token::<CrowdModel>().braced().to_string();
        Instance::with(fmu, &token, Resources::shared().path(), update, early)
    }

    pub fn with(
        fmu: &'f Fmu,
        token: &str,
        path: &Path,
        update: Option<IntermediateUpdate>,
        early: bool,
    ) -> Result<Self, String> {
        let log_of = Box::new(Log::default());
        let (token, path) = (CString::new(token).unwrap(), CString::new(path.to_str().unwrap()).unwrap());
        let environment = std::ptr::from_ref(&*log_of).cast_mut().cast();
        let function: Option<lemons_testing::fmi3::Logger3> = Some(log);
        let raw = unsafe {
            (fmu.c.fmi3InstantiateCoSimulation)(
                c"crowd".as_ptr(),
                token.as_ptr(),
                path.as_ptr(),
                false,
                true,
                false,
                early,
                null(),
                0,
                environment,
                function,
                update,
            )
        };
        if raw.is_null() {
            let said = log_of.take();
            assert_eq!(said.len(), 1, "{said:?}");
            return Err(said[0].2.clone());
        }
        Ok(Instance { raw, c: &fmu.c, log: log_of })
    }

    #[track_caller]
    pub fn must(&self, status: c_int) {
        assert_eq!(status, OK, "{:?}", self.log.take());
    }

    /// The one message of a call that was refused.
    #[track_caller]
    pub fn refused(&self, status: c_int) -> String {
        let said = self.log.take();
        assert_eq!(status, ERROR, "{said:?}");
        let [(ERROR, category, text)] = &*said else { panic!("{said:?}") };
        assert_eq!(category, "logStatusError");
        text.clone()
    }

    pub fn try_set(&self, name: &str, values: &[f64]) -> c_int {
        let set = self.c.fmi3SetFloat64;
        unsafe { set(self.raw, &reference(name), 1, values.as_ptr(), values.len()) }
    }

    #[track_caller]
    pub fn set(&self, name: &str, values: &[f64]) {
        self.must(self.try_set(name, values));
    }

    pub fn try_get(&self, name: &str, length: usize) -> (c_int, Vec<f64>) {
        let mut values = vec![f64::NAN; length];
        let get = self.c.fmi3GetFloat64;
        (unsafe { get(self.raw, &reference(name), 1, values.as_mut_ptr(), length) }, values)
    }

    #[track_caller]
    pub fn get(&self, name: &str, length: usize) -> Vec<f64> {
        let (status, values) = self.try_get(name, length);
        self.must(status);
        values
    }

    #[track_caller]
    pub fn get_integers(&self, name: &str, length: usize) -> Vec<i32> {
        let mut values = vec![-7; length];
        let get = self.c.fmi3GetInt32;
        self.must(unsafe { get(self.raw, &reference(name), 1, values.as_mut_ptr(), length) });
        values
    }

    pub fn try_set_integer(&self, name: &str, value: i32) -> c_int {
        unsafe { (self.c.fmi3SetInt32)(self.raw, &reference(name), 1, &value, 1) }
    }

    pub fn try_set_size(&self, name: &str, value: u64) -> c_int {
        unsafe { (self.c.fmi3SetUInt64)(self.raw, &reference(name), 1, &value, 1) }
    }

    #[track_caller]
    pub fn size(&self, name: &str) -> u64 {
        let mut value = 0;
        self.must(unsafe { (self.c.fmi3GetUInt64)(self.raw, &reference(name), 1, &mut value, 1) });
        value
    }

    pub fn try_set_text(&self, name: &str, value: &str) -> c_int {
        let value = CString::new(value).unwrap();
        let values: [*const c_char; 1] = [value.as_ptr()];
        unsafe { (self.c.fmi3SetString)(self.raw, &reference(name), 1, values.as_ptr(), 1) }
    }

    #[track_caller]
    pub fn texts(&self, name: &str, length: usize) -> Vec<String> {
        let mut values: Vec<*const c_char> = vec![null(); length];
        let get = self.c.fmi3GetString;
        self.must(unsafe { get(self.raw, &reference(name), 1, values.as_mut_ptr(), length) });
        values.iter().map(|text| unsafe { CStr::from_ptr(*text) }.to_str().unwrap().to_owned()).collect()
    }

    #[track_caller]
    pub fn enter_initialization(&self) {
        self.must(unsafe { (self.c.fmi3EnterInitializationMode)(self.raw, false, 0.0, 0.0, false, 0.0) });
    }

    #[track_caller]
    pub fn initialize(&self) {
        self.enter_initialization();
        self.must(unsafe { (self.c.fmi3ExitInitializationMode)(self.raw) });
    }

    /// Agent 0 is pushed with 500 N along x.
    #[track_caller]
    pub fn push(&self) {
        let mut drive = [0.0; 2 * AGENTS];
        drive[0] = 500.0;
        self.set("Fp", &drive);
    }

    /// Status, whether it returned early, and the time \[s\] that was reached.
    pub fn try_step(&self, from: f64, step: f64) -> (c_int, bool, f64) {
        let (mut event, mut terminate, mut early, mut time) = (true, true, true, f64::NAN);
        let status = unsafe {
            (self.c.fmi3DoStep)(self.raw, from, step, true, &mut event, &mut terminate, &mut early, &mut time)
        };
        assert!(!event && !terminate, "they are always set");
        (status, early, time)
    }

    #[track_caller]
    pub fn steps(&self, from: u32, to: u32) {
        for k in from..to {
            let (status, early, time) = self.try_step(f64::from(k) * STEP, STEP);
            self.must(status);
            assert!(!early && (time - f64::from(k + 1) * STEP).abs() < 1e-12, "{time}");
        }
    }

    /// All that is continuous.
    #[track_caller]
    pub fn motion(&self) -> Vec<f64> {
        let of = |(name, n): (&str, usize)| self.get(name, n * AGENTS);
        let names = [
            ("Position", 2),
            ("Theta", 1),
            ("Velocity", 2),
            ("Omega", 1),
            ("MeanNormalForce", 1),
            ("PeakNormalForce", 1),
            ("NormalForce", 1),
            ("PeakOverlap", 1),
        ];
        names.into_iter().flat_map(of).collect()
    }

    #[track_caller]
    pub fn save(&self) -> *mut c_void {
        let mut state = null_mut();
        self.must(unsafe { (self.c.fmi3GetFMUState)(self.raw, &mut state) });
        state
    }

    #[track_caller]
    pub fn free(&self, mut state: *mut c_void) {
        self.must(unsafe { (self.c.fmi3FreeFMUState)(self.raw, &mut state) });
        assert!(state.is_null());
    }

    #[track_caller]
    pub fn bytes(&self) -> Vec<u8> {
        let state = self.save();
        let mut size = 0;
        self.must(unsafe { (self.c.fmi3SerializedFMUStateSize)(self.raw, state, &mut size) });
        let mut bytes = vec![0; size];
        self.must(unsafe { (self.c.fmi3SerializeFMUState)(self.raw, state, bytes.as_mut_ptr(), size) });
        self.free(state);
        bytes
    }

    /// The status of the first call that is refused.
    pub fn restore(&self, bytes: &[u8]) -> c_int {
        let mut state = null_mut();
        let read = self.c.fmi3DeserializeFMUState;
        let status = unsafe { read(self.raw, bytes.as_ptr(), bytes.len(), &mut state) };
        if status != OK {
            return status;
        }
        let status = unsafe { (self.c.fmi3SetFMUState)(self.raw, state) };
        let freed = unsafe { (self.c.fmi3FreeFMUState)(self.raw, &mut state) };
        assert_eq!(freed, OK);
        status
    }
}
