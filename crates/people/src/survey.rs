//! A user's own copy of the public ANSUR II tables: real people, drawn with replacement.
//!
//! The public files ("ANSUR II MALE Public.csv", "… FEMALE …") have one line per person, lengths in mm, and the
//! column `weightkg` in tenths of a kg. Bideltoid breadth, chest depth, measured stature and measured mass are read.

use crate::error::{PeopleError, Result, require};
use crate::person::{BodyMeasure, Person, Sex};
use csv::{ReaderBuilder, StringRecord};
use lemons_core::trial::{BODY_MASS_INDEX, Problem, Problems};
use lemons_core::xml::decimal;
use std::borrow::Cow;
use std::fmt::Display;
use std::path::Path;

/// \[kg/m²\] About that of the survey's mean man and woman.
const USUAL_INDEX: f64 = 26.0;

/// The columns, in the order of [`BodyMeasure::ALL`], each with the number of its units in an SI unit.
const COLUMNS: [(&str, f64); 4] =
    [("bideltoidbreadth", 1000.0), ("chestdepth", 1000.0), ("stature", 1000.0), ("weightkg", 10.0)];

/// \[kg\] Units in which a column of masses may be by mistake: name, and what one of it is.
const OTHER_UNITS: [(&str, f64); 3] = [("kg", 1.0), ("lb", 0.453_592_37), ("g", 0.001)];

/// Says what is wrong with the mass of somebody who cannot be so heavy at their stature: a mass in another unit may be
/// that of a child.
fn fault_of_mass(person: &Person, value: f64) -> Option<String> {
    let [least, most] = BODY_MASS_INDEX;
    let index = |mass: f64| mass / person.stature.powi(2);
    let own = index(person.mass);
    if !own.is_finite() || (least..=most).contains(&own) {
        return None;
    }
    let off = |unit: &f64| (index(value * unit) / USUAL_INDEX).ln().abs();
    let nearest = OTHER_UNITS.into_iter().min_by(|(_, a), (_, b)| off(a).total_cmp(&off(b)));
    let meant = nearest.filter(|(_, unit)| (least..=most).contains(&index(value * unit)));
    let meant = meant.map_or(String::new(), |(unit, _)| format!("; is it in {unit}?"));
    Some(format!(
        "in tenths of a kg, {:.1} kg at a stature of {:.0} mm, is {own:.1} kg/m²: people have {least} to {most}{meant}",
        person.mass,
        1000.0 * person.stature
    ))
}

/// The people of a survey.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Survey {
    /// In the order of [`Sex::ALL`].
    people: [Vec<Person>; 2],
}

fn of_file(file: &Path, fault: impl Display) -> PeopleError {
    PeopleError::new(format!("{}: {fault}", file.display()))
}

/// Decodes UTF-8, or else Latin-1 as in the public files: its bytes are Unicode's first 256 characters.
fn text(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect()),
    }
}

