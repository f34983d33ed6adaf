//! The built library, packed FMUs of it, and an instance with its log.

use crowd_mechanics::pack::{Binary, Package, host_platform};
use crowd_mechanics::setup;
use crowd_mechanics::variables::{Kind, guid, table};
pub use lemons_testing::fmi2::*;
pub use lemons_testing::{copy_tree, trial_push as paper};
use libloading::Library;
use std::collections::HashMap;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};
use std::sync::OnceLock;
use tempfile::TempDir;

/// A loaded library.
pub struct Fmu {
    pub c: Functions,
    _library: Library,
}

/// Where cargo puts the library: beside the test executable, or one directory up.
pub fn library_path() -> PathBuf {
    let executable = std::env::current_exe().expect("the test's own path");
    let directories = executable.ancestors().skip(1).take(2);
    let places: Vec<PathBuf> = directories.map(|d| d.join("libcrowd_mechanics.so")).collect();
    places
        .iter()
        .find(|path| path.is_file())
        .unwrap_or_else(|| panic!("no library at {places:?}: `cargo test -p crowd-mechanics` builds it"))
        .clone()
}

/// The binary's place in an FMU.
pub fn binary() -> PathBuf {
    format!("binaries/{}/CrowdMechanics.so", host_platform().unwrap()).into()
}

/// Packs the paper's Trial with the built library and unzips the FMU.
pub fn unzip_packed(directory: &Path) {
    let fmu = directory.join("crowd.fmu");
    let library = Binary { platform: host_platform().unwrap().into(), path: library_path() };
    let package = Package { trials: vec![paper()], binaries: vec![library], ..Package::default() };
    assert!(package.write(&fmu).unwrap().is_empty(), "no warning");
    zip::ZipArchive::new(std::fs::File::open(fmu).unwrap()).unwrap().extract(directory).unwrap();
}

/// Tells a child process where its parent's packed FMU lies.
pub const PACKED: &str = "FMI2_PACKED";

/// An FMU of the paper's Trial, packed and unzipped: one for all tests of this process.
pub fn packed() -> &'static Path {
    static DIRECTORY: OnceLock<PathBuf> = OnceLock::new();
    DIRECTORY.get_or_init(|| {
        if let Some(parents) = std::env::var_os(PACKED) {
            return parents.into();
        }
        // Statics are not dropped: what ended processes have left is removed here.
        let all = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fmi2");
        std::fs::create_dir_all(&all).unwrap();
        for old in std::fs::read_dir(&all).unwrap().map(|entry| entry.unwrap()) {
            if !Path::new("/proc").join(old.file_name()).exists() {
                let _ = std::fs::remove_dir_all(old.path());
            }
        }
        let own = all.join(std::process::id().to_string());
        std::fs::create_dir_all(&own).unwrap();
        unzip_packed(&own);
        own
    })
}

impl Fmu {
    pub fn load(path: &Path) -> Fmu {
        let library =
            unsafe { Library::new(path) }.unwrap_or_else(|error| panic!("cannot load {path:?}: {error}"));
        Fmu { c: Functions::of(&library), _library: library }
    }

    /// One for all tests: the binary of a packed FMU.
    pub fn get() -> &'static Fmu {
        static FMU: OnceLock<Fmu> = OnceLock::new();
        FMU.get_or_init(|| Fmu::load(&packed().join(binary())))
    }
}

/// An unpacked FMU's `resources`, with a copy of the paper's Trial; gone when dropped.
pub struct Resources {
    pub root: TempDir,
}

impl Resources {
    pub fn new() -> Resources {
        let root = tempfile::tempdir().unwrap();
        copy_tree(&paper(), &root.path().join("resources/Trial_push"));
        Resources { root }
    }

    pub fn directory(&self) -> PathBuf {
        self.root.path().join("resources")
    }

    pub fn trial(&self) -> PathBuf {
        self.directory().join("Trial_push")
    }

    pub fn uri(&self) -> String {
        format!("file://{}", self.directory().display())
    }

