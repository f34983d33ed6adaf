//! Light files, good and bad.

use super::*;
use crate::bicycle::BicycleStatistics;
use crate::population::{Agent, Population, Proportions, Source};
use crate::random::{generator, uniform};

fn crowd(count: usize) -> Vec<LightAgent> {
    let proportions = Proportions { men: 0.5, pedestrians: 0.6 };
    let population = Population::new(Source::Ansur, proportions).unwrap();
    let rng = &mut generator(11);
    let settings = LightSettings::default();
    let mut agents = Vec::new();
    for (id, agent) in population.agents(12).take(count).enumerate() {
        let position = vec2(20.0 * uniform(rng) - 10.0, 20.0 * uniform(rng));
        let along = if uniform(rng) < 0.5 { Along::X } else { Along::Y };
        agents.push(match agent {
            Agent::Pedestrian(person) => {
                let shape = Shape::of(&person).unwrap();
                let angle = 7.0 * uniform(rng);
                LightAgent::pedestrian(id as u64, &shape, person.mass, position, angle, &settings)
            }
            Agent::Bicycle(bicycle) => LightAgent::bicycle(id as u64, &bicycle, position, along, &settings),
        });
    }
    agents
}

#[test]
fn a_mixed_crowd_reads_back_to_the_same_doubles() {
    let agents = crowd(40);
    let bicycles = agents.iter().filter(|agent| matches!(agent.shapes, LightShapes::Bicycle { .. }));
    assert!((5..35).contains(&bicycles.count()));
    let text = light_xml(&agents).unwrap();
    assert_eq!(read_light_xml(&text).unwrap(), agents);
    assert_eq!(read_light_xml(&light_xml(&[]).unwrap()).unwrap(), []);
    let named = LightSettings { pedestrian: "<\"a\" & 'b'>".into(), ..LightSettings::default() };
    let shape = Shape::fit(0.5, 0.25).unwrap();
    let agents = [LightAgent::pedestrian(u64::MAX, &shape, 1e-300, vec2(-0.0, 1e300), 0.1, &named)];
    assert_eq!(read_light_xml(&light_xml(&agents).unwrap()).unwrap(), agents);
}

#[test]
fn the_tags_are_the_papers() {
    let statistics = BicycleStatistics::default();
    let settings = LightSettings::default();
    let bicycle = Bicycle { wheel_width: 0.5, length: 2.0, handlebar: 1.0, top_tube: 1.5, mass: 12.0 };
    statistics.check().unwrap();
    let text = light_xml(&[LightAgent::bicycle(3, &bicycle, vec2(1.0, 10.0), Along::Y, &settings)]).unwrap();
    let inertia = bicycle.inertia();
    let words: Vec<&str> = text.split_whitespace().collect();
    let expected = format!(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?> <Agents> <Agent> <type>bike</type> <Id>3</Id> \
         <MomentOfInertia>{inertia:?}</MomentOfInertia> <FloorDamping>4.5</FloorDamping> \
         <AngularDamping>4.5</AngularDamping> <Shapes> \
         <bike> <type>rectangle</type> <material>iron</material> \
         <min_x>0.75</min_x> <min_y>9.0</min_y> <max_x>1.25</max_x> <max_y>11.0</max_y> </bike> \
         <rider> <type>rectangle</type> <material>human_clothes</material> \
         <min_x>0.5</min_x> <min_y>9.25</min_y> <max_x>1.5</max_x> <max_y>10.75</max_y> </rider> \
         </Shapes> </Agent> </Agents>"
    );
    assert_eq!(words.join(" "), expected);
}

#[test]
fn attributes_and_other_spellings_are_read() {
    let text = "<Agents><Agent Type='pedestrian' id='4' moment_of_inertia='1.5' FloorDamping='1' AngularDamping='2'>\
         <Shapes><disk1 type='disk' radius='0.2' material='skin' x='1' y='2'/>\
         <disk0 type='disk' radius='0.1' material='skin' x='1' y='3'/></Shapes></Agent><Other/></Agents>";
    let agents = read_light_xml(text).unwrap();
    let LightShapes::Pedestrian(disks) = &agents[0].shapes else { panic!("{agents:?}") };
    assert_eq!((agents[0].id, agents[0].moment_of_inertia), (4, 1.5));
    assert_eq!(disks.iter().map(|disk| disk.disk.radius).collect::<Vec<_>>(), [0.1, 0.2]);
}

/// Of `1<!-- -->2` only the 1 was read.
#[test]
fn a_value_is_all_its_text() {
    let file = |radius: &str, material: &str| {
        format!(
            "<Agents><Agent type='pedestrian' id='4' MomentOfInertia='1.5' FloorDamping='1' AngularDamping='2'>\n\
             <Shapes><disk0 type='disk' x='1' y='3'><radius>{radius}</radius><material>{material}</material>\
             </disk0></Shapes></Agent></Agents>"
        )
    };
    for (radius, material) in [
        ("1<!-- a comment -->2", "my<!-- -->skin"),
        ("<!-- -->12", "<![CDATA[my]]>skin"),
        ("1<![CDATA[2]]>", "my<?a b?>skin"),
        (" &#49;<?a b?>2 ", "<!-- -->&#109;yskin<!-- -->"),
        ("<![CDATA[1]]><!-- --><![CDATA[2]]>", "\n m<!-- -->y<!-- -->skin "),
    ] {
        let agents = read_light_xml(&file(radius, material)).unwrap();
        let LightShapes::Pedestrian(disks) = &agents[0].shapes else { panic!("{agents:?}") };
        assert_eq!(
            (disks[0].disk.radius, disks[0].material.as_str()),
            (12.0, "myskin"),
            "{radius} {material}"
        );
    }
    let said = |radius: &str| read_light_xml(&file(radius, "skin")).unwrap_err().to_string();
    assert_eq!(said("1<b>2</b>"), "line 2: <radius>: contains <b>; only text is allowed");
    assert_eq!(said("1<!-- --> 2"), "line 2: <disk0> radius: \"1 2\" must be a finite decimal number");
}

