//! Lines, areas and levels, as they are given.

use crate::error::Misused;
use crate::values::list;
use anyhow::{Result, bail};
use lemons_results::measure::{CountingLine, MeasuringArea};
use std::collections::HashSet;

/// A line or an area with a name of its own, or with its number for one.
#[derive(Clone)]
pub struct Labelled<T> {
    pub name: String,
    pub what: T,
}

/// Columns that a name takes in a terminal.
const LONGEST_NAME: usize = 20;

fn labelled<T>(text: &str, read: impl Fn(&str) -> Result<T, String>) -> Result<Labelled<T>, String> {
    let Some((name, rest)) = text.split_once('=') else {
        return Ok(Labelled { name: String::new(), what: read(text)? });
    };
    let name = name.trim();
    if name.is_empty() || name.chars().any(char::is_control) || name.chars().count() > LONGEST_NAME {
        return Err(format!("a name has 1 to {LONGEST_NAME} characters"));
    }
    Ok(Labelled { name: name.to_owned(), what: read(rest)? })
}

pub fn line(text: &str) -> Result<Labelled<CountingLine>, String> {
    labelled(text, |text| {
        let line = list(text).and_then(|numbers| CountingLine::of_numbers(&numbers));
        line.ok_or_else(|| "must be two different points, as in door=5,2,5,3".into())
    })
}

pub fn measuring_area(text: &str) -> Result<Labelled<MeasuringArea>, String> {
    labelled(text, |text| {
        let area = list(text).and_then(|numbers| MeasuringArea::of_numbers(&numbers));
        area.ok_or_else(|| {
            "must be the lower left and the upper right corner, as in front=3,1,5,4, or at least three corners of a \
             polygon that does not cross itself"
                .into()
        })
    })
}

/// Gives a number to what has no name.
///
/// # Errors
/// Two have the same name.
pub fn name_all<T>(option: &str, all: &mut [Labelled<T>]) -> Result<()> {
    let mut names = HashSet::new();
    for (n, Labelled { name, .. }) in (1..).zip(all) {
        if name.is_empty() {
            *name = i32::to_string(&n);
        }
        if !names.insert(&*name) {
            bail!(Misused(format!("{option}: two have the name {name:?}")));
        }
    }
    Ok(())
}
