//! The built library, packed FMUs of it, and an instance of either version whose variables have names.
//!
//! Names are those of FMI 2.0. In FMI 3.0 such a variable is an element of an array: the others stay as they are.

use crowd_mechanics::model::CrowdModel;
use crowd_mechanics::pack::{Binary, Package, host_platform};
use crowd_mechanics::quantities::{
    QUANTITIES, Role, SIZES, VariableType, guid, of_materials, scalars, sizes,
};
use crowd_mechanics::setup;
use lemons_core::trial::DriveTable;
pub use lemons_fmi::Status::{self, Discard as DISCARD, Error as ERROR, Ok as OK, Warning as WARNING};
pub use lemons_fmi::testing::Version::{self, V2, V3};
pub use lemons_fmi::testing::instance::{Arguments, VersionFunctions};
pub use lemons_fmi::testing::{LoggedMessage, TestInstance};
use lemons_fmi::variables::Dimension;
use lemons_fmi::{Model as _, instantiation_token, reference};
pub use lemons_testing::{copy_tree, trial_push as paper};
use libloading::Library;
use std::cell::RefCell;
use std::collections::HashMap;
use std::ffi::{CStr, CString};
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use tempfile::TempDir;

pub const BOTH: [Version; 2] = Version::BOTH;

/// \[s\] communication step of the tests.
pub const STEP: f64 = 0.01;

/// Agents of the paper's Trial.
pub const AGENTS: usize = 5;

/// A loaded library.
pub struct Fmu {
    v2: VersionFunctions,
    v3: VersionFunctions,
    _library: Library,
}

/// Where cargo puts the library: beside the test executable, or one directory up.
pub fn library_path() -> PathBuf {
    let executable = std::env::current_exe().expect("the test's own path");
    let mut places = executable.ancestors().skip(1).take(2).map(|d| d.join("libcrowd_mechanics.so"));
    places.find(|path| path.is_file()).expect("`cargo test -p lemons-crowd` builds the library")
}

/// Packs the paper's Trial with the built library and unzips the FMU.
fn unzip_packed(directory: &Path) {
    let fmu = directory.join("crowd.fmu");
    let library = Binary { platform: host_platform().unwrap().into(), path: library_path() };
    let package = Package { trials: vec![paper()], binaries: vec![library], ..Package::default() };
    assert!(package.write(&fmu).unwrap().is_empty(), "no warning");
    zip::ZipArchive::new(std::fs::File::open(fmu).unwrap()).unwrap().extract(directory).unwrap();
}

/// Tells a child process where its parent's packed FMU lies.
pub const PACKED: &str = "FMI_PACKED";

/// An FMU of the paper's Trial, packed and unzipped: one for all tests of this process.
pub fn packed() -> &'static Path {
    static DIRECTORY: OnceLock<PathBuf> = OnceLock::new();
    DIRECTORY.get_or_init(|| {
        if let Some(parents) = std::env::var_os(PACKED) {
            return parents.into();
        }
        // Statics are not dropped: what ended processes have left is removed here.
        let all = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fmi");
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
        // SAFETY: the library that was built.
        let library = unsafe { Library::new(path) }.unwrap_or_else(|error| panic!("{path:?}: {error}"));
        Fmu {
            v2: VersionFunctions::of(&library, V2),
            v3: VersionFunctions::of(&library, V3),
            _library: library,
        }
    }

    /// One for all tests: the binary of a packed FMU.
    pub fn get() -> &'static Fmu {
        static FMU: OnceLock<Fmu> = OnceLock::new();
        let binary = format!("binaries/{}/CrowdMechanics.so", host_platform().unwrap());
        FMU.get_or_init(|| Fmu::load(&packed().join(binary)))
    }

    pub fn functions(&self, version: Version) -> &VersionFunctions {
        if version == V2 { &self.v2 } else { &self.v3 }
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

    /// Makes them with a text in one file of the Trial replaced, where it first stands.
    pub fn edited(file: &str, from: &str, to: &str) -> Resources {
        let resources = Resources::new();
        edit(&resources.trial().join(file), from, to);
        resources
    }

    /// Makes them with another Trial, whose agent 1 stands elsewhere.
    pub fn with_other(name: &str, place: &str) -> Resources {
        let resources = Resources::new();
        resources.add(name, place);
        resources
    }

    pub fn add(&self, name: &str, place: &str) {
        let other = self.directory().join(name);
        copy_tree(&paper(), &other);
        edit(&other.join("dynamic/AgentDynamics.xml"), "0.279,0.030", place);
    }

    /// Makes them with a Trial of the paper's first agents and the same materials.
    pub fn with_fewer(name: &str, agents: usize) -> Resources {
        let resources = Resources::new();
        let other = resources.directory().join(name);
        copy_tree(&paper(), &other);
        for file in ["static/Agents.xml", "dynamic/AgentDynamics.xml"] {
            let path = other.join(file);
            let text = std::fs::read_to_string(&path).unwrap();
            let next = text.match_indices("<Agent ").nth(agents).unwrap().0;
            std::fs::write(&path, text[..next].to_owned() + &text[text.rfind("</Agents>").unwrap()..])
                .unwrap();
        }
        resources
    }
}