    /// With a text in one file of the Trial replaced, where it first stands.
    pub fn edited(file: &str, from: &str, to: &str) -> Resources {
        let resources = Resources::new();
        resources.edit(file, from, to);
        resources
    }

    pub fn edit(&self, file: &str, from: &str, to: &str) {
        let path = self.trial().join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{file} has no {from:?}");
        std::fs::write(path, text.replacen(from, to, 1)).unwrap();
    }
}

/// Whether a Real is computed, so that nobody sets it.
pub fn computed(name: &str) -> bool {
    name.ends_with("NormalForce") || name.ends_with("Overlap")
}

/// Names, references and GUID of a Trial's FMU.
pub struct Model {
    pub guid: String,
    pub references: HashMap<String, u32>,
    /// Of the Reals, in the table's order.
    pub reals: Vec<(String, u32)>,
    pub integers: Vec<(String, u32)>,
}

impl Model {
    pub fn of(trial: &Path) -> Model {
        let (trial, _) = setup::read(trial).expect("a good Trial");
        let table = table(&trial);
        let of_kind = |wanted: fn(Kind) -> bool| {
            let rows = table.iter().zip(0..).filter(|(row, _)| wanted(row.kind));
            rows.map(|(row, reference)| (row.name.clone(), reference)).collect()
        };
        Model {
            guid: guid(&table).braced().to_string(),
            references: table.iter().zip(0..).map(|(row, reference)| (row.name.clone(), reference)).collect(),
            reals: of_kind(|kind| matches!(kind, Kind::Real(_))),
            integers: of_kind(|kind| kind == Kind::Integer),
        }
    }

    /// Of the paper's Trial.
    pub fn paper() -> &'static Model {
        static MODEL: OnceLock<Model> = OnceLock::new();
        MODEL.get_or_init(|| Model::of(&paper()))
    }

    pub fn reference(&self, name: &str) -> u32 {
        *self.references.get(name).unwrap_or_else(|| panic!("no variable {name}"))
    }
}

/// The resources of the packed FMU, for all tests.
pub fn shared_uri() -> &'static str {
    static URI: OnceLock<String> = OnceLock::new();
    URI.get_or_init(|| format!("file://{}", packed().join("resources").display()))
}

/// The result of `fmi2Instantiate`: an instance with the paper's variables, or what was logged.
pub fn instantiate<'f>(fmu: &'f Fmu, guid: &str, uri: &str) -> Result<Instance<'f>, Vec<Message>> {
    instantiate_with(fmu, guid, uri, true)
}

/// The same with a value of `loggingOn`.
pub fn instantiate_with<'f>(
    fmu: &'f Fmu,
    guid: &str,
    uri: &str,
    logging: bool,
) -> Result<Instance<'f>, Vec<Message>> {
    let log = Box::new(Log::default());
    let (guid, uri) = (CString::new(guid).unwrap(), CString::new(uri).unwrap());
    // Not the log's: importers may keep the callbacks on the stack.
    let callbacks = log.callbacks();
    let raw = unsafe {
        (fmu.c.fmi2Instantiate)(
            c"crowd".as_ptr(),
            CO_SIMULATION,
            guid.as_ptr(),
            uri.as_ptr(),
            &callbacks,
            0,
            logging.into(),
        )
    };
    if raw.is_null() { Err(log.take()) } else { Ok(Instance { raw, fmu, log, model: Model::paper() }) }
}

/// An instance; freed when dropped.
pub struct Instance<'f> {
    pub raw: *mut c_void,
    pub fmu: &'f Fmu,
    pub log: Box<Log>,
    pub model: &'static Model,
}

// SAFETY: FMI 2.0 lets instances move between threads.
unsafe impl Send for Instance<'_> {}

impl Drop for Instance<'_> {
    fn drop(&mut self) {
        unsafe { (self.fmu.c.fmi2FreeInstance)(self.raw) }
    }
}

/// \[s\] communication step of the tests.
pub const STEP: f64 = 0.01;

