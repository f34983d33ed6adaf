//! Well-known text (OGC Simple Features) -> points, lines, polygons.

use crate::plane::{Polygon, Ring, Vec2, vec2};

/// More collections within each other are a mistake.
const DEEPEST: usize = 32;

/// A geometry of well-known text.
#[derive(Debug, Clone, PartialEq)]
pub enum WktGeometry {
    /// \[m\] `POINT`
    Point(Vec2),
    /// \[m\] `LINESTRING`, at least two corners.
    Line(Vec<Vec2>),
    /// `POLYGON`
    Polygon(Polygon),
}

/// Reads `POINT`, `LINESTRING`, `POLYGON`, their `MULTI…` and `GEOMETRYCOLLECTION`, in any case, one or several after each
/// other. What is in collections follows each other. Heights and measures (`Z`, `M`, `ZM`) are left out, and so is `SRID=…;`.
///
/// # Errors
/// The text is none of these, a ring is not closed, or a coordinate is not a finite number. The error is a sentence.
pub fn shapes_from_wkt(wkt: &str) -> Result<Vec<WktGeometry>, String> {
    let mut text = Text(wkt.trim_start_matches('\u{feff}'));
    let mut shapes = Vec::new();
    loop {
        text.space();
        if text.0.is_empty() {
            return Ok(shapes);
        }
        text.geometry(&mut shapes, 0)?;
        text.space();
        while text.take([',', ';']) {
            text.space();
        }
    }
}

/// Reads `POLYGON ((x y, …), (hole), …)`.
///
/// # Errors
/// The text is not a POLYGON, a ring is not closed, or a coordinate is not a finite number. The error is a sentence.
pub fn polygon_from_wkt(wkt: &str) -> Result<Polygon, String> {
    match <[WktGeometry; 1]>::try_from(shapes_from_wkt(wkt)?) {
        Ok([WktGeometry::Polygon(polygon)]) => Ok(polygon),
        _ => Err("is not a POLYGON in well-known text, such as POLYGON ((0 0, 4 0, 4 3, 0 0))".into()),
    }
}

/// The rest of the text.
struct Text<'a>(&'a str);

impl<'a> Text<'a> {
    fn space(&mut self) {
        self.0 = self.0.trim_start();
    }

    fn take<const N: usize>(&mut self, any: [char; N]) -> bool {
        let rest = self.0.strip_prefix(any);
        self.0 = rest.unwrap_or(self.0);
        rest.is_some()
    }

    /// The word that begins here, in upper case.
    fn word(&mut self) -> String {
        self.space();
        let end = self.0.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(self.0.len());
        let (word, rest) = self.0.split_at(end);
        self.0 = rest;
        word.to_ascii_uppercase()
    }

    fn geometry(&mut self, to: &mut Vec<WktGeometry>, depth: usize) -> Result<(), String> {
        let begin = self.0;
        let mut kind = self.word();
        if kind == "SRID" {
            self.0 = self.0.split_once(';').map_or("", |(_, rest)| rest);
            kind = self.word();
        }
        // Some write POLYGONZ.
        let kind = ["ZM", "Z", "M"].iter().find_map(|end| kind.strip_suffix(end)).unwrap_or(&kind).to_owned();
        let before = self.0;
        match &*self.word() {
            "" | "Z" | "M" | "ZM" => (),
            "EMPTY" => return Ok(()),
            _ => self.0 = before,
        }
        let before = self.0;
        if self.word() == "EMPTY" {
            return Ok(());
        }
        self.0 = before;
        match &*kind {
            "POINT" => to.extend(self.corners("POINT")?.first().map(|at| WktGeometry::Point(*at))),
            "MULTIPOINT" => self.points(to)?,
            "LINESTRING" => to.push(self.line()?),
            "MULTILINESTRING" => {
                self.parts("MULTILINESTRING", |text| {
                    to.push(text.line()?);
                    Ok(())
                })?;
            }
            "POLYGON" => to.push(self.polygon()?),
            "MULTIPOLYGON" => {
                self.parts("MULTIPOLYGON", |text| {
                    to.push(text.polygon()?);
                    Ok(())
                })?;
            }
            "GEOMETRYCOLLECTION" if depth >= DEEPEST => {
                return Err(format!("more than {DEEPEST} collections are within each other"));
            }
            "GEOMETRYCOLLECTION" => {
                self.parts("GEOMETRYCOLLECTION", |text| text.geometry(to, depth + 1))?;
            }
            _ => {
                let begin: String = begin.chars().take(40).collect();
                return Err(format!(
                    "{begin:?} is not a POLYGON or another geometry in well-known text, such as POLYGON ((0 0, 4 0, 4 3, 0 0))"
                ));
            }
        }
        Ok(())
    }

