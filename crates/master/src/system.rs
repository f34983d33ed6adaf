//! Several FMUs that step together: co-simulation with a fixed communication step.
//!
//! Here are the newest values of the connected outputs, of each pair of components, read by one call for each type. In FMI
//! 3.0 an array is read and set whole, and each of its elements has a connection of its own here. Then
//!
//! - Jacobi: all inputs are set, all components step, all outputs are read;
//! - Gauss-Seidel: the components step one after the other, in the order of the file. For each, the inputs are set, it
//!   steps, and its outputs are read. The components after it use these outputs in the same communication step.
//!
//! Initial values: while all components are in initialization mode, outputs are read and inputs are set as many times as
//! there are components, or until nothing changes. The longest chain without a loop then has its values.

use crate::calls::{FmiValue, FmuInstance};
use crate::error::{ErrorPlace, Result, require};
use crate::fmu::Fmu;
use crate::instance::ValueSelection;
use crate::notes;
use crate::saved::ComponentRecord;
use crate::ssp::{Affine, FmiType, Single};
use lemons_core::trial::Trial;
use lemons_fmi::fingerprint;
use lemons_sim::{Algorithm, Exchange};
use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::sync::Arc;

/// The parameter of a crowd that says whether it plays the drive that is packed in it.
pub(crate) const PLAY_DRIVE: &str = "PlayDrive";

/// An instance in a system.
pub struct SystemComponent {
    /// Name, unique in the system.
    pub name: String,
    /// Dropped before the files of its FMU.
    pub instance: FmuInstance,
    /// The FMU of this instance, perhaps of others, too.
    pub fmu: Arc<Fmu>,
}

impl SystemComponent {
    /// Reads the Trial that it runs; `None` if its FMU contains none. The instance must be initialized.
    ///
    /// # Errors
    /// The FMU does not say which one, or it cannot be read.
    pub fn trial(&self) -> Result<Option<Trial>> {
        if self.fmu.resources().is_err() || self.fmu.kind("Trial").is_none() {
            return Ok(None);
        }
        self.fmu.trial(Some(&self.instance.value::<String>("Trial")?)).map(Some)
    }
}

/// Components and the connections between them.
pub struct System {
    /// In the order of the file.
    pub components: Vec<SystemComponent>,
    /// In which order components exchange values and step.
    pub algorithm: Algorithm,
    channels: Vec<Channel>,
    /// The inputs with a connection: component, and name of the value.
    fed: HashSet<(usize, String)>,
    /// Number of the connections of the SSP.
    pub connections: usize,
    /// The connections: the same if the same outputs feed the same inputs with the same conversions.
    pub fingerprint: String,
    /// \[s\] The last communication point.
    pub time: f64,
}

impl System {
    /// Makes a system of a single FMU, whose results do not depend on the algorithm.
    ///
    /// # Errors
    /// The FMU cannot be instantiated.
    pub fn of_one(name: &str, fmu: Arc<Fmu>, algorithm: Algorithm) -> Result<System> {
        let instance = fmu.instantiate(name)?;
        let component = SystemComponent { name: name.to_owned(), fmu, instance };
        Ok(System::new(vec![component], algorithm, &[], 0))
    }

    /// Connects components by connections of single values, which are so many connections of an SSP.
    pub(crate) fn new(
        components: Vec<SystemComponent>,
        algorithm: Algorithm,
        wires: &[Wire],
        connections: usize,
    ) -> System {
        let fed = wires.iter().map(|Wire { to: (place, to), .. }| {
            (*place, components[*place].fmu.description.name_of(to.variable, to.element))
        });
        let fed = fed.collect();
        let (channels, fingerprint) = (Channel::of(wires), fingerprint_of(wires));
        System { components, algorithm, channels, fed, connections, fingerprint, time: 0.0 }
    }

