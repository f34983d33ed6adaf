//! Words in messages: suggestions for misspelt ones, and long ones made short.

use std::borrow::Cow;
use std::fmt::Write;

/// Returns the known word that an unknown one most likely means. At most a third of its letters may differ (two in a
/// short word). Two exchanged letters count as one difference, and so does upper or lower case.
pub fn meant<'a>(unknown: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    /// Longer words are not compared: the time is the product of the lengths.
    const LONGEST: usize = 100;
    if unknown.len() > LONGEST {
        return None;
    }
    let near = known.into_iter().map(|word| (strsim::damerau_levenshtein(unknown, word), word));
    // In a word of two letters, at most one may differ.
    let enough =
        |apart: usize, word: &str| 3 * apart <= word.len().max(6) && apart < unknown.len().min(word.len());
    near.filter(|(apart, word)| enough(*apart, word)).min().map(|(_, word)| word)
}

/// Returns what serde says of a document, with a suggestion for an unknown key. In its `message` keys are between backticks:
/// first the unknown one, then the expected ones.
pub fn explained(text: &str, message: &str) -> String {
    let mut expected = message.split('`').skip(1).step_by(2);
    let unknown = expected.next().filter(|_| message.starts_with("unknown field"));
    match unknown.and_then(|unknown| meant(unknown, expected)) {
        Some(meant) => format!("{}\ndid you mean `{meant}`?", text.trim_end()),
        None => text.to_owned(),
    }
}

/// Returns a message in which long words, and long lines, have lost their middle: names come from files and can have any
/// length. Paths of a usual length stay whole. All messages that leave a program go through it.
pub fn shortened(message: &str) -> Cow<'_, str> {
    /// Characters of a word, and of a line: more are too many, and so many stay at its beginning and at its end.
    const WORD: [usize; 3] = [300, 100, 60];
    const LINE: [usize; 3] = [4000, 2400, 1200];
    if message.len() <= WORD[0] {
        return message.into();
    }
    let mut all = String::with_capacity(message.len().min(2 * LINE[0]));
    for line in message.split_inclusive('\n') {
        let words = line.split_inclusive(char::is_whitespace).map(|word| without_middle(word, WORD));
        all += &without_middle(&words.collect::<String>(), LINE);
    }
    all.into()
}

/// Takes the middle out of a text with too many characters.
fn without_middle(text: &str, [most, first, last]: [usize; 3]) -> Cow<'_, str> {
    let length = if text.len() > most { text.chars().count() } else { 0 };
    if length <= most {
        return text.into();
    }
    let place = |n: usize| text.char_indices().nth(n).map_or(text.len(), |(place, _)| place);
    let mut short = text[..place(first)].to_owned();
    let _ = write!(short, "… {} characters …", length - first - last);
    short += &text[place(length - last)..];
    short.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_and_lines_of_a_message_lose_their_middle() {
        let path = format!("/{}Agents.xml", "directory/".repeat(25));
        let usual = format!("{path}:3: agent \"A\": Radius=\"x\": is no number");
        assert_eq!(shortened(&usual), usual);
        let name = "né".repeat(30_000);
        let message =
            shortened(&format!("{path}: agent \"{name}\": Radius=\"x\"\nsecond line\n")).into_owned();
        assert!(message.starts_with(&format!("{path}: agent \"nén")), "{message}");
        assert!(
            message.contains("… 59844 characters …")
                && message.ends_with("né\": Radius=\"x\"\nsecond line\n"),
            "{message}"
        );
        assert!(message.chars().count() < 600, "{message}");
        // Words of a usual length, too many of them.
        let message = shortened(&format!("agent \"{}\": is there twice", "a b ".repeat(15_000))).into_owned();
        assert!(message.chars().count() < 4000 && message.ends_with("b \": is there twice"), "{message}");
        assert_eq!(shortened(&"a short line\n".repeat(1000)).len(), 13_000);
    }

    #[test]
    fn the_nearest_word_is_meant_and_a_far_one_is_not() {
        let known = ["Radius", "MaterialId", "Position", "Lx", "Ly"];
        for (unknown, word) in [
            ("Raduis", Some("Radius")),
            ("radius", Some("Radius")),
            ("Materialid", Some("MaterialId")),
            ("Pos", None),
            ("lx", Some("Lx")),
            ("Colour", None),
            ("Id", None),
            ("", None),
        ] {
            assert_eq!(meant(unknown, known), word, "{unknown}");
        }
        assert_eq!(meant(&"Radius".repeat(100_000), known), None);
    }
}