    /// Parts between parentheses, separated by commas.
    fn parts(
        &mut self,
        of: &str,
        mut part: impl FnMut(&mut Self) -> Result<(), String>,
    ) -> Result<(), String> {
        self.space();
        if !self.take(['(']) {
            return Err(format!("{of} must be followed by a parenthesis, at {}", self.excerpt()));
        }
        self.space();
        if self.take([')']) {
            return Ok(());
        }
        loop {
            self.space();
            part(self)?;
            self.space();
            if self.take([')']) {
                return Ok(());
            }
            if !self.take([',']) {
                let rest = self.excerpt();
                return Err(match of {
                    "POLYGON" => format!("rings of a POLYGON must be separated by commas, at {rest}"),
                    _ => format!("parts of a {of} must be separated by commas, at {rest}"),
                });
            }
        }
    }

    fn excerpt(&self) -> String {
        if self.0.is_empty() {
            "the end of the text".into()
        } else {
            format!("{:?}", self.0.chars().take(40).collect::<String>())
        }
    }

    fn corners(&mut self, of: &str) -> Result<Vec<Vec2>, String> {
        let mut corners = Vec::new();
        self.parts(of, |text| {
            corners.push(text.corner()?);
            Ok(())
        })?;
        Ok(corners)
    }

    /// Reads the points of a MULTIPOINT, each with or without parentheses of its own.
    fn points(&mut self, to: &mut Vec<WktGeometry>) -> Result<(), String> {
        self.parts("MULTIPOINT", |text| {
            if text.0.starts_with('(') {
                to.extend(text.corners("POINT")?.first().map(|at| WktGeometry::Point(*at)));
            } else {
                to.push(WktGeometry::Point(text.corner()?));
            }
            Ok(())
        })
    }

    fn line(&mut self) -> Result<WktGeometry, String> {
        let corners = self.corners("LINESTRING")?;
        if corners.len() < 2 {
            Err("a LINESTRING needs two corners".into())
        } else {
            Ok(WktGeometry::Line(corners))
        }
    }

    fn polygon(&mut self) -> Result<WktGeometry, String> {
        let mut rings = Vec::new();
        self.parts("POLYGON", |text| {
            if !text.0.starts_with('(') {
                return Err("each ring of a POLYGON must be in parentheses".into());
            }
            rings.push(ring(text.corners("POLYGON")?)?);
            Ok(())
        })?;
        let mut rings = rings.into_iter();
        let outer = rings.next().ok_or("POLYGON has no rings")?;
        Ok(WktGeometry::Polygon(Polygon { outer, holes: rings.collect() }))
    }

    fn corner(&mut self) -> Result<Vec2, String> {
        let end = self.0.find([',', '(', ')']).unwrap_or(self.0.len());
        let (text, rest) = self.0.split_at(end);
        let numbers: Option<Vec<f64>> =
            text.split_whitespace().map(|word| word.parse().ok().filter(|x: &f64| x.is_finite())).collect();
        match numbers.as_deref() {
            Some([x, y] | [x, y, _] | [x, y, _, _]) => {
                self.0 = rest;
                Ok(vec2(*x, *y))
            }
            _ => {
                let text: String = text.trim().chars().take(60).collect();
                Err(format!("{text:?} is not a corner; write two numbers, x and y in m"))
            }
        }
    }
}

fn ring(corners: Vec<Vec2>) -> Result<Ring, String> {
    let last = *corners.last().ok_or("a ring has no corners")?;
    if corners.len() < 4 || corners[0] != last {
        return Err(format!(
            "the ring that ends at {} {} is not closed: its first corner must be repeated at its end",
            last.x, last.y
        ));
    }
    Ring::through(corners).ok_or_else(|| "a ring has no corners".into())
}

#[cfg(test)]
mod tests {
    use super::WktGeometry::{Line, Point};
    use super::*;

    fn ring(corners: &[[f64; 2]]) -> Ring {
        Ring::through(corners.iter().map(|corner| Vec2::from(*corner)).collect()).unwrap()
    }

