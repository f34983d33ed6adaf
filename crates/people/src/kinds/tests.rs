use super::*;
use crate::bicycle::PAPER_BICYCLES;
use crate::population::{CrowdMember, Population, PopulationSource};
use lemons_core::distribution::{Range, TruncatedNormal};
use lemons_core::plane::shown_orientation;
use std::path::Path;
use std::sync::Mutex;

const MAN: Person = Person { sex: Sex::Male, breadth: 0.5, depth: 0.25, stature: 1.75, mass: 80.0 };

fn member(name: &str) -> Member {
    let kind = Kinds::built_in().unwrap().0[name].clone();
    let companion = kind.companion.map(|_| child(Sex::Female, 5.0, [0.0; 2]));
    let bicycle = kind.bicycle.then_some(Bicycle::TEMPLATE);
    kind.draw(MAN, companion, bicycle, &mut Random::new(3))
}

#[test]
fn each_kind_of_the_table_is_a_body_that_looks_ahead() {
    let kinds = Kinds::built_in().unwrap();
    for kind in kinds.iter() {
        assert!(
            !kind.sources.is_empty() && kind.sources.iter().all(|line| line.contains(": ")),
            "{}",
            kind.name
        );
        let Member { people, disks, mass, inertia, speed, .. } = member(&kind.name);
        let ends = [&disks[0], &disks[disks.len() - 1]].map(|part| part.disk.centre);
        assert!(shown_orientation(ends[0], ends[1]).abs() < 1e-12, "{}", kind.name);
        assert!(mass >= 80.0 && inertia > 1.0 && (0.1..3.1).contains(&speed), "{}", kind.name);
        // The masses balance about the origin: those of people, and of the part, where its disks are.
        let luggage = mass - people.iter().map(|(person, _)| person.mass).sum::<f64>();
        let of_part = disks.iter().filter(|part| part.material.is_some()).map(|part| part.disk);
        let of_part: Vec<Disk> = of_part.collect();
        let at = if of_part.is_empty() { Vec2::zeros() } else { union(&of_part).centroid };
        let sum = people.iter().fold(at * luggage, |sum, (person, at)| sum + *at * person.mass);
        assert!(sum.norm() < 1e-9, "{}: {sum:?}", kind.name);
        assert_eq!(luggage.abs() > 1.0, !kind.parts.is_empty() || kind.bicycle, "{}", kind.name);
    }
}

/// Compares the table of docs/people.md that begins so, or writes it.
fn assert_page_has(begin: &str, table: &str) {
    // Two tests write the page.
    static PAGE: Mutex<()> = Mutex::new(());
    let _alone = PAGE.lock();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/people.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let start = page.find(begin).unwrap();
    let length = page[start..].find("\n\n").unwrap() + 1;
    if std::env::var_os("KINDS_TABLE").is_some_and(|what| what == "write") {
        let page = format!("{}{table}{}", &page[..start], &page[start + length..]);
        std::fs::write(&path, page).unwrap();
        return;
    }
    let again = "write it again: KINDS_TABLE=write cargo test -p lemons-people kinds";
    assert_eq!(page[start..start + length], *table, "{again}");
}

/// The table of docs/people.md. `KINDS_TABLE=write cargo test -p lemons-people kinds` writes it.
#[test]
fn the_page_has_the_table() {
    let range = |[from, to]: [f64; 2]| format!("{from} to {to} years");
    let speed = |speed: &Distribution| match speed {
        Distribution::Normal(TruncatedNormal { mean, sd, min, max }) => {
            format!("{mean} ± {sd} ({min} to {max})")
        }
        Distribution::Uniform(Range { min, max }) => format!("{min} to {max}"),
    };
    let mut table =
        String::from("| kind | person | disks | speed m/s | sources |\n| --- | --- | --- | --- | --- |\n");
    for kind in Kinds::built_in().unwrap().iter() {
        let who = match (kind.ages, kind.companion, kind.seated) {
            _ if kind.bicycle => "adult, who rides".to_owned(),
            (Some(ages), ..) => range(ages),
            (_, Some(ages), _) => format!("adult, and a child of {}", range(ages)),
            (_, _, true) => "adult, seated".to_owned(),
            _ => "adult".to_owned(),
        };
        let own = if kind.seated { 0 } else { 5 * (1 + usize::from(kind.companion.is_some())) };
        let women = kind.speed_women.as_ref().map(|women| format!("; women {}", speed(women)));
        let speed = speed(&kind.speed) + &women.unwrap_or_default();
        let disks = if kind.bicycle { "some 48".to_owned() } else { (own + kind.disks()).to_string() };
        let sources = kind.sources.join("; ");
        table += &format!("| {} | {who} | {disks} | {speed} | {sources} |\n", kind.name);
    }
    assert_page_has("| kind | person |", &table);
}

