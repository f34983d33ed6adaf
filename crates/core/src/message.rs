//! Sentences with values. A sentence stands once, in a table, with an id. All programs say it in English; the page of the
//! lab says it in other languages, by its id and with the same values.

pub use crate::{message, sentences};

use crate::xml::quoted;
use serde::Serialize;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::{self, Display};
use std::ops::Deref;

/// A sentence of a table. Its places have names, and are written as those of `format!`: `{x:.2}`, `{id:?}`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sentence {
    /// Id, which stays.
    pub id: &'static str,
    /// English text.
    pub text: &'static str,
}

/// A sentence with its values, or a text without an id: what serde or a reader of XML says of a file.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Message {
    /// Id of the sentence; empty: it is none of a table.
    pub id: Cow<'static, str>,
    /// What is in its places, as it is written. Some are sentences, too.
    pub values: BTreeMap<&'static str, Message>,
    /// All of it in English.
    pub text: String,
}

impl Sentence {
    /// Returns whether its places have these names, and no other.
    pub const fn has(&self, names: &[&str]) -> bool {
        let (text, mut at, mut met) = (self.text.as_bytes(), 0, 0_u64);
        while at < text.len() {
            if text[at] == b'{' {
                let mut k = 0;
                while k < names.len() && !is_named(text, at + 1, names[k].as_bytes()) {
                    k += 1;
                }
                if k == names.len() {
                    return false;
                }
                met |= 1 << k;
            }
            at += 1;
        }
        met == (1 << names.len()) - 1
    }

    /// Returns its text between places, and of each place the name, and how it is written.
    pub fn parts(&self) -> impl Iterator<Item = (&'static str, Option<(&'static str, &'static str)>)> {
        self.text.split('}').map(|part| match part.split_once('{') {
            Some((before, place)) => (before, Some(place.split_once(':').unwrap_or((place, "")))),
            None => (part, None),
        })
    }
}

/// Returns whether the place that begins there has this name.
const fn is_named(text: &[u8], from: usize, name: &[u8]) -> bool {
    let mut k = 0;
    while k < name.len() {
        if text[from + k] != name[k] {
            return false;
        }
        k += 1;
    }
    matches!(text[from + k], b':' | b'}')
}

impl Message {
    /// Fills a sentence; [`message!`](crate::message!) does it.
    pub fn new(sentence: Sentence, values: &[(&'static str, &dyn Shown)]) -> Message {
        let (mut text, mut shown) = (String::new(), BTreeMap::new());
        for (before, place) in sentence.parts() {
            text += before;
            let value = place.and_then(|(name, form)| {
                let (name, value) = values.iter().find(|(known, _)| *known == name)?;
                Some((*name, value.shown(form)))
            });
            if let Some((name, value)) = value {
                text += &value;
                shown.insert(name, value);
            }
        }
        Message { id: sentence.id.into(), values: shown, text }
    }
}

/// Makes the message of a sentence: `message!(WALL, wall = &wall.id, x)`. The compiler refuses other names than those of its
/// places.
#[macro_export]
macro_rules! message {
    ($sentence:expr $(, $name:ident $(= $value:expr)?)* $(,)?) => {{
        const { assert!($sentence.has(&[$(stringify!($name)),*]), "the sentence has other places") };
        $crate::message::Message::new(
            $sentence,
            &[$((stringify!($name), &$crate::message!(@ $name $($value)?) as &dyn $crate::message::Shown)),*],
        )
    }};
    (@ $name:ident) => { $name };
    (@ $name:ident $value:expr) => { $value };
}

/// Makes a table of sentences: constants, and `ALL` of them.
#[macro_export]
macro_rules! sentences {
    ($($name:ident $id:literal $text:literal;)*) => {
        $(#[allow(missing_docs)] // the text says it
        pub const $name: $crate::message::Sentence = $crate::message::Sentence { id: $id, text: $text };)*
        /// All of the table.
        pub const ALL: &[$crate::message::Sentence] = &[$($name),*];
    };
}

/// A value in a place of a sentence.
pub trait Shown {
    /// Returns it as it is written.
    fn shown(&self, form: &str) -> Message;
}

impl Shown for f64 {
    fn shown(&self, form: &str) -> Message {
        let digits = || form.trim_matches(['.', 'e']).parse().unwrap_or(0);
        Message::from(match form {
            "" => self.to_string(),
            "?" => format!("{self:?}"),
            "e" => format!("{self:e}"),
            form if form.ends_with('e') => format!("{self:.*e}", digits()),
            _ => format!("{self:.*}", digits()),
        })
    }
}

impl Shown for usize {
    fn shown(&self, _: &str) -> Message {
        self.to_string().into()
    }
}

impl Shown for str {
    fn shown(&self, form: &str) -> Message {
        if form == "?" { quoted(self).into() } else { self.into() }
    }
}

impl Shown for String {
    fn shown(&self, form: &str) -> Message {
        str::shown(self, form)
    }
}

impl Shown for Message {
    fn shown(&self, _: &str) -> Message {
        self.clone()
    }
}

impl<T: Shown> Shown for Option<T> {
    fn shown(&self, form: &str) -> Message {
        self.as_ref().map_or_else(Message::default, |value| value.shown(form))
    }
}

impl<T: Shown + ?Sized> Shown for &T {
    fn shown(&self, form: &str) -> Message {
        (**self).shown(form)
    }
}

impl From<String> for Message {
    fn from(text: String) -> Message {
        Message { text, ..Message::default() }
    }
}

impl From<&str> for Message {
    fn from(text: &str) -> Message {
        text.to_owned().into()
    }
}

impl Deref for Message {
    type Target = str;

    fn deref(&self) -> &str {
        &self.text
    }
}

impl Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl std::error::Error for Message {}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO: Sentence = Sentence { id: "two", text: "{who:?} at ({x:.2}, {y:e}) m{others}: {n} {x:?}" };

    #[test]
    fn values_are_written_as_their_places_say() {
        let more = Sentence { id: "more", text: " (and {n} more)" };
        let others = Some(Message::new(more, &[("n", &2_usize)]));
        let message = message!(TWO, n = 5_usize, who = "a\nb", x = 1.0, y = 2e-5, others);
        assert_eq!(message.text, r#""a\nb" at (1.00, 2e-5) m (and 2 more): 5 1.0"#);
        assert_eq!((&*message.id, &*message.values["others"].id), ("two", "more"));
        let alone = message!(TWO, n = 1_usize, who = "a", x = 0.0, y = 0.0, others = None::<Message>);
        assert_eq!(alone.text, r#""a" at (0.00, 0e0) m: 1 0.0"#);
    }

    #[test]
    fn places_have_the_names_of_the_values() {
        assert!(TWO.has(&["n", "who", "others", "y", "x"]));
        assert!(!TWO.has(&["n", "who", "others", "y"]) && !TWO.has(&["n", "who", "others", "y", "x", "z"]));
        assert!(!TWO.has(&["n", "who", "other", "y", "x"]));
    }
}