pub fn edit(path: &Path, from: &str, to: &str) {
    let text = std::fs::read_to_string(path).unwrap();
    assert!(text.contains(from), "{path:?} has no {from:?}");
    std::fs::write(path, text.replacen(from, to, 1)).unwrap();
}

/// Returns whether a Real is computed, so that nobody sets it.
pub fn computed(name: &str) -> bool {
    name.ends_with("Force") || name.ends_with("Overlap") || name.contains("Compression.")
}

/// Where a variable of FMI 2.0 is: elements of an array of a length.
#[derive(Clone)]
struct Place {
    reference: u32,
    elements: Vec<usize>,
    length: usize,
}

/// The variables of a Trial's FMU.
pub struct Model {
    pub token: String,
    places: HashMap<String, Place>,
    /// Names of FMI 2.0, in the table's order.
    pub reals: Vec<String>,
    /// References and lengths of the Reals and Integers of the version.
    all: [Vec<(u32, usize)>; 2],
    starts: HashMap<u32, Vec<f64>>,
}

impl Model {
    pub fn of(trial: &Path, version: Version) -> Model {
        let (trial, _) = setup::read(trial).expect("a good Trial");
        let rows = scalars(&trial);
        let reals = rows.iter().filter(|row| matches!(row.variable.kind, VariableType::Real(_)));
        let reals: Vec<String> = reals.map(|row| row.name.clone()).collect();
        let (mut places, mut all, mut starts) = (HashMap::new(), [Vec::new(), Vec::new()], HashMap::new());
        let mut add = |kind: VariableType, reference: u32, length: usize| match kind {
            VariableType::Real(_) => all[0].push((reference, length)),
            VariableType::Integer => all[1].push((reference, length)),
            _ => {}
        };
        if version == V2 {
            for (row, reference) in rows.iter().zip(0..) {
                add(row.variable.kind, reference, 1);
                places.insert(row.name.clone(), Place { reference, elements: vec![0], length: 1 });
            }
            let token = guid(&trial).braced().to_string();
            return Model { token, places, reals, all, starts };
        }
        let sizes = sizes(&trial);
        let size = |dimension: &Dimension| match *dimension {
            Dimension::Size(place) => sizes[place],
            Dimension::Fixed(size) => size,
        };
        let mut crowd = CrowdModel::of_trial(trial.clone(), DriveTable::default());
        for array in &QUANTITIES {
            let reference = reference::<CrowdModel>(array.quantity).unwrap();
            let length = array.dimensions.iter().map(size).product::<u64>() as usize;
            add(array.kind, reference, length);
            if ![Role::Calculated, Role::CalculatedParameter].contains(&array.role) {
                let mut values = vec![0.0; length];
                crowd.numbers(array.quantity, &mut values).unwrap();
                starts.insert(reference, values);
            }
            // Some single numbers of FMI 2.0 have the name of an array: they go first.
            let whole = Place { reference, elements: (0..length).collect(), length };
            places.entry(array.name.to_owned()).or_insert(whole);
            for row in rows.iter().filter(|row| row.variable.quantity == array.quantity) {
                let both = of_materials(&trial, &row.name).into_iter().map(|(_, element)| element);
                let mut elements: Vec<usize> = both.collect();
                if elements.is_empty() {
                    elements.push(row.element);
                }
                places.insert(row.name.clone(), Place { reference, elements, length });
            }
        }
        let others = ["time"].into_iter().chain(SIZES.iter().map(|size| size.name));
        for (name, reference) in others.zip(0..) {
            places.insert(name.to_owned(), Place { reference, elements: vec![0], length: 1 });
        }
        let token = instantiation_token::<CrowdModel>().braced().to_string();
        Model { token, places, reals, all, starts }
    }

