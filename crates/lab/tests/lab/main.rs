//! What a page may ask for, as it asks: bytes in, bytes out.

mod design;
mod files;
mod leaving;
mod people;
mod runs;
mod same_bits;

use lemons_lab::Lab;
use lemons_lab::boundary::answer;
use serde_json::{Value, json};
use std::io::{Cursor, Write};
use std::ops::ControlFlow;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// The answer's JSON and bytes.
fn ask(lab: &mut Lab, request: &Value, bytes: &[u8]) -> (Value, Vec<u8>) {
    let text = request.to_string();
    let request = [&(text.len() as u32).to_le_bytes(), text.as_bytes(), bytes].concat();
    let answer = answer(lab, &request, &mut |_| ControlFlow::Continue(()));
    let length = u32::from_le_bytes(answer[..4].try_into().unwrap()) as usize;
    (serde_json::from_slice(&answer[4..4 + length]).unwrap(), answer[4 + length..].to_vec())
}

fn ok(lab: &mut Lab, request: Value) -> (Value, Vec<u8>) {
    let (mut value, bytes) = ask(lab, &request, &[]);
    assert!(value.get("ok").is_some(), "{request}: {value}");
    (value["ok"].take(), bytes)
}

fn refused(lab: &mut Lab, request: Value, bytes: &[u8]) -> String {
    let (value, nothing) = ask(lab, &request, bytes);
    assert!(nothing.is_empty());
    value["refused"].as_str().unwrap_or_else(|| panic!("{request}: {value}")).to_owned()
}

fn numbers(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).map(|number| f64::from_le_bytes(number.try_into().unwrap())).collect()
}

fn zipped(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in files {
        archive.start_file(*name, SimpleFileOptions::default()).unwrap();
        archive.write_all(content).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// A request to open a zip.
fn opened(name: &str, zip: &[u8]) -> Value {
    show(json!({"kind": "upload", "name": name, "files": [[name, zip.len()]]}), json!({"kind": "own"}))
}

/// The same zip with one more file.
fn zipped_with(zip: &[u8], name: &str, content: &[u8]) -> Vec<u8> {
    let mut archive = ZipWriter::new_append(Cursor::new(zip.to_vec())).unwrap();
    archive.start_file(name, SimpleFileOptions::default()).unwrap();
    archive.write_all(content).unwrap();
    archive.finish().unwrap().into_inner()
}

/// A request to show a base, with nothing changed by hand.
fn show(base: Value, motion: Value) -> Value {
    json!({"ask": "show", "base": base, "edits": [], "motion": motion})
}

fn push() -> Value {
    show(json!({"kind": "example", "name": "push"}), json!({"kind": "own"}))
}

fn square(width: f64, height: f64) -> Value {
    json!({"outline": [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]], "obstacles": [], "doors": []})
}

fn crowd(number: u32, room: Value) -> Value {
    json!({
        "kind": "crowd", "number": number, "density": null, "seed": 3, "room": room, "region": null,
        "people": {"kind": "survey"}, "men": 0.5, "direction": null, "speed": 0.0, "clothes": false,
    })
}

/// The base with another value at a key.
fn with(mut base: Value, key: &str, value: Value) -> Value {
    base[key] = value;
    base
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}
