//! Requests of a page, as it asks: bytes in, bytes out.

mod design;
mod files;
mod leaving;
mod people;
mod runs;
mod same_bits;
#[cfg(feature = "typescript")]
mod types;
mod words;

use lemons_lab::boundary::answer;
use lemons_lab::frame::COLUMNS;
use lemons_lab::{Lab, upload};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::io::{Cursor, Write};
use std::ops::ControlFlow;
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

/// A request as it lies in memory.
fn bytes_of(request: &Value, bytes: &[u8]) -> Vec<u8> {
    let text = request.to_string();
    [&(text.len() as u32).to_le_bytes(), text.as_bytes(), bytes].concat()
}

/// The answer's JSON and bytes.
fn ask(lab: &mut Lab, request: &Value, bytes: &[u8]) -> (Value, Vec<u8>) {
    let answer = answer(lab, &bytes_of(request, bytes), &mut |_| ControlFlow::Continue(()));
    let length = u32::from_le_bytes(answer[..4].try_into().unwrap()) as usize;
    (serde_json::from_slice(&answer[4..4 + length]).unwrap(), answer[4 + length..].to_vec())
}

fn ok(lab: &mut Lab, request: Value) -> (Value, Vec<u8>) {
    ok_of(lab, request, &[])
}

fn ok_of(lab: &mut Lab, request: Value, bytes: &[u8]) -> (Value, Vec<u8>) {
    let (mut value, bytes) = ask(lab, &request, bytes);
    assert!(value.get("ok").is_some(), "{request}: {value}");
    (value["ok"].take(), bytes)
}

/// Texts of messages.
fn texts(of: &Value) -> Vec<String> {
    of.as_array().unwrap().iter().map(|message| message["text"].as_str().unwrap().to_owned()).collect()
}

fn refused(lab: &mut Lab, request: Value, bytes: &[u8]) -> String {
    let (value, nothing) = ask(lab, &request, bytes);
    assert!(nothing.is_empty());
    value["refused"]["text"].as_str().unwrap_or_else(|| panic!("{request}: {value}")).to_owned()
}

fn numbers(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).map(|number| f64::from_le_bytes(number.try_into().unwrap())).collect()
}

fn zipped<N: AsRef<str>, C: AsRef<[u8]>>(files: &[(N, C)]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in files {
        archive.start_file(name.as_ref(), SimpleFileOptions::default()).unwrap();
        archive.write_all(content.as_ref()).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// The text of the file in a zip whose name ends so.
fn file_in(zip: &[u8], end: &str) -> String {
    let mut archive = ZipArchive::new(Cursor::new(zip)).unwrap();
    let mut names = archive.file_names().map(|name| name.unwrap().into_owned());
    let name = names.find(|name| name.ends_with(end)).unwrap();
    drop(names);
    std::io::read_to_string(archive.by_name(&name).unwrap()).unwrap()
}

/// The scene of a zip that is opened.
fn open(lab: &mut Lab, name: &str, zip: &[u8]) -> Value {
    ok_of(lab, opened(name, zip), zip).0
}

fn read<T: DeserializeOwned>(value: &Value) -> T {
    serde_json::from_value(value.clone()).unwrap()
}

/// A request to open a zip.
fn opened(name: &str, zip: &[u8]) -> Value {
    own(json!({"kind": "upload", "name": name, "files": [[name, zip.len()]]}))
}

/// The same zip with one more file.
fn zipped_with(zip: &[u8], name: &str, content: &[u8]) -> Vec<u8> {
    let mut archive = ZipWriter::new_append(Cursor::new(zip.to_vec())).unwrap();
    archive.start_file(name, SimpleFileOptions::default()).unwrap();
    archive.write_all(content).unwrap();
    archive.finish().unwrap().into_inner()
}

/// The same zip with another text of a file.
fn changed(zip: &[u8], from: &str, to: &str) -> Vec<u8> {
    let mut archive = ZipArchive::new(Cursor::new(zip)).unwrap();
    let count = archive.len();
    let text = |place: usize| {
        let mut file = archive.by_index(place).unwrap();
        let name = file.name().unwrap().into_owned();
        let text = std::io::read_to_string(&mut file).unwrap();
        (name, if text == from { to.to_owned() } else { text })
    };
    zipped(&(0..count).map(text).collect::<Vec<_>>())
}

/// A request to show a base, with nothing changed by hand.
fn show(base: Value, motion: Value) -> Value {
    json!({"ask": "show", "base": base, "edits": [], "motion": motion})
}

/// The same, driven by its own files.
fn own(base: Value) -> Value {
    show(base, json!({"kind": "own"}))
}

fn push() -> Value {
    own(json!({"kind": "example", "name": "push"}))
}

/// A request for steps of a run.
fn advance(run: u32, steps: u64) -> Value {
    json!({"ask": "advance", "run": run, "steps": steps})
}

/// A request for a file of a run.
fn take(run: u32, wanted: Value) -> Value {
    json!({"ask": "take", "run": run, "wanted": wanted})
}

fn square(width: f64, height: f64) -> Value {
    json!({"outline": [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]], "obstacles": [], "doors": []})
}

fn crowd(number: u32, room: Value) -> Value {
    json!({
        "kind": "crowd", "number": number, "density": null, "seed": 3, "room": room,
        "people": {"kind": "survey"}, "men": 0.5, "direction": null, "speed": 0.0, "material": "human_naked",
    })
}

/// One region with these corners.
fn part(corners: Value) -> Value {
    json!([{"corners": corners}])
}

/// The base with another value at a key.
fn with(mut base: Value, key: &str, value: Value) -> Value {
    base[key] = value;
    base
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}