    /// Returns that of the paper's Trial.
    pub fn paper(version: Version) -> &'static Model {
        static MODELS: OnceLock<[Model; 2]> = OnceLock::new();
        let models = MODELS.get_or_init(|| BOTH.map(|version| Model::of(&paper(), version)));
        &models[usize::from(version == V3)]
    }

    fn place(&self, name: &str) -> &Place {
        self.places.get(name).unwrap_or_else(|| panic!("no variable {name}"))
    }

    pub fn reference(&self, name: &str) -> u32 {
        self.place(name).reference
    }
}

/// An instance of the crowd.
pub struct Crowd {
    instance: TestInstance,
    pub model: &'static Model,
    /// Arrays that were set when nothing could be read.
    set: RefCell<HashMap<u32, Vec<f64>>>,
}

impl Deref for Crowd {
    type Target = TestInstance;

    fn deref(&self) -> &TestInstance {
        &self.instance
    }
}

/// Every Real and Integer, bit for bit.
pub type Bits = (Vec<u64>, Vec<i32>);

/// An instance, or what was told.
pub fn instantiate(
    fmu: &Fmu,
    version: Version,
    token: &str,
    location: &str,
) -> Result<Crowd, Vec<LoggedMessage>> {
    let (token, location) = (CString::new(token).unwrap(), CString::new(location).unwrap());
    Crowd::with(fmu, version, &Arguments::new(&token, &location))
}

impl Crowd {
    pub fn with(fmu: &Fmu, version: Version, arguments: &Arguments<'_>) -> Result<Crowd, Vec<LoggedMessage>> {
        let instance = TestInstance::new(fmu.functions(version), arguments)?;
        Ok(Crowd { instance, model: Model::paper(version), set: RefCell::default() })
    }

    pub fn try_of(fmu: &Fmu, version: Version, resources: &Path) -> Result<Crowd, Vec<LoggedMessage>> {
        instantiate(fmu, version, &Model::paper(version).token, &version.location(resources))
    }

    #[track_caller]
    pub fn of(fmu: &Fmu, version: Version, resources: &Path) -> Crowd {
        Crowd::try_of(fmu, version, resources).unwrap_or_else(|log| panic!("{log:?}"))
    }

    /// Makes one of resources with the paper's variables.
    #[track_caller]
    pub fn on(version: Version, resources: &Resources) -> Crowd {
        Crowd::of(Fmu::get(), version, &resources.directory())
    }

    /// On the paper's Trial.
    pub fn new(version: Version) -> Crowd {
        Crowd::of(Fmu::get(), version, &packed().join("resources"))
    }

    /// Fast enough for tests: 1e-5 s mechanical steps, agent 0 pushed with 700 N.
    pub fn pushed(version: Version) -> Crowd {
        let crowd = Crowd::new(version);
        crowd.push_and_initialize();
        crowd
    }

    #[track_caller]
    pub fn push_and_initialize(&self) {
        self.must(self.set_all(&[("TimeStepMechanical", 1e-5), ("agent[0].Fp.x", 700.0)]));
        self.initialize();
    }

    #[track_caller]
    pub fn enter_initialization(&self) {
        self.must(self.enter(None, 0.0, None));
    }

    pub fn reset(&self) {
        self.set.borrow_mut().clear();
        self.must(self.instance.reset());
    }

    /// An array of FMI 3.0, with some elements changed.
    fn array(&self, place: &Place) -> Vec<f64> {
        let (status, values) = self.get_real(&[place.reference], place.length);
        if status == OK {
            return values;
        }
        self.take_messages();
        let set = self.set.borrow().get(&place.reference).cloned();
        let start = || self.model.starts.get(&place.reference).cloned();
        set.or_else(start).unwrap_or_else(|| vec![0.0; place.length])
    }

