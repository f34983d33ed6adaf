//! Roles of layers, by their names.

/// Role of a layer, by its name: `walkablearea-…`, `obstacles-…`, `exits-…`, `distributions-…`, `waypoints-…`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LayerRole {
    /// Outlines of where people walk.
    WalkableArea,
    /// Obstacles.
    Obstacle,
    /// Lines or areas where people leave.
    Exit,
    /// Areas where people are placed.
    Distribution,
    /// Places to go to.
    Waypoint,
    /// Others of JuPedSim, such as journeys: they are left out.
    Unused,
}

const PLURALS: [(&str, LayerRole); 9] = [
    ("walkablearea", LayerRole::WalkableArea),
    ("walkable_area", LayerRole::WalkableArea),
    ("walkable-area", LayerRole::WalkableArea),
    ("walkable area", LayerRole::WalkableArea),
    ("obstacles", LayerRole::Obstacle),
    ("exits", LayerRole::Exit),
    ("distributions", LayerRole::Distribution),
    ("waypoints", LayerRole::Waypoint),
    ("journeys", LayerRole::Unused),
];
const SINGULARS: [(&str, LayerRole); 4] = [
    ("obstacle", LayerRole::Obstacle),
    ("exit", LayerRole::Exit),
    ("distribution", LayerRole::Distribution),
    ("waypoint", LayerRole::Waypoint),
];

impl LayerRole {
    /// Returns the role that the name of a layer of a CAD program says, as `of_name`. What drawings in drawings put
    /// before a name is passed over: `plan$0$exits-0`, `plan|exits-0`, and of numbers `0 - exits-0`.
    pub fn of(layer: &str) -> Option<(LayerRole, String)> {
        const BEFORE: [&str; 6] = ["$", "|", "::", "/", "\\", " - "];
        let layer = layer.trim();
        let is_number = |before: &str| before.trim().bytes().all(|byte| byte.is_ascii_digit());
        let ends = BEFORE.iter().flat_map(|sign| layer.match_indices(sign));
        let ends = ends.filter(|(at, sign)| *sign != " - " || is_number(&layer[..*at]));
        let mut begins: Vec<usize> =
            std::iter::once(0).chain(ends.map(|(at, sign)| at + sign.len())).collect();
        begins.sort_unstable();
        begins.into_iter().find_map(|begin| LayerRole::of_name(&layer[begin..]))
    }

    /// Returns the role that a name says, in any case, and the rest of the name. Singular words are meant only alone, or
    /// before a number: a layer of exit signs has no exits. `jps-` of JuPedSim, all of whose layers have a role, may be
    /// before it.
    pub(super) fn of_name(layer: &str) -> Option<(LayerRole, String)> {
        let layer = layer.trim();
        // The longer ones as in example drawings of JuPedSim of 2023.
        let sign = ["jps-", "jps_", "jps ", "jupedsim_", "jupedsim-"]
            .into_iter()
            .find(|sign| layer.get(..sign.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(sign)));
        let layer = &layer[sign.map_or(0, str::len)..];
        let rest = |word: &str| {
            let begin = layer.get(..word.len()).filter(|begin| begin.eq_ignore_ascii_case(word))?;
            let rest = &layer[begin.len()..];
            let named = rest.trim_start_matches(['-', '_', ' ', '.', ':']);
            let parted = named.len() < rest.len()
                || named.is_empty()
                || named.starts_with(|c: char| c.is_ascii_digit());
            parted.then(|| named.to_owned())
        };
        let plural = PLURALS.iter().find_map(|(word, role)| Some((*role, rest(word)?)));
        let number = |name: &String| name.chars().all(|c| c.is_ascii_digit());
        let singular = || SINGULARS.iter().find_map(|(word, role)| Some((*role, rest(word).filter(number)?)));
        let unknown = || sign.filter(|sign| sign.len() == 4).map(|_| (LayerRole::Unused, layer.to_owned()));
        plural.or_else(singular).or_else(unknown)
    }

    /// Returns the beginning of the layers' names.
    pub fn layer(self) -> &'static str {
        match self {
            LayerRole::WalkableArea => "walkablearea",
            LayerRole::Obstacle => "obstacles",
            LayerRole::Exit => "exits",
            LayerRole::Distribution => "distributions",
            LayerRole::Waypoint => "waypoints",
            LayerRole::Unused => "journeys",
        }
    }
}