    /// Finds parameters of the same people that differ between connected components, one warning for each name.
    ///
    /// # Errors
    /// A component refuses to tell them.
    pub(crate) fn differing(&self) -> Result<Vec<String>> {
        let mut warnings = Vec::new();
        // Each pair once, whichever feeds the other.
        let mut seen = BTreeSet::new();
        for channel in self.channels.iter().filter(|channel| channel.alike) {
            if !seen.insert((channel.from.min(channel.to), channel.from.max(channel.to))) {
                continue;
            }
            let [a, b] = [channel.from, channel.to].map(|place| &self.components[place]);
            let same = |(name, single): &(String, Single)| {
                let other = b.fmu.description.single(name);
                let real = single.variable.of.class() == FmiType::Real && name.starts_with("agent[");
                let alike = |other: Single| {
                    let [a, b] = [single.variable, other.variable].map(|of| (of.of.class(), &of.unit));
                    other.is_parameter() && a == b
                };
                real && single.is_parameter() && other.is_some_and(alike)
            };
            let names: Vec<String> = a.fmu.description.singles().filter(same).map(|(name, _)| name).collect();
            let values = |component: &SystemComponent| -> Result<Vec<f64>> {
                component.instance.values(&component.instance.select(&names)?)
            };
            let mut differing: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
            let (here, there) = (values(a)?, values(b)?);
            for k in (0..names.len()).filter(|k| here[*k] != there[*k]) {
                let quantity = names[k].split_once("].").map_or("", |(_, quantity)| quantity);
                differing.entry(quantity).or_insert((k, 0)).1 += 1;
            }
            warnings.extend(differing.into_values().map(|(k, people)| {
                notes::differs(&names[k], [(&a.name, here[k]), (&b.name, there[k])], people)
            }));
        }
        Ok(warnings)
    }

    /// Returns whether a connection feeds a variable of the component at this place.
    pub fn feeds(&self, place: usize, variable: &str) -> bool {
        let description = &self.components[place].fmu.description;
        let single = description.single(variable);
        single.is_some_and(|single| {
            self.fed.contains(&(place, description.name_of(single.variable, single.element)))
        })
    }

    /// Keeps crowds from playing the drives that are packed in them; before initialization. Crowds of earlier versions play
    /// none.
    ///
    /// # Errors
    /// A component refuses the parameter.
    pub fn stop_drives(&self) -> Result<()> {
        let plays = |component: &&SystemComponent| component.fmu.kind(PLAY_DRIVE).is_some();
        self.components
            .iter()
            .filter(plays)
            .try_for_each(|crowd| crowd.instance.set_text(&[PLAY_DRIVE], "false"))
    }

    /// Lets a tolerance alone choose mechanical steps: it only shortens the one that an FMU has. To be called before
    /// initialization.
    ///
    /// # Errors
    /// An FMU refuses it.
    pub(crate) fn free_mechanical_steps(&self) -> Result<()> {
        const STEP: &str = "TimeStepMechanical";
        let has = |component: &&SystemComponent| component.fmu.kind(STEP).is_some();
        self.components.iter().filter(has).try_for_each(|component| component.instance.set_text(&[STEP], "1"))
    }

    /// Initializes all components at a time \[s\]; see the module for the first values. They get this tolerance, or that
    /// of their own DefaultExperiment, or none.
    ///
    /// # Errors
    /// A component refuses it.
    pub fn initialize(&mut self, start: f64, tolerance: Option<f64>) -> Result<()> {
        self.time = start;
        self.each(|system, c| system.components[c].instance.enter_initialization(start, tolerance))?;
        for _ in 0..self.components.len() {
            let mut news = false;
            self.each(|system, c| {
                news |= system.read(c)?;
                Ok(())
            })?;
            if !news {
                break;
            }
            self.each(System::send)?;
        }
        self.each(|system, c| system.components[c].instance.exit_initialization())?;
        self.each(|system, c| system.read(c).map(drop))
    }