#[test]
fn bad_files_are_refused_by_line() {
    let good = light_xml(&crowd(8)).unwrap();
    let id = |k: u32| format!("<Id>{k}</Id>");
    let cases = [
        (good.replacen(&id(1), &id(0), 1), "Id: 0: must be unique"),
        (good.replacen(&id(1), "<Id>-1</Id>", 1), "Id: \"-1\" must be a whole number"),
        (good.replacen("<type>disk</type>", "<type>square</type>", 1), "type: \"square\" must be \"disk\""),
        (good.replacen("<radius>0.", "<radius>-0.", 1), "disk0 radius: -0."),
        (good.replacen("<x>", "<x>nan", 1), "must be a finite decimal number"),
        (good.replacen("<material>iron</material>", "", 1), "<bike> material: is missing"),
        (good.replacen("disk4>", "disk7>", 2), "a pedestrian has disk0 to disk4"),
        (good.replacen("disk4>", "disk3>", 2), "may appear only once"),
        (good.replacen("Agents>", "Crowd>", 2), "the root element must be <Agents>"),
        (good.replacen("</Agent>", "", 1), "is not well-formed XML"),
        (good.replacen("<type>bike</type>", "<type>tram</type>", 1), "must be \"pedestrian\" or \"bike\""),
        (good.replacen("<max_x>", "<max_x>-1e9</max_x><max_x>", 1), "<max_x>: may appear only once"),
        (
            good.replacen("<min_x>", "<min_x>9", 1).replacen("<min_x>9-", "<min_x>9", 1),
            "must be greater than min",
        ),
    ];
    for (text, fault) in cases {
        assert_ne!(text, good);
        let error = read_light_xml(&text).unwrap_err().to_string();
        assert!(error.contains(fault), "{fault}: {error}");
        assert!(error.len() < 300, "{error}");
    }
    let bomb = "<!DOCTYPE Agents [<!ENTITY a 'aaaa'>]><Agents>&a;</Agents>";
    assert_eq!(
        read_light_xml(bomb).unwrap_err().to_string(),
        "line 1: <!DOCTYPE>: document types are not allowed"
    );
    let mut line = read_light_xml("<Agents>\n\n<Agent Id='1'\n/></Agents>").unwrap_err().to_string();
    assert_eq!(line, "line 3: <Agent> Shapes: is missing");
    line = read_light_xml("<Agents><Agent><Id/></Agent></Agents>").unwrap_err().to_string();
    assert_eq!(line, "line 1: <Agent> Id: \"\" must be a whole number");
}

/// 300 000 took over a minute.
#[test]
fn elements_with_many_attributes_are_refused_before_they_are_parsed() {
    for prefix in ["", "xmlns:"] {
        let many: String = (0..300_000).map(|k| format!(" {prefix}a{k}='{k}'")).collect();
        let said = read_light_xml(&format!("<Agents>\n<Agent{many}/></Agents>")).unwrap_err().to_string();
        assert_eq!(said, "line 2: <Agent>: has 300000 attributes; at most 256 are allowed");
    }
}

#[test]
fn damaged_files_are_read_without_a_panic() {
    let good = light_xml(&crowd(3)).unwrap();
    let rng = &mut generator(13);
    let mut refused = 0;
    for _ in 0..3000 {
        let mut text: Vec<char> = good.chars().collect();
        let at = |rng: &mut _, length: usize| (uniform(rng) * length as f64) as usize;
        for _ in 0..1 + at(rng, 3) {
            let (from, to) = (at(rng, text.len()), at(rng, text.len()));
            match at(rng, 3) {
                0 => text[from] = char::from(at(rng, 128) as u8),
                1 => drop(text.drain(from.min(to)..from.max(to).min(from.min(to) + 40))),
                _ => text.swap(from, to),
            }
        }
        let text: String = text.into_iter().collect();
        match read_light_xml(&text) {
            // Whatever is taken can be written, and reads back.
            Ok(agents) => assert_eq!(read_light_xml(&light_xml(&agents).unwrap()).unwrap(), agents),
            Err(error) => {
                assert!(error.to_string().len() < 500, "{error}");
                refused += 1;
            }
        }
    }
    assert!(refused > 2000, "{refused}");
}

#[test]
fn what_cannot_be_read_back_is_not_written() {
    let good = crowd(1);
    let refuse = |change: &dyn Fn(&mut LightAgent)| {
        let mut agents = good.clone();
        change(&mut agents[0]);
        light_xml(&agents).unwrap_err().to_string()
    };
    assert_eq!(
        refuse(&|agent| agent.floor_damping = f64::NAN),
        "agent 0: FloorDamping = NaN: must be finite and not negative"
    );
    let shapes = |material: &str| {
        let disk = Disk { radius: 1.0, centre: Vec2::ZERO };
        LightShapes::Pedestrian(vec![LightDisk { disk, material: material.into() }])
    };
    for name in ["", "a\0b", " a", "a\nb"] {
        let message = refuse(&|agent| agent.shapes = shapes(name));
        assert!(message.contains("disk0 material") && message.contains(MATERIAL), "{message}");
    }
    let twice = [good[0].clone(), good[0].clone()];
    assert_eq!(light_xml(&twice).unwrap_err().to_string(), "agent 0: Id = 0: must be unique");
}