/// Mean and standard deviation.
fn spread(values: &[f64]) -> [f64; 2] {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    [mean, (squares / (values.len() - 1) as f64).sqrt()]
}

/// Mean and standard deviation of as many men as women.
fn of_both([[men, sd_men], [women, sd_women]]: [[f64; 2]; 2]) -> [f64; 2] {
    let variance = 0.5 * (sd_men.powi(2) + sd_women.powi(2)) + 0.25 * (men - women).powi(2);
    [0.5 * (men + women), variance.sqrt()]
}

/// Adults' measures in the sources, in the order of [`BodyMeasure::ALL`](crate::BodyMeasure::ALL).
fn surveyed() -> [[f64; 2]; 4] {
    let of = |sex, k: usize| [ansur(sex).measures[k].mean, ansur(sex).measures[k].sd];
    std::array::from_fn(|k| of_both(Sex::ALL.map(|sex| of(sex, k))))
}

/// Stature and mass by the growth charts: the mean over the ages of the medians of boys and girls, and the
/// standard deviation of all, from the charts' quantiles.
fn charted([from, to]: [f64; 2]) -> [[f64; 2]; 2] {
    let mut all = [Vec::new(), Vec::new()];
    for sex in Sex::ALL {
        for k in 0..4000 {
            let (age, z) = (
                from + (to - from) * (f64::from(k / 100) + 0.5) / 40.0,
                inverse((f64::from(k % 100) + 0.5) / 100.0),
            );
            let one = child(sex, age, [z; 2]);
            all[0].push(one.stature);
            all[1].push(one.mass);
        }
    }
    all.map(|values| spread(&values))
}