    /// Makes one communication step, to a time \[s\].
    ///
    /// # Errors
    /// A component refuses the step or fails.
    pub fn step_to(&mut self, end: f64) -> Result<()> {
        let (start, step) = (self.time, end - self.time);
        let all: Vec<usize> = (0..self.components.len()).collect();
        self.algorithm.step(&all, |c, exchange| {
            let done = match exchange {
                Exchange::SetInputs => self.send(c),
                Exchange::Step => self.components[c].instance.step(start, step),
                Exchange::GetOutputs => self.read(c).map(drop),
            };
            self.of_component(c, done)
        })?;
        self.time = end;
        Ok(())
    }

    /// Returns the state of each component at the current communication point, as bytes.
    ///
    /// # Errors
    /// A component refuses it.
    pub fn states(&mut self) -> Result<Vec<Vec<u8>>> {
        let mut states = Vec::with_capacity(self.components.len());
        self.each(|system, c| {
            states.push(system.components[c].instance.state()?);
            Ok(())
        })?;
        Ok(states)
    }

    /// Restores the states that the components had at a communication point \[s\]. The components must be initialized. The
    /// values of the connections are then those of the outputs.
    ///
    /// # Errors
    /// The states belong to other components, or a component refuses its state.
    pub fn restore(&mut self, time: f64, states: &[Vec<u8>]) -> Result<()> {
        let (given, components) = (states.len(), self.components.len());
        require(given == components, || format!("{given} states for {components} components"))?;
        self.each(|system, c| system.components[c].instance.restore(&states[c]))?;
        self.time = time;
        self.each(|system, c| system.read(c).map(drop))
    }

    /// Returns what a saved run says of the components.
    pub fn records(&self) -> Vec<ComponentRecord> {
        let record = |component: &SystemComponent| ComponentRecord {
            chosen: component.fmu.choices(),
            ..ComponentRecord::new(
                &component.name,
                &component.fmu.description.model_name,
                &component.fmu.description.guid,
            )
        };
        self.components.iter().map(record).collect()
    }

    /// Terminates all components.
    ///
    /// # Errors
    /// A component refuses it.
    pub fn terminate(&mut self) -> Result<()> {
        self.each(|system, c| system.components[c].instance.terminate())
    }

    /// Returns the warnings of the components since the last call.
    pub fn warnings(&self) -> Vec<String> {
        let mut all = Vec::new();
        for SystemComponent { name, instance, .. } in &self.components {
            let who = if self.components.len() == 1 { String::new() } else { format!("{name}: ") };
            let warnings = instance.warnings().into_iter();
            all.extend(
                warnings
                    .map(|text| format!("warning: {who}{}", text.strip_prefix("warning: ").unwrap_or(&text))),
            );
        }
        all
    }

    /// Does something with each component in turn; an error says which one it was, if there are several.
    fn each(&mut self, mut what: impl FnMut(&mut System, usize) -> Result<()>) -> Result<()> {
        (0..self.components.len()).try_for_each(|c| {
            let done = what(self, c);
            self.of_component(c, done)
        })
    }

    /// Adds to an error which component it was, if there are several.
    fn of_component(&self, c: usize, done: Result<()>) -> Result<()> {
        if self.components.len() == 1 {
            return done;
        }
        done.place(|| format!("component {:?}", self.components[c].name))
    }

    /// Reads the connected outputs of a component; returns whether one is new.
    fn read(&mut self, c: usize) -> Result<bool> {
        let mut news = false;
        for channel in self.channels.iter_mut().filter(|channel| channel.from == c) {
            news |= channel.read(&self.components[c].instance)?;
        }
        Ok(news)
    }

    /// Sets the connected inputs of a component.
    fn send(&mut self, c: usize) -> Result<()> {
        let mut channels = self.channels.iter().filter(|channel| channel.to == c);
        channels.try_for_each(|channel| channel.send(&self.components[c].instance))
    }
}