    pub fn set_all(&self, values: &[(&str, f64)]) -> Status {
        if self.version() == V2 {
            let references: Vec<u32> = values.iter().map(|(name, _)| self.model.reference(name)).collect();
            return self.set_real(&references, &values.iter().map(|(_, value)| *value).collect::<Vec<f64>>());
        }
        let mut arrays: Vec<(u32, Vec<f64>)> = Vec::new();
        for (name, value) in values {
            let place = self.model.place(name);
            if arrays.iter().all(|(reference, _)| *reference != place.reference) {
                arrays.push((place.reference, self.array(place)));
            }
            let (_, array) = arrays.iter_mut().find(|(reference, _)| *reference == place.reference).unwrap();
            place.elements.iter().for_each(|element| array[*element] = *value);
        }
        let references: Vec<u32> = arrays.iter().map(|(reference, _)| *reference).collect();
        let together: Vec<f64> = arrays.iter().flat_map(|(_, values)| values.clone()).collect();
        let status = self.set_real(&references, &together);
        if status == OK {
            self.set.borrow_mut().extend(arrays);
        }
        status
    }

    pub fn set(&self, name: &str, value: f64) -> Status {
        self.set_all(&[(name, value)])
    }

    pub fn try_get(&self, name: &str) -> (Status, f64) {
        let place = self.model.place(name);
        let (status, values) = self.get_real(&[place.reference], place.length);
        (status, values[place.elements[0]])
    }

    /// Gets the derivative of a variable, or of its element of an array.
    pub fn try_derivative(&self, name: &str, order: i32) -> (Status, f64) {
        let place = self.model.place(name);
        let (status, values) = self.output_derivatives(&[place.reference], &[order], place.length);
        (status, values[place.elements[0]])
    }

    #[track_caller]
    pub fn get(&self, name: &str) -> f64 {
        let (status, value) = self.try_get(name);
        self.must(status);
        value
    }

    /// Returns a quantity of each agent.
    #[track_caller]
    pub fn of_agents(&self, quantity: &str) -> Vec<f64> {
        (0..AGENTS).map(|i| self.get(&format!("agent[{i}].{quantity}"))).collect()
    }

    /// The values of an array of FMI 3.0, or of a number.
    #[track_caller]
    pub fn values(&self, name: &str) -> Vec<f64> {
        let place = self.model.place(name);
        let (status, values) = self.get_real(&[place.reference], place.length);
        self.must(status);
        values
    }

    pub fn set_values(&self, name: &str, values: &[f64]) -> Status {
        self.set_real(&[self.model.reference(name)], values)
    }

    pub fn try_integer(&self, name: &str, value: i32) -> Status {
        self.set_integer(&[self.model.reference(name)], &[value])
    }

    #[track_caller]
    pub fn integer(&self, name: &str) -> i32 {
        let place = self.model.place(name);
        let (status, values) = self.get_integer(&[place.reference], place.length);
        self.must(status);
        values[place.elements[0]]
    }

    #[track_caller]
    pub fn set_flag(&self, name: &str, value: bool) {
        let place = self.model.place(name);
        let (status, mut values) = self.get_boolean(&[place.reference], place.length);
        if status != OK {
            self.take_messages();
            values = vec![1; place.length];
        }
        place.elements.iter().for_each(|element| values[*element] = value.into());
        self.must(self.set_boolean(&[place.reference], &values));
    }

    pub fn try_texts(&self, values: &[(&str, &str)]) -> Status {
        let references: Vec<u32> = values.iter().map(|(name, _)| self.model.reference(name)).collect();
        let texts: Vec<CString> = values.iter().map(|(_, text)| CString::new(*text).unwrap()).collect();
        let texts: Vec<Option<&CStr>> = texts.iter().map(|text| Some(&**text)).collect();
        self.set_string(&references, &texts)
    }

    pub fn set_text(&self, name: &str, value: &str) -> Status {
        self.try_texts(&[(name, value)])
    }

    #[track_caller]
    pub fn text(&self, name: &str) -> String {
        let (status, values) = self.get_string(&[self.model.reference(name)], 1);
        self.must(status);
        values[0].to_str().unwrap().to_owned()
    }

    pub fn try_step(&self, from: f64, step: f64) -> Status {
        self.do_step(from, step).status
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
        let [reals, integers] = self.model.all.each_ref().map(|all| {
            let references: Vec<u32> = all.iter().map(|(reference, _)| *reference).collect();
            (references, all.iter().map(|(_, length)| length).sum())
        });
        let (status, real) = self.get_real(&reals.0, reals.1);
        self.must(status);
        let (status, integer) = self.get_integer(&integers.0, integers.1);
        self.must(status);
        (real.into_iter().map(f64::to_bits).collect(), integer)
    }
}
