//! Rules by which documents and runs are examined: each once, with its id. What they find are [`Problem`](crate::xml::Problem)s.

use crate::message::{Message, Sentence};
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
    /// Finding and advice.
    pub own: Sentence,
    /// What is said of findings, and parts of that; of a rule without its own, finding and advice.
    pub sentences: &'static [Sentence],
}

macro_rules! sentences_of {
    ($own:ident, $id:literal) => { &[$own] };
    ($own:ident, $id:literal, [$($name:ident)*]) => { &[$(sentences::$name),*] };
}

macro_rules! rules {
    ($($rule:ident $id:literal $severity:ident: $of:literal, $means:literal, $advice:literal
        $(, [$($name:ident $part:literal $text:literal,)*])?;)*) => {
        /// Sentences of the findings.
        #[allow(missing_docs)] // the text says it
        pub mod sentences {
            use super::Sentence;
            pub use super::parts::*;

            $($($(pub const $name: Sentence = Sentence { id: concat!($id, ".", $part), text: $text };)*)?)*
        }

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
                    $(Rule::$rule => {
                        const OWN: Sentence =
                            Sentence { id: $id, text: concat!($means, " (", $advice, ")") };
                        &RuleRow {
                            id: $id, severity: Severity::$severity, of: $of, means: $means, advice: $advice,
                            own: OWN, sentences: sentences_of!(OWN, $id $(, [$($name)*])?),
                        }
                    })*
                }
            }

            /// Says what it finds, and what to do.
            pub fn message(self) -> Message {
                Message::new(self.row().own, &[])
            }
        }
    };
}

/// What is said of findings of several rules, and of a finding with its place.
pub mod parts {
    crate::sentences! {
        ERROR "error" "{place}{message}";
        WARNING "warning" "warning: {place}{message}";
        NOTE "note" "note: {place}{message}";
        TWO_AGENTS "two-agents" "agents {one:?} and {other:?}";
        AGENT_AND_WALL "agent-and-wall" "agent {agent:?} and wall {wall:?}";
        AGENT_AND_CORNER "agent-and-corner" "agent {agent:?} and a corner of wall {wall:?}";
        AGENTS_IN_ALL "agents-in-all" " ({count} agents in all)";
        FACES_IN_ALL "faces-in-all" " ({count} faces in all)";
        WALLS_IN_ALL "walls-in-all" " ({count} walls in all)";
        OF "of" "{of}: {finding}";
        PUSH "push" "push: {finding}";
    }
}

