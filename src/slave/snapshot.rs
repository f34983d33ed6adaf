//! FMI's "FMU state": saved, restored, as bytes.

use super::{Function, Phase, Settings, Slave, SlaveError, edited};
use crate::engine::{State, World, Wrench};
use crate::variables::{guid, table};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// All that an instance is, apart from where its resources lie: FMI's "FMU state".
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    trial: String,
    fingerprint: u128,
    settings: Settings,
    threads: i32,
    output_directory: String,
    phase: Phase,
    time: f64,
    start_time: f64,
    stop_time: Option<f64>,
    running: Option<Running>,
}

/// What a running world's future depends on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Running {
    drive: Vec<Wrench>,
    state: State,
}

impl Slave {
    /// `fmi2GetFMUstate`
    ///
    /// # Errors
    /// Wrong phase.
    pub fn snapshot(&self) -> Result<Snapshot, SlaveError> {
        self.check(Function::State)?;
        Ok(Snapshot {
            trial: self.packed.name.clone(),
            fingerprint: self.fingerprint,
            settings: self.settings.clone(),
            threads: self.threads,
            output_directory: self.output_directory.clone(),
            phase: self.phase,
            time: self.time,
            start_time: self.start_time,
            stop_time: self.stop_time,
            running: self
                .world
                .as_ref()
                .map(|world| Running { drive: world.drive.clone(), state: world.state().clone() }),
        })
    }

    /// `fmi2SetFMUstate`
    ///
    /// # Errors
    /// Wrong phase, a snapshot of another model; then nothing has changed.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SlaveError> {
        self.check(Function::State)?;
        let (packed, fingerprint) = if snapshot.trial == self.packed.name {
            (self.packed.clone(), self.fingerprint)
        } else {
            let packed = self.resources.load(&snapshot.trial)?.0;
            let fingerprint = packed.fingerprint().as_u128();
            (Arc::new(packed), fingerprint)
        };
        if fingerprint != snapshot.fingerprint || guid(&table(&packed)) != self.guid {
            let message = format!("Trial {:?} is not what it was when the state was saved", snapshot.trial);
            return Err(SlaveError::OtherModel(message));
        }
        let known = |reference: &u32| (*reference as usize) < self.table.len();
        if !snapshot.settings.keys().all(known) {
            return Err(SlaveError::Snapshot("a setting of an unknown variable"));
        }
        let trial = edited(&packed, &snapshot.settings, &self.table);
        let world = match &snapshot.running {
            None => None,
            Some(running) => {
                let mut world = trial.world()?;
                check_running(&world, running)?;
                world.restore(running.state.clone());
                world.drive.clone_from(&running.drive);
                Some(world)
            }
        };
        (self.packed, self.fingerprint, self.trial, self.world) = (packed, fingerprint, trial, world);
        self.settings.clone_from(&snapshot.settings);
        self.threads = snapshot.threads;
        self.output_directory.clone_from(&snapshot.output_directory);
        self.phase = snapshot.phase;
        (self.time, self.start_time, self.stop_time) =
            (snapshot.time, snapshot.start_time, snapshot.stop_time);
        Ok(())
    }

    /// `fmi2SerializeFMUstate`: a snapshot as bytes of a format of its own.
    ///
    /// # Errors
    /// A snapshot that cannot be written.
    pub fn serialize(&self, snapshot: &Snapshot) -> Result<Vec<u8>, SlaveError> {
        let payload =
            postcard::to_stdvec(snapshot).map_err(|_| SlaveError::Snapshot("it cannot be written"))?;
        let mut bytes = Vec::with_capacity(HEADER + payload.len() + 4);
        bytes.extend_from_slice(MAGIC);
        bytes.extend_from_slice(&VERSION.to_le_bytes());
        bytes.extend_from_slice(self.guid.as_bytes());
        bytes.extend_from_slice(&(payload.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&payload);
        let checksum = crc32fast::hash(&bytes);
        bytes.extend_from_slice(&checksum.to_le_bytes());
        Ok(bytes)
    }

    /// `fmi2DeSerializeFMUstate`
    ///
    /// # Errors
    /// Bytes that are damaged, of another version or of another model.
    pub fn deserialize(&self, bytes: &[u8]) -> Result<Snapshot, SlaveError> {
        self.check(Function::State)?;
        let take = |from: usize, length: usize| {
            bytes.get(from..from + length).ok_or(SlaveError::Snapshot("it is cut off"))
        };
        if take(0, 8)? != MAGIC {
            return Err(SlaveError::Snapshot("it does not begin like one"));
        }
        if take(8, 4)? != VERSION.to_le_bytes() {
            return Err(SlaveError::Snapshot("another version of the format"));
        }
        if take(12, 16)? != self.guid.as_bytes() {
            return Err(SlaveError::OtherModel("it was saved by an FMU with another GUID".into()));
        }
        let length = take(28, 8)?.try_into().map(u64::from_le_bytes).unwrap_or(u64::MAX);
        // Importers may hand over a buffer longer than what was written.
        let end = usize::try_from(length).ok().and_then(|length| HEADER.checked_add(length));
        let end = end.filter(|end| *end < bytes.len()).ok_or(SlaveError::Snapshot("it is cut off"))?;
        if take(end, 4)? != crc32fast::hash(&bytes[..end]).to_le_bytes() {
            return Err(SlaveError::Snapshot("its checksum is wrong"));
        }
        postcard::from_bytes(&bytes[HEADER..end])
            .map_err(|_| SlaveError::Snapshot("its content is malformed"))
    }
}

const MAGIC: &[u8; 8] = b"LEMONSst";
/// Raised whenever [`Snapshot`] changes.
const VERSION: u32 = 1;
/// Magic, version, GUID, length.
const HEADER: usize = 8 + 4 + 16 + 8;

/// A snapshot from outside must fit the scene before the engine indexes with it.
fn check_running(world: &World, running: &Running) -> Result<(), SlaveError> {
    let (scene, state) = (world.scene(), &running.state);
    let bodies = scene.bodies.len();
    let (disks, faces) = (scene.disks.len(), scene.faces.len());
    let fits = state.poses.len() == bodies
        && state.twists.len() == bodies
        && running.drive.len() == bodies
        && state.disk_springs.iter().all(|s| s.first.index() < disks && s.second.index() < disks)
        && state.face_springs.iter().all(|s| s.disk.index() < disks && s.face.index() < faces);
    if fits { Ok(()) } else { Err(SlaveError::Snapshot("it does not fit the scene")) }
}
