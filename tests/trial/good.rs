//! A small Trial without errors, and changes of it.

use crowd_mechanics::setup::{self};
use lemons_core::trial::*;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

pub const FILES: [&str; 5] = [
    "Parameters.xml",
    "static/Materials.xml",
    "static/Geometry.xml",
    "static/Agents.xml",
    "dynamic/AgentDynamics.xml",
];
pub const INTERACTIONS: &str = "dynamic/AgentInteractions.xml";

/// Two agents of one disk in a room; each file short enough to know its lines.
pub fn good() -> Vec<(&'static str, String)> {
    let texts = [
        r#"<Parameters>
    <Directories Static="./static/" Dynamic="dynamic"/>
    <Times TimeStep="0.05" TimeStepMechanical="1e-5"/>
</Parameters>"#,
        r#"<Materials>
    <Intrinsic>
        <Material Id="concrete" YoungModulus="1.7e9" ShearModulus="7.1e8"/>
        <Material Id="skin" YoungModulus="4e6" ShearModulus="1379310.3"/>
    </Intrinsic>
    <Binary>
        <Contact Id1="concrete" Id2="skin" GammaNormal="1230" GammaTangential="1231" KineticFriction="0.5"/>
        <Contact Id1="skin" Id2="skin" GammaNormal="700" GammaTangential="701" KineticFriction="0.4"/>
    </Binary>
</Materials>"#,
        r#"<Geometry>
    <Dimensions Lx="4" Ly="2"/>
    <Wall Id="room" MaterialId="concrete">
        <Corner Coordinates="0,0"/>
        <Corner Coordinates="4,0"/>
        <Corner Coordinates="4,2"/>
        <Corner Coordinates="0,0"/>
    </Wall>
    <Wall Id="bar" MaterialId="concrete">
        <Corner Coordinates="1,1"/>
        <Corner Coordinates="2,1.5"/>
    </Wall>
</Geometry>"#,
        r#"<Agents>
    <Agent Type="pedestrian" Id="Ann" Mass="89" Height="1.8" MomentOfInertia="1.85" FloorDamping="4.5" AngularDamping="4.25">
        <Shape Type="disk" Radius="0.21" MaterialId="skin" Position="0,0.1"/>
        <Shape Type="disk" Radius="0.22" MaterialId="skin" Position="0,-0.1"/>
    </Agent>
    <Agent Id="Bob" Mass="63" MomentOfInertia="1.02" FloorDamping="0" AngularDamping="0">
        <Shape Type="disk" Radius="0.25" MaterialId="skin" Position="0,0"/>
    </Agent>
</Agents>"#,
        r#"<Agents>
    <Agent Id="Bob">
        <Kinematics Position="2.5,0.5" Velocity="0,1" Theta="0.5" Omega="-0.25"/>
    </Agent>
    <Agent Id="Ann">
        <Kinematics Position="3.1,0.6" Velocity="-1,0" Theta="3" Omega="0.75"/>
        <Dynamics Fp="-160,1" Mp="0.125"/>
    </Agent>
</Agents>"#,
        r#"<Interactions>
    <Agent Id="Bob">
        <Agent Id="Ann">
            <Interaction ParentShape="0" ChildShape="1" TangentialRelativeDisplacement="1,2" Fn="3,4" Ft="5,6"/>
        </Agent>
        <Wall ShapeId="0" WallId="room" CornerId="2" TangentialRelativeDisplacement="7,8" Fn="9,10" Ft="11,12"/>
    </Agent>
</Interactions>"#,
    ];
    FILES.into_iter().chain([INTERACTIONS]).zip(texts.map(str::to_owned)).collect()
}

pub fn put(directory: &Path, files: &[(&str, String)]) {
    for (file, text) in files {
        let path = directory.join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
}

/// What reading the good Trial says after the first occurrence of `old` in `file` became `new`.
pub fn edited(edits: &[(&str, &str, &str)]) -> Result<(Trial, Problems), Problems> {
    let mut files = good();
    for &(file, old, new) in edits {
        let (_, text) = files.iter_mut().find(|(name, _)| *name == file).unwrap();
        assert!(text.contains(old), "{file} has no {old}");
        *text = text.replacen(old, new, 1);
    }
    let directory = TempDir::new().unwrap();
    put(directory.path(), &files);
    setup::read(directory.path())
}

/// The same Trial but for where it lies.
pub fn moved(trial: &Trial, to: &Trial) -> Trial {
    Trial { name: to.name.clone(), directory: to.directory.clone(), ..trial.clone() }
}
