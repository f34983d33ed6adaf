//! Which build of the sources this program is.

use std::fmt;
use std::sync::LazyLock;

/// A version, and the commit it was built from; what is not known is empty.
#[derive(Clone, Copy)]
pub struct Build {
    /// Version of the package.
    version: &'static str,
    /// Hexadecimal, whole; empty for sources without `.git` whose packager named none.
    commit: &'static str,
    /// `2026-11-22`, of the commit, in UTC.
    date: &'static str,
    /// Whether the sources differ from the commit.
    changed: bool,
}

/// This one; `build.rs` has found it out.
pub const BUILD: Build = Build {
    version: env!("CARGO_PKG_VERSION"),
    commit: env!("LEMONS_BUILD_COMMIT"),
    date: env!("LEMONS_BUILD_DATE"),
    changed: !env!("LEMONS_BUILD_CHANGED").is_empty(),
};

/// Digits of a commit that are shown to people.
const SHORT: usize = 7;

/// Texts of `lemons -V` and `lemons --version`.
pub static SHORT_AND_LONG: LazyLock<[String; 2]> = LazyLock::new(|| [BUILD.to_string(), BUILD.long()]);

impl Build {
    /// Returns the text of `Display`, but with the whole commit: for files.
    pub fn whole(&self) -> String {
        let known = [self.commit, self.date, if self.changed { "changed" } else { "" }];
        let known: Vec<&str> = known.into_iter().filter(|text| !text.is_empty()).collect();
        if known.is_empty() {
            self.version.to_owned()
        } else {
            format!("{} ({})", self.version, known.join(" "))
        }
    }

    /// Returns a line for each thing.
    fn long(&self) -> String {
        let changed = if self.changed { ", and changes since" } else { "" };
        let lines = [("commit", self.commit, changed), ("of    ", self.date, "")];
        let known = lines.iter().filter(|(_, value, _)| !value.is_empty());
        known.fold(self.to_string(), |text, (what, value, more)| format!("{text}\n{what} {value}{more}"))
    }
}

/// `0.1.0 (abc1234 2026-11-22)`, or the version only; `changed` where the sources are not those of the commit.
impl fmt::Display for Build {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let commit = self.commit.get(..SHORT).unwrap_or(self.commit);
        f.write_str(&Build { commit, ..*self }.whole())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOME: Build = Build {
        version: "0.1.0",
        commit: "abc1234567890abcdef1234567890abcdef12345",
        date: "2026-11-22",
        changed: false,
    };

    #[test]
    fn a_build_says_what_is_known_of_it() {
        assert_eq!(SOME.to_string(), "0.1.0 (abc1234 2026-11-22)");
        assert_eq!(SOME.whole(), "0.1.0 (abc1234567890abcdef1234567890abcdef12345 2026-11-22)");
        let changed = Build { changed: true, ..SOME };
        assert_eq!(changed.to_string(), "0.1.0 (abc1234 2026-11-22 changed)");
        assert_eq!(
            changed.long(),
            "0.1.0 (abc1234 2026-11-22 changed)\ncommit abc1234567890abcdef1234567890abcdef12345, and changes \
             since\nof     2026-11-22"
        );
        let without = Build { commit: "", date: "", ..SOME };
        assert_eq!((without.to_string(), without.long()), ("0.1.0".into(), "0.1.0".into()));
        assert_eq!(Build { commit: "r12", date: "", ..SOME }.to_string(), "0.1.0 (r12)");
    }
}
