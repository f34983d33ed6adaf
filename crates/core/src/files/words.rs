//! Suggestions for misspelt words.

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

#[cfg(test)]
mod tests {
    use super::*;

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
