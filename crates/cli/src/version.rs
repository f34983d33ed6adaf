//! Which build of the sources this program is.

use std::fmt;
use std::sync::LazyLock;

/// A version, and the commit it was built from where that is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Build {
    /// Of the package.
    pub version: &'static str,
    /// Hexadecimal, whole; none for sources without `.git` whose packager named none.
    pub commit: Option<&'static str>,
    /// `2026-11-22`, of the commit, in UTC.
    pub date: Option<&'static str>,
    /// Whether the sources differ from the commit.
    pub changed: bool,
}

/// This one; the top-level `build.rs` has found it out.
pub const BUILD: Build = Build {
    version: env!("CARGO_PKG_VERSION"),
    commit: said(env!("LEMONS_BUILD_COMMIT")),
    date: said(env!("LEMONS_BUILD_DATE")),
    changed: !env!("LEMONS_BUILD_CHANGED").is_empty(),
};

/// Digits of a commit that are shown to people.
const SHORT: usize = 7;

/// As `lemons -V` and `lemons --version` say it.
pub static SHORT_AND_LONG: LazyLock<[String; 2]> = LazyLock::new(|| [BUILD.to_string(), BUILD.long()]);

const fn said(text: &'static str) -> Option<&'static str> {
    if text.is_empty() { None } else { Some(text) }
}

impl Build {
    /// As `Display`, but the commit whole: for files.
    pub fn whole(&self) -> String {
        self.with(self.commit)
    }

    /// For `lemons --version`: a line for each thing.
    pub fn long(&self) -> String {
        let mut text = self.to_string();
        let changed = if self.changed { ", and changes since" } else { "" };
        if let Some(commit) = self.commit {
            text += &format!("\ncommit {commit}{changed}");
        }
        if let Some(date) = self.date {
            text += &format!("\nof     {date}");
        }
        text
    }

    fn with(&self, commit: Option<&str>) -> String {
        let changed = self.changed.then_some("changed");
        let known: Vec<&str> = [commit, self.date, changed].into_iter().flatten().collect();
        if known.is_empty() {
            return self.version.to_owned();
        }
        format!("{} ({})", self.version, known.join(" "))
    }
}

/// `0.1.0 (abc1234 2026-11-22)`, or the version only; `changed` where the sources are not those of the commit.
impl fmt::Display for Build {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.with(self.commit.map(|commit| commit.get(..SHORT).unwrap_or(commit))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOME: Build = Build {
        version: "0.1.0",
        commit: Some("abc1234567890abcdef1234567890abcdef12345"),
        date: Some("2026-11-22"),
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
        let without = Build { commit: None, date: None, ..SOME };
        assert_eq!((without.to_string(), without.long()), ("0.1.0".into(), "0.1.0".into()));
        assert_eq!(Build { commit: Some("r12"), date: None, ..SOME }.to_string(), "0.1.0 (r12)");
    }
}
