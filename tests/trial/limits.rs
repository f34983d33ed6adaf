//! How much a Trial may hold, and what is refused before it is read.

use crate::good::{FILES, edited, good, put};
use crowd_mechanics::engine::vec2;
use crowd_mechanics::scenes::crowded;
use crowd_mechanics::setup::{self, Setup, WorldError};
use lemons_core::trial::*;
use lemons_testing::trial_push;
use std::fs;
use tempfile::TempDir;

/// `count` agents of five disks, all at the origin, as where their positions were forgotten: as they are, and read.
fn all_at_one_point(count: usize) -> (Trial, Result<(Trial, Problems), Problems>) {
    let directory = TempDir::new().unwrap();
    let mut trial = crowded(setup::read(&trial_push()).unwrap().0, count, vec2(0.5, 0.5));
    trial.dynamics.iter_mut().for_each(|dynamics| dynamics.position = vec2(0.0, 0.0));
    trial.write(directory.path()).unwrap();
    (trial, setup::read(directory.path()))
}

/// Twelve pairs of disks for each two agents: three thousand would take 25 GB.
#[test]
fn everybody_at_one_point_is_refused_by_name_before_memory_is_taken() {
    for count in [1000, 3000] {
        let (trial, read) = all_at_one_point(count);
        let problems = read.unwrap_err().to_string();
        assert_eq!(problems.lines().count(), 1, "{problems}");
        let words = [
            "AgentDynamics.xml: agent \"0\": ",
            &format!("{} others and ", count - 1),
            "more than 2000000 pairs",
            "are positions missing?",
        ];
        assert!(words.iter().all(|word| problems.contains(word)), "{problems}");
        // The same by parameters, after a Trial was read.
        let Err(WorldError::Crowded { agent, crowded }) = Setup::of(&trial).world() else {
            panic!("{count}")
        };
        assert_eq!((&*agent, crowded.others), ("0", count - 1));
    }
    // Few enough are held, and counted in one line.
    let (trial, warnings) = all_at_one_point(200).1.unwrap();
    assert!(Setup::of(&trial).world().is_ok());
    assert!(warnings.to_string().contains("pairs of disks of different agents overlap"), "{warnings}");
    assert!(warnings.iter().count() <= 4, "{warnings}");
}

#[test]
fn more_materials_than_can_be_used_are_refused() {
    let each = |text: &dyn Fn(u32) -> String| (0..999).map(text).collect::<String>();
    let materials = each(&|k| format!("<Material Id='m{k}' YoungModulus='4e6' ShearModulus='1379310.3'/>"));
    let shapes = each(&|k| format!("<Shape Type='disk' Radius='0.2' MaterialId='m{k}' Position='0,0'/>"));
    let problems = edited(&[
        (FILES[1], "</Intrinsic>", &format!("{materials}</Intrinsic>")),
        (FILES[3], "</Agent>", &format!("{shapes}</Agent>")),
    ]);
    let problems = problems.unwrap_err().to_string();
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

#[test]
fn hostile_files_are_errors() {
    let deep = format!("{}{}", "<a>".repeat(200_000), "</a>".repeat(200_000));
    let deep_unclosed = "<Agents>".repeat(200_000);
    // 40 000 took 2 s, 300 000 over a minute, with a reader that looks through all before.
    let many: String = (0..100_000).map(|k| format!(" xmlns:a{k}='{k}'")).collect();
    let bomb = "<!DOCTYPE a [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;&a;&a;'>]><Agents>&b;</Agents>";
    let hostile: Vec<Vec<u8>> = vec![
        deep.into_bytes(),
        deep_unclosed.into_bytes(),
        format!("<Agents{many}/>").into_bytes(),
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