/// The second table of docs/people.md: what is drawn beside what the sources say. It is written as the first one.
#[test]
fn the_page_has_what_is_drawn_beside_the_sources() {
    let shown = |[mean, sd]: [f64; 2], digits: usize| format!("{mean:.digits$} ± {sd:.digits$}");
    let of_speed = |speed: &Distribution| match speed {
        Distribution::Normal(TruncatedNormal { mean, sd, .. }) => [*mean, *sd],
        Distribution::Uniform(Range { min, max }) => [0.5 * (min + max), (max - min) / 12.0f64.sqrt()],
    };
    let mut table = String::from(
        "| kind | | stature m | mass kg | breadth m | depth m | mass of all kg | length × width of all m | speed m/s |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    let kinds = Kinds::built_in().unwrap();
    for kind in kinds.iter() {
        let mix = kinds.mix(&[(kind.name.clone(), 1.0)].into()).unwrap();
        let population = Population::new(PopulationSource::ansur().unwrap(), 0.5).unwrap().mixed(mix);
        let drawn: Vec<CrowdMember> = population.agents(1).take(2000).collect();
        let of = |value: &dyn Fn(&Member) -> f64| {
            spread(&drawn.iter().filter_map(CrowdMember::member).map(value).collect::<Vec<f64>>())
        };
        let measures: [[f64; 2]; 4] = std::array::from_fn(|k| of(&|member| member.people[0].0.measures()[k]));
        let [breadth, depth, stature, mass] = measures;
        let (whole, length, width) = (
            of(&|member| member.mass),
            of(&|member| member.shape().depth()),
            of(&|member| member.shape().breadth()),
        );
        let speed = of(&|member| member.speed);
        let drawn = [
            shown(stature, 2),
            shown(mass, 1),
            shown(breadth, 3),
            shown(depth, 3),
            shown(whole, 1),
            format!("{:.2} × {:.2}", length[0], width[0]),
            shown(speed, 2),
        ];
        table += &format!("| {} | drawn | {} |\n", kind.name, drawn.join(" | "));
        let none = || "assumed".to_owned();
        let iso = kind.sources.iter().any(|source| source.contains("ISO 7193"));
        // Of a child at a hand the walk is of the slower of two; of children it is by Froude's number.
        let assumed = kind.sources.iter().any(|source| {
            source.starts_with("speed: assumption")
                || source.contains("(assumption)") && source.starts_with("speed")
        });
        let says = match kind.speed_women.as_ref() {
            _ if assumed || kind.companion.is_some() => none(),
            Some(women) => shown(of_both([of_speed(&kind.speed), of_speed(women)]), 2),
            None => shown(of_speed(&kind.speed), 2),
        };
        let body = kind.sources.iter().any(|source| source.starts_with("body: assumption"));
        let people: [String; 4] = match kind.ages {
            Some(ages) => {
                let [stature, mass] = charted(ages);
                for (source, ours, off) in [(stature, measures[2], 0.02), (mass, measures[3], 0.03)] {
                    assert!(
                        (ours[0] / source[0] - 1.0).abs() < off && (ours[1] / source[1] - 1.0).abs() < 0.08,
                        "{source:?} {ours:?}"
                    );
                }
                [shown(stature, 2), shown(mass, 1), none(), none()]
            }
            None => {
                let [breadth, depth, stature, mass] = surveyed();
                // Four standard deviations of the mean of 2000, and of the standard deviation.
                for (source, ours) in surveyed().into_iter().zip(measures) {
                    assert!(
                        (ours[0] - source[0]).abs() < 4.0 * source[1] / 2000f64.sqrt(),
                        "{source:?} {ours:?}"
                    );
                    assert!((ours[1] / source[1] - 1.0).abs() < 0.08, "{source:?} {ours:?}");
                }
                let all = [shown(stature, 2), shown(mass, 1), shown(breadth, 3), shown(depth, 3)];
                if body { all.map(|text| format!("adults: {text}")) } else { all }
            }
        };
        let size = if iso { "at most 1.20 × 0.70".to_owned() } else { none() };
        let alone = kind.parts.is_empty() && kind.companion.is_none() && !kind.bicycle;
        let (mut whole, mut size) =
            if alone { ("as the person".to_owned(), "as the person".to_owned()) } else { (none(), size) };
        if kind.bicycle {
            // The disks reach over the rectangles by 1 to 4 cm.
            let [_, long, handlebar, _, mass] = PAPER_BICYCLES.map(|normal| normal.mean);
            assert!(
                (0.0..0.05).contains(&(length[0] - long)) && (0.0..0.08).contains(&(width[0] - handlebar))
            );
            (whole, size) = (format!("the person and {mass}"), format!("{long} × {handlebar}"));
        }
        table += &format!("| | source | {} | {whole} | {size} | {says} |\n", people.join(" | "));
    }
    assert_page_has("| kind | | stature", &table);
}

/// ISO 7193: 1.2 m long, 0.7 m broad.
#[test]
fn a_wheelchair_has_the_size_of_the_standard() {
    let chair = member("wheelchair");
    let shape = chair.shape();
    assert!((shape.depth() - 1.2).abs() < 1e-12 && (shape.breadth() - 0.7).abs() < 1e-12);
    assert!(chair.disks.iter().all(|part| part.material.as_deref() == Some("frame")));
    // Of a rectangle of the same mass, 98 kg (1.2² + 0.7²) m²/12 = 15.8 kg m², most mass is in the middle.
    assert!((2.0..15.0).contains(&chair.inertia), "{}", chair.inertia);
}

#[test]
fn a_load_moves_the_centre_of_mass_and_adds_inertia() {
    let kinds = Kinds::built_in().unwrap();
    let mut kind = (*kinds.0["suitcase"]).clone();
    kind.parts[0].mass = Distribution::Uniform(Range { min: 20.0, max: 20.0 + 1e-9 });
    kind.parts[0].disks = vec![[-0.42, -0.15, 0.22]];
    let member = Arc::new(kind).draw(MAN, None, None, &mut Random::new(1));
    let shape = Shape::of(&MAN).unwrap();
    let at = vec2(shape.ends().1 - 0.42, -0.15);
    let centre = at * 0.2;
    assert!((member.people[0].1 + centre).norm() < 1e-9 && (member.mass - 100.0).abs() < 1e-6);
    // Steiner, and a disk's m r²/2.
    let wanted = shape.inertia(80.0) + 0.5 * 20.0 * 0.22f64.powi(2) + 80.0 * 20.0 / 100.0 * at.norm_squared();
    assert!((member.inertia / wanted - 1.0).abs() < 1e-9, "{} {wanted}", member.inertia);
}

#[test]
fn impossible_kinds_are_refused() {
    let refused = |text: &str| {
        let table: BTreeMap<String, PersonKind> = toml::from_str(text).unwrap();
        Kinds::built_in().unwrap().with(table).unwrap_err().to_string()
    };
    let speed = "speed = { min = 1, max = 2 }\n";
    for (text, expected) in [
        ("speed = { min = 2, max = 1 }\n", "speed: min = 2, max = 1: min must be below max"),
        ("speed = { min = 1, max = 2 }\nperson = \"child\"", "ages: of children there must be ages"),
        (
            "speed = { min = 1, max = 2 }\ncompanion = [1, 3]",
            "companion = [1, 3]: must be from 2 to 18 years",
        ),
        ("speed = { min = 1, max = 2 }\nseated = true", "seated: there are no parts to sit in"),
        (
            "speed = { min = 1, max = 2 }\nbicycle = true",
            "bicycle = true: needs seated = true, and has no parts",
        ),
        (
            "speed = { min = 1, max = 2 }\nsolids = [{ box = [[0, 1], [0, 1], [0, 1]] }]",
            "solids: those of a part belong to it",
        ),
        (
            "speed = { min = 1, max = 2 }\nseated = true\n[[x.parts]]\nname = \"b\"\nmaterial = \"frame\"\n\
             mass = { min = 1, max = 2 }\ndisks = [[0, 0, 0.3], [0.5, 0, 0.3]]",
            "seated: the first disk must be the leftmost one",
        ),
    ] {
        let message = refused(&format!("[x]\n{text}"));
        assert!(message.starts_with("kind \"x\": ") && message.contains(expected), "{message}");
    }
    let table: BTreeMap<String, PersonKind> = toml::from_str(&format!("[pedestrian]\n{speed}")).unwrap();
    let message = Kinds::built_in().unwrap().with(table).unwrap_err().to_string();
    let table: BTreeMap<String, PersonKind> = toml::from_str(&format!("[bicycle]\n{speed}")).unwrap();
    let walks = Kinds::built_in().unwrap().with(table).unwrap_err().to_string();
    assert_eq!(walks, "kind \"bicycle\": must have bicycle = true, because others ride it");
    assert!(message.starts_with("kind \"pedestrian\": this name means something else"), "{message}");
    let part = "[[x.parts]]\nname = \"b\"\nmass = { min = 1, max = 2 }\n";
    let message = refused(&format!("[x]\n{speed}{part}material = \"gold\"\ndisks = [[0, 0, 1]]"));
    assert!(message.contains("part \"b\": material = \"gold\": must be one of frame, luggage"), "{message}");
    let message = refused(&format!("[x]\n{speed}{part}material = \"frame\"\ndisks = [[0, 0, 0]]"));
    assert!(message.contains("disk [0.0, 0.0, 0.0]: must be within 5 m"), "{message}");
    let mix = |text: &[(&str, f64)]| {
        let shares = text.iter().map(|(name, share)| ((*name).to_owned(), *share)).collect();
        Kinds::built_in().unwrap().mix(&shares)
    };
    let message = mix(&[("adlt", 1.0)]).unwrap_err().to_string();
    assert!(
        message.starts_with("there is no kind \"adlt\" (did you mean \"adult\"?); kinds are adult, backpack")
    );
    assert!(mix(&[("adult", 0.0)]).is_err() && mix(&[("adult", -1.0), ("child", 2.0)]).is_err());
    let half = mix(&[("adult", 3.0), ("child", 3.0)]).unwrap();
    assert!(half.iter().all(|(_, share)| *share == 0.5));
}
