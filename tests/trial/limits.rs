//! How much a Trial may hold, and what is refused before it is read.

use crate::good::{FILES, edited, good, put};
use crowd_mechanics::engine::vec2;
use crowd_mechanics::setup::{self, Setup, WorldError};
use lemons_core::trial::*;
use std::fs;
use tempfile::TempDir;

/// `count` agents of five disks, all at the origin, as where their positions were forgotten.
fn all_at_one_point(count: usize) -> Result<(Trial, Problems), Problems> {
    let directory = TempDir::new().unwrap();
    lemons_verify::bench::fmu::write_trial(count, vec2(0.5, 0.5), directory.path()).unwrap();
    let file = directory.path().join(FILES[4]);
    let positions = fs::read_to_string(&file).unwrap();
    let forgotten: String = positions
        .split_inclusive("Position=\"")
        .enumerate()
        .map(
            |(k, part)| {
                if k == 0 { part.to_owned() } else { format!("0,0{}", &part[part.find('"').unwrap()..]) }
            },
        )
        .collect();
    fs::write(file, forgotten).unwrap();
    setup::read(directory.path())
}

/// Twelve pairs of disks for each two agents: three thousand would take 25 GB.
#[test]
fn everybody_at_one_point_is_refused_by_name_before_memory_is_taken() {
    for count in [1000, 3000] {
        let problems = all_at_one_point(count).unwrap_err().to_string();
        assert_eq!(problems.lines().count(), 1, "{problems}");
        let words = [
            "AgentDynamics.xml: agent \"0\": ",
            &format!("{} others and ", count - 1),
            "more than 2000000 pairs",
            "are positions missing?",
        ];
        assert!(words.iter().all(|word| problems.contains(word)), "{problems}");
    }
    // Few enough are held, and counted in one line.
    let (trial, warnings) = all_at_one_point(200).unwrap();
    assert!(Setup::of(&trial).world().is_ok());
    assert!(warnings.to_string().contains("pairs of disks of different agents overlap"), "{warnings}");
    assert!(warnings.iter().count() <= 4, "{warnings}");
}

/// The same by parameters, after the Trial was read.
#[test]
fn everybody_moved_to_one_point_makes_no_world() {
    let directory = TempDir::new().unwrap();
    lemons_verify::bench::fmu::write_trial(1000, vec2(0.5, 0.5), directory.path()).unwrap();
    let (mut trial, _) = setup::read(directory.path()).unwrap();
    for dynamics in &mut trial.dynamics {
        dynamics.position = vec2(1.0, 1.0);
    }
    let error = Setup::of(&trial).world().unwrap_err();
    assert!(
        matches!(&error, WorldError::Crowded { agent, crowded } if agent == "0" && crowded.others == 999),
        "{error}"
    );
}