rules! {
    // What readers say of files, of XML and of TOML, is a text.
    Invalid "invalid" Error: "every file", "a file cannot be read, or is not what it must be", "correct what the message names", [];
    NotRead "not-read" Warning: "XML files", "nobody reads an attribute, an element or a text", "correct its name, or remove it", [
        NOT_READ "name" "is not read{times}{meant}",
        NOT_READ_IN "element" "is not read in <{within}>{times}{meant}",
        TEXT_NOT_READ "text" "the text in it is not read{times}: {text:?}",
        MORE_NOT_READ "more" "more than {count} names of attributes and elements are not read",
        TIMES "times" " ({count} times)",
        MEANT "meant" "; is {word} meant?",
    ];
    Overlap "overlap-at-start" Warning: "AgentDynamics.xml", "bodies overlap others or walls, without a contact before", "move them apart: they are pushed apart violently", [
        OVERLAP "pairs" "{count} {pairs} of {what} overlap {when}, the deepest by {depth:.3} mm ({whose})",
        PAIR "pair" "pair",
        PAIRS "several" "pairs",
        DISKS_OF_AGENTS "agents" "disks of different agents",
        DISKS_AND_WALLS "walls" "disks and walls",
        AT_START "start" "at the start",
        WHERE_BACK "back" "where agents come back at t = {time:?} s",
    ];
    SamePlace "same-place" Warning: "AgentDynamics.xml", "two disks have their centres at one place: no force acts between them", "move one", [
        SAME_PLACE "pair" "{whose} have their centres at one place{others}: no force acts between them as long as this is so",
        ONE_PAIR_MORE "one-more" ", and one more pair",
        PAIRS_MORE "more" ", and {count} more pairs",
    ];
    StepTooLong "step-too-long" Warning: "TimeStepMechanical", "a mechanical step does not resolve the stiffest contact", "shorten it as the message says, or correct masses, materials and dampings", [
        NO_STEP "none" "no step resolves the contact of {pair}: are mass, moment of inertia and materials right?",
        RESOLVES "resolves" "{verdict} (period {period:.2e} s{damping}). A step of at most {proposed:e} s resolves all contacts",
        DAMPING_TIME "damping-time" ", damping time {time:.2e} s",
        DAMPED "damped" "{verdict}: its damping is the cause, {name} {damping:?} kg/s of the materials {first:?} and {second:?}, {ratio:.1e} times the critical damping of {critical:.1e} kg/s, from which on nothing bounces back: is it right?",
        LONG "long" "is stable (up to {stable:.1e} s), but long for the contact of {pair}",
        GAINS "gains" "is not stable (up to {stable:.1e} s): a body with {contacts} contacts like that of {pair} gains energy",
        CREATES "creates" "is not stable (up to {stable:.1e} s): collisions in the contact of {pair} create energy",
    ];
    StepOver "step-over" Warning: "TimeStepMechanical", "a disk may move further than its radius in a step, and step over a wall or somebody", "shorten the step, or correct speeds and forces", [
        STEP_OVER "disk" "a disk of agent {agent:?} may move {moved:.2e} m in it, further than its radius {radius:?} m, and step over a wall or somebody{others}: by Velocity and Fp the agent comes to {speed:.2e} m/s; {cure}",
        AGENTS_MAY "agents" " ({count} agents may)",
        SHORT_ENOUGH "cure" "at most {step:e} s would be short enough",
        NONE_SHORT_ENOUGH "no-cure" "no step is short enough: are its speed and its drive right?",
    ];
    StepTooShort "step-too-short" Warning: "TimeStepMechanical", "a communication step takes very many mechanical steps", "correct TimeStep or TimeStepMechanical", [
        TOO_SHORT "steps" "is short: each TimeStep of {step:?} s takes {steps:.1e} mechanical steps",
    ];
    Unusual "unusual-value" Warning: "attributes; drive.csv", "a value is outside of its usual range (below), perhaps in another unit", "correct its unit", [
        UNUSUAL "value" "{whose}{range} is usual, because {reason}: {ask}",
        UNUSUAL_IN_DRIVE "drive" "{column}=\"{value}\": {doubt}",
        WHOSE "whose" "{of}{others}: ",
        AND_MORE "more" " (and {count} more)",
        OF_AGENT "agent" "agent {agent:?}",
        OF_MATERIAL "material" "material {material:?}",
        OF_MATERIALS "materials" "materials {one:?} and {other:?}",
        OF_CHANGE "change" "agent {agent:?}, whose push changes in the {within:?} s after t={from:?}",
        OF_LAST_ROW "last-row" "last row",
        AT_MOST "at-most" "at most {high}",
        AT_LEAST "at-least" "at least {low}",
        FROM_TO "from-to" "{low} to {high}",
        IN_UNIT "unit" "is it in {unit} ({value})?",
        IS_RIGHT "right" "is it right?",
    ];
    BodySize "body-size" Warning: "Agents.xml", "a body is very small or large", "give Radius and Position in metres", [
        BODY_SIZE "wide" "agent {agent:?} is {width:.3} m wide{others}: are Radius and Position of its shapes in metres?",
    ];
    Centre "centre-outside" Warning: "Agents.xml", "a centre of mass is outside of the agent's own shapes", "give Positions of shapes relative to it", [
        CENTRE "agent" "the centre of mass of agent {agent:?} is outside of its own shapes{others}: are their Positions relative to it?",
    ];
    BodyMass "body-mass" Warning: "Agents.xml", "mass and height are together those of nobody", "give Mass in kg, Height in m", [
        BODY_MASS "index" "agent {agent:?} of Height {height:?} m has a Mass of {mass:.1} kg, {index:.1} kg/m²{others}: people have {least} to {most} kg/m²: is Mass in kg?",
    ];
    ChestNowhere "chest-at-no-disk" Warning: "Agents.xml", "no disk of an agent is at its ChestHeight: the load on its chest is 0", "correct ChestHeight, or Bottom and Top of the shapes", [
        CHEST_NOWHERE "agent" "agent {agent:?}: none of its shapes is at its ChestHeight {height:?} m{others}: the load on its chest is 0",
    ];
    LoadLength "load-length" Warning: "Materials.xml", "things of some height touch much more stiffly than their moduli say", "give LoadLength the height over which they touch", [
        LOAD_LENGTH_SHORT "stiff" "agent {agent:?} can touch something with {share:.1} times the stiffness of the plan view{others}: is LoadLength, {length:?} m, right?",
    ];
    WallsSize "walls-size" Warning: "Geometry.xml", "walls are very small or large for the people", "give Coordinates in metres", [
        WALLS_SMALL "small" "the walls span {width:.3} m × {height:.3} m, less than an agent: are their Coordinates in metres?",
        WALLS_AROUND_ONE "around-one" "the walls span {width:.3} m × {height:.3} m around 1 agent: are their Coordinates in metres?",
        WALLS_AROUND "around" "the walls span {width:.3} m × {height:.3} m around {agents} agents: are their Coordinates in metres?",
    ];
    WallsDoubled "walls-doubled" Warning: "Geometry.xml", "walls lie on each other: they act once, with the material of the first if their ends are the same", "remove one", [
        DOUBLED "faces" "{one} and {other} lie on each other{others}: they act like one wall{material}",
        FACE "face" "wall {wall:?} from {x:?},{y:?} to {to_x:?},{to_y:?}",
        OF_FIRST "first" " of {first:?}, the material of the first",
        OF_EITHER "either" ", of {first:?} or of {second:?} as rounding decides",
    ];
    OpeningShort "opening-short" Warning: "Geometry.xml", "a wall is open for less than a TimeStep: it may never be open", "open it for longer, or shorten TimeStep", [
        OPENING_SHORT "wall" "wall {wall:?}: Open from {from:?} to {to:?} s is shorter than the TimeStep of {step:?} s{others}: it may never be open",
    ];
    LinkSide "link-side" Warning: "Geometry.xml", "behind a line of a link there is not the strip of 0.5 m that people need", "the ground is to the left of each line, with 0.5 m behind it, and a wall behind that", [
        LINK_BLOCKED "wall" "link {link:?}: a wall is in the strip of 0.5 m behind its line from {x:?},{y:?} to {to_x:?},{to_y:?}: people may not get over it",
        LINK_OPEN "open" "link {link:?}: no wall is within {most} m behind its line from {x:?},{y:?} to {to_x:?},{to_y:?}: are people to walk on its left?",
    ];
    Outside "people-outside" Warning: "AgentDynamics.xml", "people stand outside of walls within which the others are, or far away", "move them, if it is not meant", [
        AWAY "far" "{who} {away:.0} m away from the others: is its Position in metres?",
        NOBODY_BETWEEN "nobody" "nobody is between the walls, and people span {width:.3} m × {height:.3} m: are their Positions in metres?",
        OUTSIDE_ALL "all" "{who} outside of all walls, but the others are inside: is this intended?",
        OUTSIDE_EMPTY "empty" "{who} outside of the closed walls, and nobody inside: is this intended?",
        OUTSIDE_CLOSED "closed" "{who} outside of the closed walls in which {count} others stand: is this intended?",
        STANDS "one" "agent {agent:?} stands",
        STAND "several" "{count} agents stand (first {agent:?})",
    ];
    InPillar "people-in-pillar" Warning: "AgentDynamics.xml", "people stand inside of what may be a pillar", "move them, or open the wall", [
        IN_PILLAR "wall" "{who}, {others}: is it a pillar?",
        STANDS_INSIDE "one" "agent {agent:?} stands inside the closed wall {wall:?}",
        STAND_INSIDE "several" "{count} agents stand inside closed walls (first {agent:?} inside {wall:?})",
        AROUND_ONE "around-one" "around which the other one stands",
        AROUND "around" "around which {count} others stand",
    ];
    RowsMissed "drive-rows-missed" Warning: "drive.csv", "rows between communication points are not applied, and differ much from what is", "shorten the communication step (TimeStep, --step)", [
        ROWS_MISSED "rows" "{rows} of {of} rows {come} between communication points, which are {step:?} s apart, so they are not applied: {worst}{all}",
        COMES "one" "comes",
        COME "several" "come",
        NOT_APPLIED "worst" "at t = {time:?} s agent {agent:?} has {column} = {push:?}, but the applied value is {first:?} from t = {before:?} s and {second:?} from t = {after:?} s",
        APPLIES_ALL "all" "; a communication step of {step:.3e} s applies all rows (TimeStep, --step)",
    ];
    RowsBetween "drive-rows-between" Note: "drive.csv (lemons check)", "rows are between communication points: the drive is interpolated at each point and held until the next, so results depend on TimeStep", "see whether a shorter step changes results", [
        ROWS_BETWEEN "rows" "{between} of {of} rows are between communication points: the drive is interpolated at each point and held until the next, so results depend on TimeStep",
    ];
    DriveAdded "drive-added" Note: "drive.csv, decision.toml", "the forces of drive.csv are added to those with which people walk", "--no-drive, or drive = false: only these";
    TooFast "too-fast" Warning: "decision.toml", "somebody wants to be faster than people are", "give speeds in m/s", [
        TOO_FAST "speed" "agent {agent:?} wants {speed:?} m/s{others}: people walk at 0.5 to 2 m/s, and run at 3 to 5 m/s",
        OTHERS_FASTER "others" ", and {count} others more than {fastest:?} m/s",
    ];
    CannotWalk "cannot-walk" Warning: "decision.toml, Agents.xml", "who has FloorDamping=\"0\" cannot walk: the force with which they walk is Mass · FloorDamping · speed", "give a FloorDamping", [
        CANNOT_WALK "agents" "{count} of {all} agents cannot walk (first {agent:?}): FloorDamping=\"0\" in Agents.xml, and the force with which they walk is Mass · FloorDamping · speed",
    ];
    ForcesUnused "forces-unused" Warning: "decision.toml, AgentDynamics.xml", "Fp and Mp of AgentDynamics.xml are not used, because people walk", "use a drive.csv", [
        FORCES_UNUSED "agent" "Fp and Mp in AgentDynamics.xml of agent {agent:?}{others} are not used, because people walk; forces of a drive.csv would be added",
        AND_OTHERS "more" " and {count} more",
    ];
    LegsIdle "legs-idle" Warning: "decision.toml, Agents.xml", "who has legs of the two-level model and FloorDamping=\"0\" does not try to stand still", "give a FloorDamping", [
        LEGS_IDLE "agent" "agent {agent:?} has legs and FloorDamping=\"0\" in Agents.xml: it does not try to stand still",
    ];
    LegsLate "legs-late" Warning: "decision.toml", "legs act once in a communication step, and too late", "shorten it (TimeStep, --step)", [
        LEGS_LATE "step" "communication step {step:?} s: legs act once in a step; with more than {longest:.3} s they act too late (--step; TimeStep in Parameters.xml)",
    ];
    FlatPush "flat-push" Note: "decision.toml", "in the model \"rotational\" people queue with gaps: above about 150 N squeezes hardly grow with the push, and they are no estimate of a crowd that presses without gaps", "docs/walking.md#how-hard-people-push";
    ExitHidden "exit-out-of-reach" Warning: "decision.toml, Geometry.xml", "an exit lies beyond walls, or so near before one that not everybody reaches it", "move it", [
        EXIT_LINE "line" "exit {exit:?} from ({x:.2}, {y:.2}) to ({to_x:.2}, {to_y:.2}) m lies less than {deep:.2} m before a wall: not everybody gets so near, and who does not reach it does not leave",
        EXIT_AREA "area" "exit {exit:?} at ({x:.2}, {y:.2}) m lies beyond walls, or less than {deep:.2} m before one: not everybody gets so near, and who does not reach it does not leave",
    ];
    WayBlocked "way-through-wall" Warning: "decision.toml, Geometry.xml", "a way to a way-point crosses a wall: ways to way-points are straight, and go round nothing", "add way-points", [
        WAY_BLOCKED "way" "the way of agent {agent:?} from ({x:.2}, {y:.2}) to ({to_x:.2}, {to_y:.2}) m crosses a wall{others}: ways to way-points are straight, and go round nothing",
        AS_MORE_DO "more" " (as ways of {count} more do)",
        AS_OTHERS_DO "others" " (as ways of others do)",
    ];
    PointHidden "way-point-out-of-reach" Warning: "decision.toml, Geometry.xml", "a way-point is nearer to a wall than anybody gets", "move it, or give it a larger radius", [
        POINT_HIDDEN "point" "the way-point at ({x:.2}, {y:.2}) m with radius = {radius:.3} m is {wall:.2} m before a wall: nobody gets so near",
    ];
    StraightLeaves "straight-model-presses" Warning: "decision.toml", "in the model \"straight\" people do not see each other: in front of an exit they push without end", "model = \"rotational\" is for doors, corridors and counterflow";
    StraightMeets "straight-model-counterflow" Note: "decision.toml", "people walk against each other: in the model \"straight\" they do not see each other, and push", "model = \"rotational\" is for doors, corridors and counterflow";
    SpeedLeaves "collision-free-speed-flow" Note: "decision.toml", "in the model \"collision-free-speed\" flows through doors are about half of what people reach in experiments", "model = \"rotational\" is for doors, corridors and counterflow";
    SpeedMeets "collision-free-speed-counterflow" Warning: "decision.toml", "people walk against each other: in the model \"collision-free-speed\" they nearly stand still", "model = \"rotational\" is for doors, corridors and counterflow";
    ForceLeaves "social-force-flow" Warning: "decision.toml", "in the model \"social-force\" flows through doors are two to four times what people reach in experiments", "model = \"rotational\" is for doors, corridors and counterflow";
    ForceMeets "social-force-counterflow" Warning: "decision.toml", "people walk against each other: for this, the model \"social-force\" has not been compared with experiments", "model = \"rotational\" is for doors, corridors and counterflow";
    Accuracy "step-accuracy" Note: "TimeStepMechanical (lemons check)", "up to which mechanical step the Trial is stable, and how accurate its own and another one are", "see docs/step.md", [
        ACCURATE "stable" "TimeStepMechanical {own:e} s: stable (up to {stable:.1e} s), with an error of about {error} in a collision{usual}",
        NOT_STABLE "not-stable" "TimeStepMechanical {own:e} s: not stable (up to {stable:.1e} s){usual}",
        ACCURATE_TO "usual" "; a step of {step:e} s has an error of about {error}",
    ];
    Stuck "stuck" Warning: "the end of a run", "in the model \"straight\" people walk on, whoever is in the way: most press on and get no further", "in decision.toml, model = \"rotational\" makes them keep distances", [
        PRESS_ON "people" "at t = {time:.3} s {stuck} of the {all} people who are there press on and get no further (median squeeze {squeeze:.0} N): in the model \"straight\" people walk on, whoever is in the way (in decision.toml, model = \"rotational\" makes them keep distances)",
    ];
    Uneven "exits-uneven" Note: "the end of a run", "exits are used unevenly: the last person left by one much later than by another", "exit_choice in decision.toml", [
        USED_UNEVENLY "exits" "exits are used unevenly: the last person left by {exit:?} at {time:.1} s, {before} (exit_choice in decision.toml)",
        NOBODY_BY "nobody" "nobody by {exit:?}",
        BY "by" "by {exit:?} at {time:.1} s",
    ];
    NoRoom "source-waits" Warning: "the end of a run", "people of a source waited outside: there was no room for them where they appear", "a larger line or area of the source, or fewer people per time", [
        WAITED "people" "source {source:?}: {count} people found no room when they were due, and waited outside, for up to {longest:.1} s{still}",
        STILL_OUTSIDE "still" "; at the end, {count} wait there",
    ];
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
            let RuleRow { id, severity, of, means, advice, .. } = rule.row();
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