impl Survey {
    /// Adds the people of one sex from the content of a public file, or of a table with the same columns.
    ///
    /// # Errors
    /// It lacks a column; or else all cells that are not a measure, with their places.
    pub fn add(&mut self, sex: Sex, file: &Path, content: &[u8]) -> Result<()> {
        let csv_error = |error| of_file(file, format_args!("is not CSV: {error}"));
        let content = text(content);
        let content = content.trim_start_matches('\u{feff}').as_bytes();
        let mut reader = ReaderBuilder::new().flexible(true).trim(csv::Trim::All).from_reader(content);
        let header = reader.headers().map_err(csv_error)?.clone();
        let place = |column: &'static str| {
            let mut places = header.iter().enumerate().filter(|(_, name)| name.eq_ignore_ascii_case(column));
            match (places.next(), places.next()) {
                (found, None) => Ok(found.map(|(place, _)| place)),
                _ => Err(of_file(file, format_args!("has more than one column {column:?}"))),
            }
        };
        let mut places = [0; 4];
        for (found, (column, _)) in places.iter_mut().zip(COLUMNS) {
            let missing = || of_file(file, format_args!("has no column {column:?}"));
            *found = place(column)?.ok_or_else(missing)?;
        }
        let gender = place("gender")?;
        let (mut people, mut bad) = (Vec::new(), Problems::default());
        let mut record = StringRecord::new();
        while reader.read_record(&mut record).map_err(csv_error)? {
            let line = record.position().map_or(0, csv::Position::line);
            let mut refuse = |fault: String| {
                let line = u32::try_from(line).unwrap_or(u32::MAX);
                bad.push_counted(Problem::of_file(file, Some(line), fault));
            };
            // A cell may contain anything: show it on one line, and cut it to a readable length.
            let cell = |column: &str, value: &str, fault: &str| {
                format!("{column} = {:.60}: {fault}", format!("{value:?}"))
            };
            if record.len() != header.len() {
                refuse(format!("has {} cells, but the header has {}", record.len(), header.len()));
                continue;
            }
            if let Some(place) = gender {
                let value = &record[place];
                if !value.eq_ignore_ascii_case(sex.name()) {
                    refuse(cell("gender", value, &format!("must be {:?} in this file", sex.name())));
                }
            }
            let mut measures = [f64::NAN; 4];
            for (k, (column, per_unit)) in COLUMNS.into_iter().enumerate() {
                let value = &record[places[k]];
                // A number that is not human is in another unit.
                let [least, most] = BodyMeasure::ALL[k].possible().map(|limit| limit * per_unit);
                match decimal(value) {
                    None => refuse(cell(column, value, "must be a decimal number")),
                    Some(number) if !(least..=most).contains(&number) => {
                        refuse(cell(column, value, &format!("must be within {least}…{most}")));
                    }
                    Some(number) => measures[k] = number / per_unit,
                }
            }
            let person = Person::from_measures(sex, measures);
            if person.depth > person.breadth {
                let [(breadth, per_unit), (depth, _), ..] = COLUMNS;
                let fault = format!("must not exceed {breadth}, {}", person.breadth * per_unit);
                refuse(cell(depth, &record[places[1]], &fault));
            }
            let mass = &record[places[3]];
            if let Some(fault) = decimal(mass).and_then(|value| fault_of_mass(&person, value)) {
                refuse(cell(COLUMNS[3].0, mass, &fault));
            }
            people.push(person);
        }
        require(bad.is_empty(), || bad.to_string())?;
        require(!people.is_empty(), || of_file(file, "has no people").to_string())?;
        self.people[sex as usize].append(&mut people);
        Ok(())
    }

    /// Returns all people of one sex, in the order of the files.
    pub fn people(&self, sex: Sex) -> &[Person] {
        &self.people[sex as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As in the public files: other columns around, Latin-1 in a place name.
    const MEN: &[u8] = b"subjectid,bideltoidbreadth,chestdepth,stature,weightkg,Gender,WritingPreference,SubjectsBirthLocation\r\n\
        10027,493,237,1776,815,Male,Right hand,North Dakota\r\n\
        10032,479,253,1702,726,Male,\"Left, \"\"hand\",Cura\xe7ao\r\n\
        10033,544,282,1735,929,Male,Left hand,New York\r\n";

    fn read(content: &[u8]) -> Result<Survey> {
        let mut survey = Survey::default();
        survey.add(Sex::Male, Path::new("male.csv"), content).map(|()| survey)
    }

    #[test]
    fn the_public_columns_are_read_in_their_units() {
        let survey = read(MEN).unwrap();
        let measures =
            [[0.493, 0.237, 1.776, 81.5], [0.479, 0.253, 1.702, 72.6], [0.544, 0.282, 1.735, 92.9]];
        let people = measures.map(|measures| Person::from_measures(Sex::Male, measures));
        assert_eq!(survey.people(Sex::Male), people);
        assert!(survey.people(Sex::Female).is_empty());
        // Other columns and their order do not matter, nor a byte order mark, nor the case of the names.
        let mut other =
            b"\xef\xbb\xbfSTATURE, WeightKG ,ChestDepth,bideltoidbreadth\n1776, 815,237,493\n".to_vec();
        assert_eq!(read(&other).unwrap().people(Sex::Male), &people[..1]);
        other.extend_from_slice(b"\n");
        assert!(read(&other).is_ok());
    }

    #[test]
    fn every_bad_cell_is_named() {
        let content = b"bideltoidbreadth,chestdepth,stature,weightkg,Gender\n\
            493,,1776,815,Male\n\
            493,237,177.6,x\xe9,Male\n\
            200,237,1776,815,Female\n\
            493,237\n\
            nan,1e9,-5,0x10,male\n";
        let message = read(content).unwrap_err().to_string();
        let expected = "male.csv:2: chestdepth = \"\": must be a decimal number\n\
            male.csv:3: stature = \"177.6\": must be within 300…3000\n\
            male.csv:3: weightkg = \"xé\": must be a decimal number\n\
            male.csv:4: gender = \"Female\": must be \"male\" in this file\n\
            male.csv:4: chestdepth = \"237\": must not exceed bideltoidbreadth, 200\n\
            male.csv:5: has 2 cells, but the header has 5\n\
            male.csv:6: bideltoidbreadth = \"nan\": must be a decimal number\n\
            male.csv:6: chestdepth = \"1e9\": must be within 50…2000\n\
            male.csv:6: stature = \"-5\": must be within 300…3000\n\
            male.csv:6: weightkg = \"0x10\": must be a decimal number";
        assert_eq!(message, expected);
        let mut many = b"bideltoidbreadth,chestdepth,stature,weightkg\n".to_vec();
        many.extend(b"x,237,1776,815\n".repeat(1000));
        let message = read(&many).unwrap_err().to_string();
        assert!(message.lines().count() == 21 && message.ends_with("and 980 more errors"), "{message}");
        let long =
            format!("bideltoidbreadth,chestdepth,stature,weightkg\n{},237,1776,815\n", "é\u{7}".repeat(5000));
        assert!(read(long.as_bytes()).unwrap_err().to_string().len() < 300);
    }

    /// A mass in another unit is that of somebody else of the same stature, and perhaps possible.
    #[test]
    fn masses_are_judged_by_stature() {
        let message = |stature: u32, mass: &str| {
            let row = format!("bideltoidbreadth,chestdepth,stature,weightkg\n493,237,{stature},{mass}\n");
            read(row.as_bytes()).map(drop).map_err(|error| error.to_string()).err().unwrap_or_default()
        };
        // A man of 81.5 kg and 1.776 m in kg, lb and g; a woman of 54.3 kg and 1.581 m in kg.
        assert_eq!(
            message(1776, "81.5"),
            "male.csv:2: weightkg = \"81.5\": in tenths of a kg, 8.2 kg at a stature of 1776 mm, is 2.6 kg/m²: people \
             have 10 to 110; is it in kg?"
        );
        assert!(message(1776, "179.7").ends_with("is 5.7 kg/m²: people have 10 to 110; is it in lb?"));
        assert!(message(1581, "54.3").ends_with("is it in kg?"));
        assert!(message(1776, "81500").starts_with("male.csv:2: weightkg = \"81500\": must be within"));
        assert!(
            message(1776, "4900").ends_with("155.3 kg/m²: people have 10 to 110"),
            "{}",
            message(1776, "4900")
        );
        // The lightest and the heaviest that were measured, a child of 5 (18 kg, 1.10 m).
        for (stature, mass) in [(1776, "815"), (1720, "301"), (1850, "3500"), (1100, "180")] {
            assert_eq!(message(stature, mass), "");
        }
    }

    #[test]
    fn files_that_are_no_survey_are_refused() {
        let message = |content: &[u8]| read(content).unwrap_err().to_string();
        assert_eq!(message(b""), "male.csv: has no column \"bideltoidbreadth\"");
        assert_eq!(message(b"bideltoidbreadth,chestdepth,weightkg\n"), "male.csv: has no column \"stature\"");
        let header = b"bideltoidbreadth,chestdepth,stature,weightkg\n";
        assert_eq!(message(header), "male.csv: has no people");
        assert_eq!(
            message(b"stature,bideltoidbreadth,chestdepth,stature,weightkg\n"),
            "male.csv: has more than one column \"stature\""
        );
    }
}
