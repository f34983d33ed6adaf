//! Where importers say that resources are, in all the ways they say it.

use crate::fmu::*;

fn opens(uri: &str) {
    if let Err(log) = instantiate(Fmu::get(), &Model::paper().guid, uri) {
        panic!("{uri}: {log:?}");
    }
}

/// `<temporary>/<name>/resources/Trial_push`
fn below(name: &str) -> (tempfile::TempDir, String) {
    let root = tempfile::tempdir().unwrap();
    copy_tree(&paper(), &root.path().join(name).join("resources/Trial_push"));
    let path = root.path().to_str().unwrap().to_owned();
    (root, path)
}

#[test]
fn prefixes_and_ends() {
    let (_root, path) = below("fmu");
    for prefix in ["file://", "file:", "file:///", "file://localhost", "FILE://", ""] {
        for end in ["/fmu/resources", "/fmu/resources/", "/fmu", "/fmu/"] {
            opens(&format!("{prefix}{path}{end}"));
        }
    }
}

#[test]
fn spaces_and_letters() {
    for (name, written) in [
        ("sp ace", vec!["sp ace", "sp%20ace"]),
        ("ü", vec!["ü", "%C3%BC", "%c3%bc"]),
        ("a%20b", vec!["a%20b", "a%2520b"]),
        ("100%", vec!["100%", "100%25"]),
        ("a+b", vec!["a+b", "a%2Bb"]),
        ("a#b?c&d", vec!["a#b?c&d", "a%23b%3Fc%26d"]),
        ("人群", vec!["人群", "%E4%BA%BA%E7%BE%A4"]),
    ] {
        let (_root, path) = below(name);
        for written in written {
            for end in ["/resources", "/resources/", ""] {
                opens(&format!("file://{path}/{written}{end}"));
                opens(&format!("{path}/{written}{end}"));
            }
        }
    }
}

/// Encoded and raw mean different directories here: the standard's reading goes first.
#[test]
fn the_encoded_reading_goes_first() {
    let (root, path) = below("a b");
    copy_tree(&paper(), &root.path().join("a%20b/resources/Other"));
    let instance =
        instantiate(Fmu::get(), &Model::paper().guid, &format!("file://{path}/a%20b/resources")).unwrap();
    instance.initialize();
    assert_eq!(instance.get_string("Trial"), "Trial_push");
}

#[test]
fn a_relative_path_and_a_link() {
    let (root, path) = below("fmu");
    std::os::unix::fs::symlink(root.path().join("fmu"), root.path().join("link")).unwrap();
    opens(&format!("file://{path}/link/resources"));
    // From where cargo runs tests, up to the root and down again.
    let up = "../".repeat(std::env::current_dir().unwrap().components().count());
    opens(&format!("{up}{path}/fmu/resources"));
    opens(&format!("./{up}{path}/fmu/resources/"));
}
