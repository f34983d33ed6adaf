//! What the description says that computed variables depend on, beside what moves.

use crate::fmu::*;
use crowd_mechanics::model::CrowdModel;
use crowd_mechanics::pack::FmuFormat;
use crowd_mechanics::quantities::CrowdQuantity;
use crowd_mechanics::{model_description::model_description, setup};
use lemons_core::plane::vec2;
use lemons_core::trial::{DriveTable, PanelChoice, Trial};
use lemons_fmi::Model as _;
use lemons_fmi::testing::dependencies::{declared_pairs, moved};
use lemons_fmi::variables::Known;

/// Everybody is pressed against others, agents 0 and 4 against walls, too; agent 1 is where agent 0 is, so that centres
/// coincide.
fn pressed() -> Trial {
    let (mut trial, _) = setup::read(&paper()).unwrap();
    let shapes = trial.agents[0].shapes.clone();
    trial.agents[1].shapes = shapes;
    let places = [(-0.1, 0.0), (-0.1, 0.0), (0.15, 0.05), (1.3, -0.02), (1.62, 0.03)];
    for (i, (own, (x, y))) in trial.dynamics.iter_mut().zip(places).enumerate() {
        (own.position, own.velocity) = (vec2(x, y), vec2(0.1 * i as f64, -0.1));
        (own.theta, own.omega) = (own.theta + 0.4, 0.2);
    }
    trial.agents.iter_mut().for_each(|agent| agent.chest_height = Some(1.3));
    trial.geometry.divide(PanelChoice::Longest(0.3)).unwrap();
    trial
}

#[test]
fn initial_unknowns_depend_on_what_is_declared_and_on_no_more() {
    let make = || CrowdModel::of_trial(pressed(), DriveTable::default());
    let moved = moved(make, Known::Starts);
    let declared = declared_pairs(&mut make(), Known::Starts);
    assert!(moved.is_subset(&declared), "{:?}", moved.difference(&declared));
    assert!(declared.is_subset(&moved), "{:?}", declared.difference(&moved));
}

#[test]
fn inputs_move_no_output_at_a_communication_point() {
    let make = || {
        let mut crowd = CrowdModel::of_trial(pressed(), DriveTable::default());
        crowd.initialize(0.0).unwrap();
        crowd
    };
    assert!(moved(make, Known::Inputs).is_empty());
    assert!(declared_pairs(&mut make(), Known::Inputs).is_empty());
}

/// In FMI 3.0 there are walls, Ids and all in a few arrays; in FMI 2.0 long lists are left out, which means "on all".
#[test]
fn long_lists_are_left_out_in_fmi_2() {
    let (few, _) = setup::read(&paper()).unwrap();
    let mut many = few.clone();
    for k in 1..10 {
        many.agents.extend(few.agents.iter().map(|agent| {
            let id = format!("{k}{}", agent.id);
            lemons_core::trial::Agent { id, ..agent.clone() }
        }));
        many.dynamics.extend(few.dynamics.iter().cloned());
    }
    for (trial, listed) in [(few, true), (many, false)] {
        let xml = model_description(&trial, FmuFormat::default());
        let initial = xml.split("<InitialUnknowns>").nth(1).unwrap();
        assert_eq!(initial.matches("dependencies=").count() > 0, listed);
        // No output depends on an input.
        let outputs = xml.split("<Outputs>").nth(1).unwrap().split("</Outputs>").next().unwrap();
        assert_eq!(outputs.matches("<Unknown").count(), outputs.matches("dependencies=\"\"").count());
    }
}

/// Another packed Trial is another scene.
#[test]
fn what_is_computed_depends_on_the_trial() {
    for version in BOTH {
        let resources = Resources::with_other("Trial_other", "0.2,0.0");
        let crowd = Crowd::on(version, &resources);
        crowd.enter_initialization();
        crowd.must(crowd.set_text("Trial", "Trial_other"));
        assert!(crowd.get("agent[0].NormalForce") > 0.0);
        crowd.must(crowd.set_text("Trial", "Trial_push"));
        assert_eq!(crowd.get("agent[0].NormalForce"), 0.0);
    }
    let depends = |of: &CrowdQuantity| of.row().initially_on.contains(&CrowdQuantity::Trial);
    use CrowdQuantity::*;
    assert!([NormalForce, WallPeakNormalForce, AgentContacts, LargestOverlap, AgentId].iter().all(depends));
}
