//! Rules by which documents and runs are examined: each once, with its id. What they find are [`Problem`](crate::xml::Problem)s.

use std::fmt;

/// Severity: whether a document can be used in spite of a problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// It cannot be used.
    Error,
    /// It can be used, but perhaps not as intended.
    Warning,
    /// It may be meant so; whoever reads the results should know it.
    Note,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        })
    }
}

/// Row of a rule.
#[derive(Debug)]
pub struct RuleRow {
    /// Name, which stays.
    pub id: &'static str,
    /// Severity of what it finds.
    pub severity: Severity,
    /// Files or values that it looks at.
    pub of: &'static str,
    /// Finding.
    pub means: &'static str,
    /// Advice.
    pub advice: &'static str,
}

macro_rules! rules {
    ($($rule:ident $id:literal $severity:ident: $of:literal, $means:literal, $advice:literal;)*) => {
        /// A rule.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[allow(missing_docs)] // as its row says
        pub enum Rule { $($rule),* }

        impl Rule {
            /// All of them.
            pub const ALL: &[Rule] = &[$(Rule::$rule),*];

            /// Returns what it is.
            pub fn row(self) -> &'static RuleRow {
                match self {
                    $(Rule::$rule => &RuleRow {
                        id: $id, severity: Severity::$severity, of: $of, means: $means, advice: $advice
                    },)*
                }
            }

            /// Says what it finds, and what to do.
            pub fn text(self) -> String {
                let RuleRow { means, advice, .. } = self.row();
                format!("{means} ({advice})")
            }
        }
    };
}