/// A connection of single values, each with the place of its component.
#[derive(Clone, Copy)]
pub(crate) struct Wire<'a> {
    pub(crate) from: (usize, Single<'a>),
    pub(crate) to: (usize, Single<'a>),
    /// Conversion of Reals.
    pub(crate) map: Affine,
}

/// The connections from one component to another, or to itself.
struct Channel {
    from: usize,
    to: usize,
    /// True if an input has the name of the output that feeds it.
    alike: bool,
    numbers: Values<f64>,
    texts: Values<String>,
}

/// Connected values of one kind.
struct Values<T> {
    outputs: ValueSelection,
    inputs: ValueSelection,
    maps: Vec<Affine>,
    /// Of the outputs.
    newest: Vec<T>,
}

impl Channel {
    /// Makes the channels of all connections.
    fn of(wires: &[Wire]) -> Vec<Channel> {
        let mut all: BTreeMap<(usize, usize), Vec<Wire>> = BTreeMap::new();
        for wire in wires {
            all.entry((wire.from.0, wire.to.0)).or_default().push(*wire);
        }
        let channel = |((from, to), wires): ((usize, usize), Vec<Wire>)| {
            let is_text = |wire: &Wire| wire.from.1.variable.of == FmiType::String;
            let alike = wires.iter().any(|wire| wire.from.1.variable.name == wire.to.1.variable.name);
            let (texts, numbers): (Vec<Wire>, Vec<Wire>) = wires.into_iter().partition(is_text);
            Channel { from, to, alike, numbers: Values::new(&numbers), texts: Values::new(&texts) }
        };
        all.into_iter().map(channel).collect()
    }

    /// Reads the outputs; returns whether one is new.
    fn read(&mut self, from: &FmuInstance) -> Result<bool> {
        Ok(self.numbers.read(from)? | self.texts.read(from)?)
    }

    /// Sets the inputs.
    fn send(&self, to: &FmuInstance) -> Result<()> {
        self.numbers.send(to)?;
        self.texts.send(to)
    }
}

impl<T: FmiValue> Values<T> {
    fn new(wires: &[Wire]) -> Values<T> {
        Values {
            outputs: ValueSelection::new(wires.iter().map(|wire| wire.from.1)),
            inputs: ValueSelection::new(wires.iter().map(|wire| wire.to.1)),
            maps: wires.iter().map(|wire| wire.map).collect(),
            newest: Vec::new(),
        }
    }

    fn read(&mut self, from: &FmuInstance) -> Result<bool> {
        let before = std::mem::replace(&mut self.newest, from.values(&self.outputs)?);
        Ok(before != self.newest)
    }

    fn send(&self, to: &FmuInstance) -> Result<()> {
        let sent = self.newest.iter().zip(&self.maps).map(|(value, map)| value.converted(*map));
        to.set(&self.inputs, &sent.collect::<Vec<T>>())
    }
}

fn fingerprint_of(wires: &[Wire]) -> String {
    let line = |Wire { from, to, map }: &Wire| format!("{}.{} -> {}.{} {map:?}", from.0, from.1, to.0, to.1);
    let of_type = |of: FmiType| {
        let wires = wires.iter().filter(|wire| wire.from.1.variable.of.class() == of);
        let mut lines: Vec<String> = wires.map(line).collect();
        lines.sort_unstable();
        lines.join(" ")
    };
    let all = [FmiType::Real, FmiType::Integer, FmiType::Boolean, FmiType::String].map(of_type).join("\n");
    format!("{:032x}", fingerprint(all.as_bytes()))
}

/// Returns the component that a name `component.variable` leads to, and the variable's name: of several the longest.
pub(crate) fn component_of<'a>(components: &[SystemComponent], name: &'a str) -> Option<(usize, &'a str)> {
    let candidates = components.iter().enumerate().filter_map(|(place, component)| {
        let variable = name.strip_prefix(component.name.as_str())?.strip_prefix('.')?;
        Some((place, variable))
    });
    candidates.min_by_key(|(_, variable)| variable.len())
}