    #[test]
    fn geometries_are_read_as_shapely_and_postgis_write_them() {
        let triangle = || Polygon { outer: ring(&[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]]), holes: Vec::new() };
        let hole = ring(&[[1.0, 0.5], [2.0, 0.5], [2.0, 1.0]]);
        let with_hole = Polygon { holes: vec![hole], ..triangle() };
        for (text, expected) in [
            ("POLYGON ((0 0, 4 0, 4 3, 0 0))", vec![WktGeometry::Polygon(triangle())]),
            ("SRID=25832;POLYGON((0 0,4 0,4 3,0 0))\n", vec![WktGeometry::Polygon(triangle())]),
            ("polygon z((0 0 7, 4 0 7, 4 3 7, 0 0 7))", vec![WktGeometry::Polygon(triangle())]),
            ("POLYGON ZM ((0 0 7 1, 4 0 7 1, 4 3 7 1, 0 0 7 1))", vec![WktGeometry::Polygon(triangle())]),
            (
                "MULTIPOLYGON (((0 0, 4 0, 4 3, 0 0), (1 0.5, 2 0.5, 2 1, 1 0.5)), ((0 0, 4 0, 4 3, 0 0)))",
                vec![WktGeometry::Polygon(with_hole), WktGeometry::Polygon(triangle())],
            ),
            (
                "GEOMETRYCOLLECTION (POINT (1 2), GEOMETRYCOLLECTION (LINESTRING (0 0, 1e1 -1)), POINT EMPTY)",
                vec![Point(vec2(1.0, 2.0)), Line(vec![vec2(0.0, 0.0), vec2(10.0, -1.0)])],
            ),
            ("MULTIPOINT (1 2, 3 4)", vec![Point(vec2(1.0, 2.0)), Point(vec2(3.0, 4.0))]),
            ("MULTIPOINT ((1 2), (3 4))", vec![Point(vec2(1.0, 2.0)), Point(vec2(3.0, 4.0))]),
            ("POINT (1 2)\nPOINT (3 4);", vec![Point(vec2(1.0, 2.0)), Point(vec2(3.0, 4.0))]),
            ("MULTILINESTRING EMPTY", vec![]),
        ] {
            assert_eq!(shapes_from_wkt(text).as_ref(), Ok(&expected), "{text}");
        }
    }

    #[test]
    fn what_is_none_is_refused() {
        let deep = "GEOMETRYCOLLECTION (".repeat(40);
        for (text, expected) in [
            ("CURVE (0 0)", "\"CURVE (0 0)\" is not a POLYGON or another geometry"),
            ("LINESTRING (0 0)", "a LINESTRING needs two corners"),
            ("LINESTRING (0 0, 1)", "\"1\" is not a corner"),
            ("LINESTRING (0 0, 1 1", "separated by commas, at the end of the text"),
            ("POLYGON (0 0, 1 1)", "each ring of a POLYGON must be in parentheses"),
            ("MULTIPOLYGON ((0 0, 1 1))", "each ring of a POLYGON must be in parentheses"),
            (&deep, "more than 32 collections"),
        ] {
            let message = shapes_from_wkt(text).unwrap_err();
            assert!(message.contains(expected), "{text}: {message}");
        }
    }

    #[test]
    fn reads_back() {
        let text = "POLYGON ((0 0, 4 0, 4.1 3, 0 0), (1 0.1, 2 0.1, 2 0.2, 1 0.1))";
        let polygon = polygon_from_wkt(text).unwrap();
        assert_eq!((polygon.holes.len(), polygon.outer.corners().len()), (1, 3));
        assert_eq!(polygon.to_wkt(), text);
        let whole = polygon_from_wkt(" polygon((0 0,4 0,4.1 3,0 0))\n").unwrap();
        assert_eq!(whole, Polygon { holes: Vec::new(), ..polygon });
    }

    #[test]
    fn what_is_no_polygon_is_refused_with_its_reason() {
        for (text, expected) in [
            ("", "is not a POLYGON"),
            ("POLYGON", "must be followed by a parenthesis, at the end of the text"),
            ("POLYGON ()", "no ring"),
            ("POLYGON EMPTY", "is not a POLYGON"),
            ("POINT (0 0)", "is not a POLYGON"),
            ("POLYGON ((0 0, 4 0, 4 3))", "is not closed"),
            ("POLYGON ((0 0, 4 0, 4 inf, 0 0))", "\"4 inf\" is not a corner"),
            ("POLYGON ((0 0, 2 0, 2 3, 0 0) (2 2, 3 2, 2 3, 2 2))", "separated by commas"),
            ("POLYGON ((0 0, é", "\"é\" is not a corner"),
        ] {
            let message = polygon_from_wkt(text).unwrap_err();
            assert!(message.contains(expected), "{text}: {message}");
        }
    }
}
