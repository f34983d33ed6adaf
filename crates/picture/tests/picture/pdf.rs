//! PDF: what is in the file, and that it shows what the PNG shows.

use crate::common::row;
use lemons_core::plane::vec2;
use lemons_core::trial::Trial;
use lemons_picture::*;
use std::process::Command;

/// Of different areas: the colour bar has a gradient.
fn people() -> Trial {
    let mut trial = row(0..4);
    trial.agents[1].shapes[2].radius *= 1.2;
    trial
}

/// Cut by its view, with all that a picture may have: fills, forces, dashes, transparency, letters, a colour bar.
fn full(trial: &Trial) -> String {
    let mut scene = PictureScene::at_start(trial);
    scene.view = Some(Bounds { low: vec2(-0.6, -1.2), high: vec2(2.8, 0.8) });
    scene.forces = vec![DrawnForce { from: vec2(0.0, 0.0), to: vec2(1.0, 0.0), normal_force: 900.0 }];
    let trail = |measured, y: f64| Trail {
        agent: 1,
        measured,
        points: vec![vec2(0.0, y), vec2(0.6, y + 0.2), vec2(3.5, y)],
    };
    scene.trails = vec![trail(false, 0.4), trail(true, 0.5)];
    svg(&scene, &Style { fill: Fill::BodyArea, ids: true, time: Some(1.5), ..Style::default() })
}

fn text(pdf: &[u8]) -> String {
    String::from_utf8_lossy(pdf).into_owned()
}

/// The operators of the page.
fn content(pdf: &[u8]) -> String {
    let find = |what: &[u8]| pdf.windows(what.len()).position(|part| part == what).unwrap() + what.len();
    let (start, end) = (find(b"stream\n"), find(b"\nendstream") - b"\nendstream".len());
    String::from_utf8(miniz_oxide::inflate::decompress_to_vec_zlib(&pdf[start..end]).unwrap()).unwrap()
}

#[test]
fn a_page_of_curves_without_fonts() {
    let trial = people();
    let svg = full(&trial);
    let made = pdf(&svg).unwrap();
    assert!(made == pdf(&svg).unwrap(), "the same picture, the same bytes");
    let file = text(&made);
    assert!(file.starts_with("%PDF-1.") && file.trim_end().ends_with("%%EOF"));
    assert!(!file.contains("/Font") && !file.contains("/Image") && !file.contains("Date"), "{file}");
    // As large as the SVG: 96 px are 72 points.
    let attribute = |name: &str| -> f64 {
        svg.split(&format!(" {name}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
    };
    let page = file.split("/MediaBox [").nth(1).unwrap().split(']').next().unwrap();
    let page: Vec<f64> = page.split_whitespace().map(|number| number.parse().unwrap()).collect();
    assert_eq!(page, [0.0, 0.0, 0.75 * attribute("width"), 0.75 * attribute("height")]);
    let operators = content(&made);
    let count = |operator: &str| operators.lines().filter(|line| line.ends_with(operator)).count();
    assert_eq!(count(" re"), 128, "the colour bar");
    assert!(count(" c") > 50, "{} curves", count(" c"));
    assert!(count("] 0 d") >= 2, "dashes");
    assert_eq!(operators.matches("q\n").count(), operators.matches("Q").count());
    assert!(operators.contains("W\nn"), "cut by its view");
}

#[test]
fn what_no_picture_here_has_is_refused() {
    let svg = |inside: &str| {
        format!("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\" height=\"9\">{inside}</svg>")
    };
    let message = |inside: &str| pdf(&svg(inside)).unwrap_err().to_string();
    assert!(message("<g opacity=\"0.5\"><path d=\"M0 0H5V5Z\"/></g>").contains("opacity"));
    let radial = "<radialGradient id=\"r\"><stop offset=\"0\"/><stop offset=\"1\" stop-color=\"red\"/></radialGradient>";
    assert!(message(&format!("{radial}<path fill=\"url(#r)\" d=\"M0 0H5V5Z\"/>")).contains("gradients"));
    assert!(pdf("<svg").is_err());
    assert!(!text(&pdf(&svg("")).unwrap()).contains("/UserUnit"));
    // Readers refuse sides of more than 14400 units.
    let long = text(&pdf(&svg("").replace("width=\"9\"", "width=\"32000\"")).unwrap());
    assert!(long.contains("/MediaBox [0 0 12000 3.375]") && long.contains("/UserUnit 2"), "{long}");
}

/// With a program that draws PDF, where there is one.
#[test]
fn a_pdf_shows_what_the_png_shows() {
    if Command::new("pdftoppm").arg("-v").output().is_err() {
        eprintln!("skipped: there is no pdftoppm");
        return;
    }
    let trial = people();
    let svg = full(&trial);
    let directory = std::env::temp_dir().join(format!("lemons-picture-pdf-{}", std::process::id()));
    std::fs::create_dir_all(&directory).unwrap();
    std::fs::write(directory.join("page.pdf"), pdf(&svg).unwrap()).unwrap();
    let drawn = Command::new("pdftoppm")
        .current_dir(&directory)
        .args(["-r", "96", "-singlefile", "page.pdf", "page"])
        .output()
        .unwrap();
    assert!(drawn.status.success() && drawn.stderr.is_empty(), "{}", String::from_utf8_lossy(&drawn.stderr));
    let page = std::fs::read(directory.join("page.ppm")).unwrap();
    std::fs::remove_dir_all(&directory).unwrap();
    let width = Style::default().width as u32;
    let Pixels { width, height, rgba } = pixels(&svg, width, 1).unwrap();
    let header = format!("P6\n{width} {height}\n255\n");
    assert!(page.starts_with(header.as_bytes()), "{width} x {height}");
    let expected = rgba.chunks_exact(4).flat_map(|pixel| &pixel[..3]);
    let apart: f64 =
        page[header.len()..].iter().zip(expected).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>();
    // Edges are smoothed otherwise; a body that is missing makes 10.
    let mean = apart / f64::from(3 * width * height);
    assert!(mean < 2.0, "mean difference {mean} of 255");
}
