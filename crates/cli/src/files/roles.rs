//! Which arguments of which command name files, and what becomes of those.

/// What a command does with a file or directory that an argument names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    Reads,
    /// As in `PLATFORM=FILE`
    ReadsAfterEquals,
    /// Reads, and may write over what it goes on from.
    GoesOn,
    Writes,
    /// Writes a text or a picture; `-` is standard output.
    Shows,
    /// Puts files into a directory.
    WritesInto,
}

use Role::{GoesOn, Reads, ReadsAfterEquals, Shows, Writes, WritesInto};

/// An argument: its field, how it is spelled (an operand is not), its role.
pub type Argument = (&'static str, &'static str, Role);

/// Every argument that names a file, of every command. A test compares it with the commands.
pub const ROLES: [(&str, &[Argument]); 16] = [
    (
        "crowd",
        &[
            ("geometry", "--geometry", Reads),
            ("custom", "--custom", Reads),
            ("ansur_male", "--ansur-male", Reads),
            ("ansur_female", "--ansur-female", Reads),
            ("binaries", "--binary", ReadsAfterEquals),
            ("output", "--output", WritesInto),
            ("zip", "--zip", Writes),
            ("fmu", "--fmu", Writes),
            ("population", "--population", Shows),
            ("light_xml", "--light-xml", Shows),
            ("sections_geojson", "--sections-geojson", Shows),
            ("sections_wkt", "--sections-wkt", Shows),
            ("obj", "--obj", Shows),
            ("stl", "--stl", Shows),
            ("svg", "--svg", Shows),
            ("png", "--png", Shows),
            ("pdf", "--pdf", Shows),
        ],
    ),
    (
        "person",
        &[
            ("obj", "--obj", Shows),
            ("stl", "--stl", Shows),
            ("geojson", "--geojson", Shows),
            ("wkt", "--wkt", Shows),
            ("svg", "--svg", Shows),
            ("pdf", "--pdf", Shows),
        ],
    ),
    (
        "pack",
        &[("trials", "", Reads), ("binaries", "--binary", ReadsAfterEquals), ("output", "--output", Writes)],
    ),
    (
        "decide",
        &[
            ("trial", "", Reads),
            ("plan", "--plan", Reads),
            ("binaries", "--binary", ReadsAfterEquals),
            ("output", "--output", Writes),
        ],
    ),
    ("connect", &[("fmus", "", Reads), ("output", "--output", Writes)]),
    (
        "run",
        &[
            ("input", "", Reads),
            ("drive", "--drive", Reads),
            ("plan", "--plan", Reads),
            ("resume", "--resume", GoesOn),
            ("output", "--output", Shows),
            ("outputs", "--outputs", Shows),
            ("state", "--state", Writes),
        ],
    ),
    ("sweep", &[("spec", "", Reads), ("output", "--output", Writes)]),
    (
        "plot",
        &[
            ("path", "", Reads),
            ("more", "", Reads),
            ("trial", "--trial", Reads),
            ("drive", "--drive", Reads),
            ("plan", "--plan", Reads),
            ("measured", "--measured", Reads),
            ("output", "--output", Writes),
        ],
    ),
    (
        "movie",
        &[
            ("path", "", Reads),
            ("more", "", Reads),
            ("trial", "--trial", Reads),
            ("drive", "--drive", Reads),
            ("plan", "--plan", Reads),
            ("measured", "--measured", Reads),
            ("output", "--output", Writes),
        ],
    ),
    (
        "measure",
        &[
            ("path", "", Reads),
            ("more", "", Reads),
            ("trial", "--trial", Reads),
            ("drive", "--drive", Reads),
            ("plan", "--plan", Reads),
            ("walkable", "--walkable", Reads),
            ("output", "--output", WritesInto),
            ("summary", "--summary", Shows),
            ("plot", "--plot", Writes),
        ],
    ),
    (
        "export",
        &[
            ("source", "", Reads),
            ("more", "--more", Reads),
            ("trial", "--trial", Reads),
            ("area", "--area", Reads),
            ("out", "", Shows),
        ],
    ),
    ("info", &[("fmu", "", Reads)]),
    ("check", &[("trials", "", Reads)]),
    ("describe", &[("trial", "", Reads), ("plan", "--plan", Reads)]),
    ("verify", &[]),
    ("bench", &[]),
];