/// Every Real and Integer, bit for bit.
pub type Bits = (Vec<u64>, Vec<c_int>);

impl<'f> Instance<'f> {
    /// On the paper's Trial.
    pub fn new(fmu: &'f Fmu) -> Instance<'f> {
        instantiate(fmu, &Model::paper().guid, shared_uri()).unwrap_or_else(|log| panic!("{log:?}"))
    }

    /// Fast enough for tests: 1e-5 s mechanical steps, agent 0 pushed with 700 N.
    pub fn pushed(fmu: &'f Fmu) -> Instance<'f> {
        let instance = Instance::new(fmu);
        instance.push_and_initialize();
        instance
    }

    pub fn push_and_initialize(&self) {
        self.must(self.set("TimeStepMechanical", 1e-5));
        self.must(self.set("agent[0].Fp.x", 700.0));
        self.initialize();
    }

    /// At time 0, without an end.
    pub fn enter_initialization(&self) {
        unsafe {
            self.must((self.fmu.c.fmi2SetupExperiment)(self.raw, 0, 0.0, 0.0, 0, 0.0));
            self.must((self.fmu.c.fmi2EnterInitializationMode)(self.raw));
        }
    }

    pub fn initialize(&self) {
        self.enter_initialization();
        self.must(unsafe { (self.fmu.c.fmi2ExitInitializationMode)(self.raw) });
    }

    #[track_caller]
    pub fn must(&self, status: c_int) {
        let log = self.log.take();
        assert_eq!(status, OK, "{log:?}");
    }

    /// Asserts an error with a message, and returns the message.
    #[track_caller]
    pub fn refused(&self, status: c_int) -> String {
        let log = self.log.take();
        assert_eq!(status, ERROR, "{log:?}");
        let [message] = &*log else { panic!("one message for one refusal, not {log:?}") };
        assert_eq!((message.status, &*message.category), (ERROR, "logStatusError"), "{message:?}");
        assert_eq!((&*message.instance, &*message.format), ("crowd", "%s"), "{message:?}");
        message.text.clone()
    }

    pub fn set_references(&self, references: &[u32], values: &[f64]) -> c_int {
        assert_eq!(references.len(), values.len());
        unsafe { (self.fmu.c.fmi2SetReal)(self.raw, references.as_ptr(), references.len(), values.as_ptr()) }
    }

    pub fn set_all(&self, values: &[(&str, f64)]) -> c_int {
        let references: Vec<u32> = values.iter().map(|(name, _)| self.model.reference(name)).collect();
        let values: Vec<f64> = values.iter().map(|(_, value)| *value).collect();
        self.set_references(&references, &values)
    }

    pub fn set(&self, name: &str, value: f64) -> c_int {
        self.set_all(&[(name, value)])
    }

    pub fn set_integer(&self, name: &str, value: c_int) -> c_int {
        unsafe { (self.fmu.c.fmi2SetInteger)(self.raw, &self.model.reference(name), 1, &value) }
    }

    pub fn set_boolean(&self, name: &str, value: bool) -> c_int {
        unsafe { (self.fmu.c.fmi2SetBoolean)(self.raw, &self.model.reference(name), 1, &value.into()) }
    }

    pub fn set_string(&self, name: &str, value: &str) -> c_int {
        let value = CString::new(value).unwrap();
        unsafe { (self.fmu.c.fmi2SetString)(self.raw, &self.model.reference(name), 1, &value.as_ptr()) }
    }

    pub fn try_get(&self, name: &str) -> (c_int, f64) {
        let mut value = f64::NAN;
        let status =
            unsafe { (self.fmu.c.fmi2GetReal)(self.raw, &self.model.reference(name), 1, &mut value) };
        (status, value)
    }

    #[track_caller]
    pub fn get(&self, name: &str) -> f64 {
        let (status, value) = self.try_get(name);
        self.must(status);
        value
    }

    #[track_caller]
    pub fn get_integer(&self, name: &str) -> c_int {
        let mut value = c_int::MIN;
        let reference = self.model.reference(name);
        self.must(unsafe { (self.fmu.c.fmi2GetInteger)(self.raw, &reference, 1, &mut value) });
        value
    }

    #[track_caller]
    pub fn get_string(&self, name: &str) -> String {
        let mut value = null();
        let reference = self.model.reference(name);
        self.must(unsafe { (self.fmu.c.fmi2GetString)(self.raw, &reference, 1, &mut value) });
        unsafe { CStr::from_ptr(value) }.to_str().unwrap().to_owned()
    }

    pub fn try_step(&self, from: f64, step: f64) -> c_int {
        unsafe { (self.fmu.c.fmi2DoStep)(self.raw, from, step, 1) }
    }

    /// Steps number `first` to `last - 1` from time 0.
    #[track_caller]
    pub fn steps(&self, first: usize, last: usize) {
        for k in first..last {
            self.must(self.try_step(k as f64 * STEP, STEP));
        }
    }

    #[track_caller]
    pub fn everything(&self) -> Bits {
        let references = |rows: &[(String, u32)]| rows.iter().map(|row| row.1).collect::<Vec<u32>>();
        let (reals, integers) = (references(&self.model.reals), references(&self.model.integers));
        let (mut real, mut integer) = (vec![f64::NAN; reals.len()], vec![c_int::MIN; integers.len()]);
        unsafe {
            self.must((self.fmu.c.fmi2GetReal)(self.raw, reals.as_ptr(), reals.len(), real.as_mut_ptr()));
            let (references, values) = (integers.as_ptr(), integer.as_mut_ptr());
            self.must((self.fmu.c.fmi2GetInteger)(self.raw, references, integers.len(), values));
        }
        (real.into_iter().map(f64::to_bits).collect(), integer)
    }

    #[track_caller]
    pub fn save(&self) -> *mut c_void {
        let mut state = null_mut();
        self.must(unsafe { (self.fmu.c.fmi2GetFMUstate)(self.raw, &mut state) });
        state
    }

    #[track_caller]
    pub fn free_state(&self, mut state: *mut c_void) {
        self.must(unsafe { (self.fmu.c.fmi2FreeFMUstate)(self.raw, &mut state) });
        assert!(state.is_null());
    }

    /// The present state as bytes: with the phase and the time in it, all that an instance is.
    #[track_caller]
    pub fn bytes(&self) -> Vec<u8> {
        let state = self.save();
        let mut size = 0;
        self.must(unsafe { (self.fmu.c.fmi2SerializedFMUstateSize)(self.raw, state, &mut size) });
        let mut bytes = vec![0; size];
        let buffer = bytes.as_mut_ptr();
        self.must(unsafe { (self.fmu.c.fmi2SerializeFMUstate)(self.raw, state, buffer, size) });
        self.free_state(state);
        bytes
    }

    /// `fmi2DeSerializeFMUstate`, then `fmi2SetFMUstate`; the first status that is not `fmi2OK`.
    pub fn restore_bytes(&self, bytes: &[u8]) -> c_int {
        let mut state = null_mut();
        let status = unsafe {
            (self.fmu.c.fmi2DeSerializeFMUstate)(self.raw, bytes.as_ptr(), bytes.len(), &mut state)
        };
        if status != OK {
            assert!(state.is_null(), "a refused state is not handed out");
            return status;
        }
        let status = unsafe { (self.fmu.c.fmi2SetFMUstate)(self.raw, state) };
        let freed = unsafe { (self.fmu.c.fmi2FreeFMUstate)(self.raw, &mut state) };
        assert_eq!(freed, OK);
        status
    }

    pub fn log_on(&self, on: bool, categories: &[&str]) -> c_int {
        let categories: Vec<CString> = categories.iter().map(|text| CString::new(*text).unwrap()).collect();
        let pointers: Vec<*const c_char> = categories.iter().map(|text| text.as_ptr()).collect();
        unsafe { (self.fmu.c.fmi2SetDebugLogging)(self.raw, on.into(), pointers.len(), pointers.as_ptr()) }
    }
}