/// A body of one disk for each material, and all their contacts but the last `missing`.
fn of_materials(count: usize, missing: usize) -> Result<(Trial, Problems), Problems> {
    let directory = TempDir::new().unwrap();
    let mut files = good();
    let each = |text: &dyn Fn(usize) -> String| (0..count).map(text).collect::<String>();
    let pairs = (0..count).flat_map(|a| (a..count).map(move |b| (a, b)));
    let contacts: Vec<String> = pairs
        .map(|(a, b)| {
            format!(
                r#"<Contact Id1="m{a}" Id2="m{b}" GammaNormal="1" GammaTangential="1" KineticFriction="1"/>"#
            )
        })
        .collect();
    files[1].1 = format!(
        "<Materials><Intrinsic>{}</Intrinsic><Binary>{}</Binary></Materials>",
        each(&|k| format!(r#"<Material Id="m{k}" YoungModulus="4e6" ShearModulus="1379310.3"/>"#)),
        contacts[..contacts.len() - missing].concat()
    );
    files[2].1 = "<Geometry><Dimensions Lx=\"1\" Ly=\"1\"/></Geometry>".into();
    files[3].1 = format!(
        "<Agents>{}</Agents>",
        each(&|k| format!(
            r#"<Agent Id="{k}" Mass="63" MomentOfInertia="1" FloorDamping="0" AngularDamping="0">
            <Shape Type="disk" Radius="0.2" MaterialId="m{k}" Position="0,0"/></Agent>"#
        ))
    );
    files[4].1 = format!(
        "<Agents>{}</Agents>",
        each(&|k| format!(
            r#"<Agent Id="{k}"><Kinematics Position="{k},0" Velocity="0,0" Theta="0" Omega="0"/></Agent>"#
        ))
    );
    files.truncate(5);
    put(directory.path(), &files);
    setup::read(directory.path())
}

#[test]
fn more_materials_than_can_be_used_are_refused() {
    let problems = of_materials(3, 2).unwrap_err().to_string();
    assert!(problems.contains("no <Contact> of \"m1\" and \"m2\""), "{problems}");
    let contacts = 1001 * 1002 / 2;
    let problems = of_materials(1001, contacts).unwrap_err().to_string();
    let message = "Materials.xml: agents and walls are of 1001 materials: at most 1000 can be used";
    assert!(problems.lines().count() == 1 && problems.ends_with(message), "{problems}");
}

/// The table of laws has a row and a column for each material that something is made of, not for each listed.
#[test]
fn many_idle_materials_cost_nothing() {
    let idle: String = (0..50_000)
        .map(|k| format!("<Material Id=\"m{k}\" YoungModulus=\"4e6\" ShearModulus=\"1.4e6\"/>"))
        .collect();
    let (trial, _) = edited(&[(FILES[1], "</Intrinsic>", &format!("{idle}</Intrinsic>"))]).unwrap();
    assert_eq!(trial.materials.intrinsic.len(), 50_002);
    assert!(Setup::of(&trial).world().is_ok());
}

/// 40 000 took 2 s, 300 000 over a minute.
#[test]
fn elements_with_many_attributes_are_refused_before_they_are_parsed() {
    for prefix in ["", "xmlns:"] {
        let many: String = (0..300_000).map(|k| format!(" {prefix}a{k}='{k}'")).collect();
        for (file, _) in good() {
            let directory = TempDir::new().unwrap();
            put(directory.path(), &good());
            fs::write(directory.path().join(file), format!("<!-- <a> -->\n<A{many}/>")).unwrap();
            let said = setup::read(directory.path()).unwrap_err().to_string();
            assert!(said.contains(":2: <A>: has 300000 attributes; at most 256 are allowed"), "{said}");
        }
    }
}

#[test]
fn hostile_files_are_errors() {
    let deep = format!("{}{}", "<a>".repeat(1_000_000), "</a>".repeat(1_000_000));
    let deep_unclosed = "<Agents>".repeat(1_000_000);
    let bomb = "<!DOCTYPE a [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;&a;&a;'>]><Agents>&b;</Agents>";
    let hostile: Vec<Vec<u8>> = vec![
        deep.into_bytes(),
        deep_unclosed.into_bytes(),
        bomb.into(),
        (0..=255).cycle().take(10_000).collect(),
        Vec::new(),
        b"\xef\xbb\xbf".to_vec(),
        b"<Agents Name=\"\xff\xfe\"/>".to_vec(),
        b"\0\0\0\0".to_vec(),
        b"<Agents>&lol;</Agents>".to_vec(),
        b"<x:Agents/>".to_vec(),
    ];
    for (file, _) in good() {
        let directory = TempDir::new().unwrap();
        put(directory.path(), &good());
        for content in &hostile {
            fs::write(directory.path().join(file), content).unwrap();
            let problems = setup::read(directory.path()).unwrap_err();
            let named = problems.errors().any(|problem| problem.file == directory.path().join(file));
            assert!(named && problems.to_string().len() < 4000, "{problems}");
        }
    }
    for (file, text) in good() {
        for end in (0..text.len()).step_by(7) {
            assert!(edited(&[(file, &text, &text[..end])]).is_err(), "{file} cut at {end}");
        }
    }
}