rules! {
    Invalid "invalid" Error: "every file", "a file cannot be read, or is not what it must be", "correct what the message names";
    NotRead "not-read" Warning: "XML files", "nobody reads an attribute, an element or a text", "correct its name, or remove it";
    Overlap "overlap-at-start" Warning: "AgentDynamics.xml", "bodies overlap others or walls, without a contact before", "move them apart: they are pushed apart violently";
    SamePlace "same-place" Warning: "AgentDynamics.xml", "two disks have their centres at one place: no force acts between them", "move one";
    StepTooLong "step-too-long" Warning: "TimeStepMechanical", "a mechanical step does not resolve the stiffest contact", "shorten it as the message says, or correct masses, materials and dampings";
    StepOver "step-over" Warning: "TimeStepMechanical", "a disk may move further than its radius in a step, and step over a wall or somebody", "shorten the step, or correct speeds and forces";
    StepTooShort "step-too-short" Warning: "TimeStepMechanical", "a communication step takes very many mechanical steps", "correct TimeStep or TimeStepMechanical";
    Unusual "unusual-value" Warning: "attributes; drive.csv", "a value is outside of its usual range (below), perhaps in another unit", "correct its unit";
    BodySize "body-size" Warning: "Agents.xml", "a body is very small or large", "give Radius and Position in metres";
    Centre "centre-outside" Warning: "Agents.xml", "a centre of mass is outside of the agent's own shapes", "give Positions of shapes relative to it";
    BodyMass "body-mass" Warning: "Agents.xml", "mass and height are together those of nobody", "give Mass in kg, Height in m";
    WallsSize "walls-size" Warning: "Geometry.xml", "walls are very small or large for the people", "give Coordinates in metres";
    WallsDoubled "walls-doubled" Warning: "Geometry.xml", "walls lie on each other: they act once, with the material of the first if their ends are the same", "remove one";
    OpeningShort "opening-short" Warning: "Geometry.xml", "a wall is open for less than a TimeStep: it may never be open", "open it for longer, or shorten TimeStep";
    Outside "people-outside" Warning: "AgentDynamics.xml", "people stand outside of walls within which the others are, or far away", "move them, if it is not meant";
    InPillar "people-in-pillar" Warning: "AgentDynamics.xml", "people stand inside of what may be a pillar", "move them, or open the wall";
    RowsMissed "drive-rows-missed" Warning: "drive.csv", "rows between communication points are not applied, and differ much from what is", "shorten the communication step (TimeStep, --step)";
    RowsBetween "drive-rows-between" Note: "drive.csv (lemons check)", "rows are between communication points: the drive is interpolated at each point and held until the next, so results depend on TimeStep", "see whether a shorter step changes results";
    DriveAdded "drive-added" Note: "drive.csv, decision.toml", "the forces of drive.csv are added to those with which people walk", "--no-drive, or drive = false: only these";
    TooFast "too-fast" Warning: "decision.toml", "somebody wants to be faster than people are", "give speeds in m/s";
    CannotWalk "cannot-walk" Warning: "decision.toml, Agents.xml", "who has FloorDamping=\"0\" cannot walk: the force with which they walk is Mass · FloorDamping · speed", "give a FloorDamping";
    ForcesUnused "forces-unused" Warning: "decision.toml, AgentDynamics.xml", "Fp and Mp of AgentDynamics.xml are not used, because people walk", "use a drive.csv";
    LegsIdle "legs-idle" Warning: "decision.toml, Agents.xml", "who has legs of the two-level model and FloorDamping=\"0\" does not try to stand still", "give a FloorDamping";
    LegsLate "legs-late" Warning: "decision.toml", "legs act once in a communication step, and too late", "shorten it (TimeStep, --step)";
    FlatPush "flat-push" Note: "decision.toml", "in the model \"rotational\" people queue with gaps: above about 150 N squeezes hardly grow with the push, and they are no estimate of a crowd that presses without gaps", "docs/walking.md#how-hard-people-push";
    ExitHidden "exit-out-of-reach" Warning: "decision.toml, Geometry.xml", "an exit lies beyond walls, or so near before one that not everybody reaches it", "move it";
    WayBlocked "way-through-wall" Warning: "decision.toml, Geometry.xml", "a way to a way-point crosses a wall: ways to way-points are straight, and go round nothing", "add way-points";
    PointHidden "way-point-out-of-reach" Warning: "decision.toml, Geometry.xml", "a way-point is nearer to a wall than anybody gets", "move it, or give it a larger radius";
    StraightLeaves "straight-model-presses" Warning: "decision.toml", "in the model \"straight\" people do not see each other: in front of an exit they push without end", "model = \"rotational\" is for doors, corridors and counterflow";
    StraightMeets "straight-model-counterflow" Note: "decision.toml", "people walk against each other: in the model \"straight\" they do not see each other, and push", "model = \"rotational\" is for doors, corridors and counterflow";
    SpeedLeaves "collision-free-speed-flow" Note: "decision.toml", "in the model \"collision-free-speed\" flows through doors are about half of what people reach in experiments", "model = \"rotational\" is for doors, corridors and counterflow";
    SpeedMeets "collision-free-speed-counterflow" Warning: "decision.toml", "people walk against each other: in the model \"collision-free-speed\" they nearly stand still", "model = \"rotational\" is for doors, corridors and counterflow";
    ForceLeaves "social-force-flow" Warning: "decision.toml", "in the model \"social-force\" flows through doors are two to four times what people reach in experiments", "model = \"rotational\" is for doors, corridors and counterflow";
    ForceMeets "social-force-counterflow" Warning: "decision.toml", "people walk against each other: for this, the model \"social-force\" has not been compared with experiments", "model = \"rotational\" is for doors, corridors and counterflow";
    Accuracy "step-accuracy" Note: "TimeStepMechanical (lemons check)", "up to which mechanical step the Trial is stable, and how accurate its own and another one are", "see docs/step.md";
    Stuck "stuck" Warning: "the end of a run", "in the model \"straight\" people walk on, whoever is in the way: most press on and get no further", "in decision.toml, model = \"rotational\" makes them keep distances";
    Uneven "exits-uneven" Note: "the end of a run", "exits are used unevenly: the last person left by one much later than by another", "exit_choice in decision.toml";
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;
    use std::path::Path;

    const RULE: &str = "|---|---|---|---|---|\n";

    /// `RULES=write` makes the table of the page again.
    #[test]
    fn the_page_has_all_rules() {
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/rules.md");
        let text = std::fs::read_to_string(&page).unwrap();
        let row = |rule: &Rule| {
            let RuleRow { id, severity, of, means, advice } = rule.row();
            format!("| `{id}` | {severity} | {of} | {means} | {advice} |\n")
        };
        let table: String = Rule::ALL.iter().map(row).collect();
        // The table of the page is from the line below its header to an empty line.
        let (before, rest) = text.split_once(RULE).unwrap();
        let (_, after) = rest.split_once("\n\n").unwrap();
        let wanted = format!("{before}{RULE}{table}\n{after}");
        if std::env::var_os("RULES").is_some_and(|value| value == "write") {
            std::fs::write(&page, &wanted).unwrap();
        }
        assert!(std::fs::read_to_string(&page).unwrap() == wanted, "RULES=write makes the table again");
        let kebab = |id: &str| id.chars().all(|c| c == '-' || c.is_ascii_lowercase());
        let ids: HashSet<&str> = Rule::ALL.iter().map(|rule| rule.row().id).collect();
        assert!(ids.len() == Rule::ALL.len() && ids.iter().all(|id| kebab(id)), "{ids:?}");
    }
}
