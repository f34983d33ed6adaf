//! The points of a sweep: a row of parameter values for each.

use sha2::{Digest, Sha256};

/// The values of one parameter at all points.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// For an Integer or a Real.
    Integers(Vec<i64>),
    /// For a Real.
    Reals(Vec<f64>),
    /// For a String.
    Texts(Vec<String>),
}

/// The points of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Points {
    /// Names of the parameters, each with its values at all points.
    pub columns: Vec<(String, Values)>,
    /// Number of points.
    pub count: usize,
}

/// The parameter that names a directory where a crowd writes files.
pub(crate) const OUTPUT_DIRECTORY: &str = "OutputDirectory";

/// A larger number of points is taken for a mistake.
pub(crate) const MOST_POINTS: usize = 10_000_000;
/// \[byte\] Largest size of the values of all parameters at all points.
const LARGEST_POINTS: usize = 1_000_000_000;

/// The memory that is left for values; refuses values as soon as they need more.
pub(crate) struct Room {
    left: usize,
}

impl Room {
    pub(crate) fn new() -> Room {
        Room { left: LARGEST_POINTS }
    }

    /// Reserves memory for `values` values of a size \[byte\].
    pub(crate) fn take(&mut self, values: usize, size: usize) -> Result<(), String> {
        let left = values.checked_mul(size).and_then(|bytes| self.left.checked_sub(bytes));
        self.left = left.ok_or_else(|| {
            let most = LARGEST_POINTS / 1_000_000;
            format!("the values of all parameters at all points need more than {most} MB; use fewer points or parameters")
        })?;
        Ok(())
    }

    /// Reserves memory for copies of a text.
    pub(crate) fn take_text(&mut self, text: &str, times: usize) -> Result<(), String> {
        self.take(times, size_of::<String>() + text.len())
    }
}

impl Values {
    /// Returns the number of values.
    pub fn len(&self) -> usize {
        match self {
            Values::Integers(values) => values.len(),
            Values::Reals(values) => values.len(),
            Values::Texts(values) => values.len(),
        }
    }

    /// Returns whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the value at a point as text that is read back as the same number.
    pub fn text(&self, point: usize) -> String {
        match self {
            Values::Integers(values) => values[point].to_string(),
            Values::Reals(values) => format!("{:?}", values[point]),
            Values::Texts(values) => values[point].clone(),
        }
    }

    fn taken(&self, places: impl Iterator<Item = usize>) -> Values {
        match self {
            Values::Integers(values) => Values::Integers(places.map(|k| values[k]).collect()),
            Values::Reals(values) => Values::Reals(places.map(|k| values[k]).collect()),
            Values::Texts(values) => Values::Texts(places.map(|k| values[k].clone()).collect()),
        }
    }

    fn digest(&self, point: usize, digest: &mut Sha256) {
        match self {
            Values::Integers(values) => digest.update(values[point].to_le_bytes()),
            Values::Reals(values) => digest.update(values[point].to_le_bytes()),
            Values::Texts(values) => {
                digest.update((values[point].len() as u64).to_le_bytes());
                digest.update(values[point].as_bytes());
            }
        }
    }
}

impl Points {
    /// Returns the points that write files themselves, with their directories.
    pub fn output_directories(&self) -> impl Iterator<Item = (usize, String)> {
        let own = |name: &str| name.strip_prefix("crowd.").unwrap_or(name) == OUTPUT_DIRECTORY;
        let values = self.columns.iter().find(|(name, _)| own(name));
        let of =
            |values: &'_ Values| (0..self.count).map(|point| (point, values.text(point))).collect::<Vec<_>>();
        let texts = values.into_iter().flat_map(move |(_, values)| of(values));
        texts.filter(|(_, text)| !text.is_empty())
    }

    /// Returns all combinations. The last parameter varies fastest.
    ///
    /// # Errors
    /// There are no points, too many, or too many for that many parameters.
    pub fn grid(axes: Vec<(String, Values)>) -> Result<Points, String> {
        let mut count = 1_usize;
        for (name, values) in &axes {
            if values.is_empty() {
                return Err(format!("{name}: no values"));
            }
            count = count.checked_mul(values.len()).filter(|n| *n <= MOST_POINTS).ok_or_else(too_many)?;
        }
        let mut room = Room::new();
        for (name, values) in &axes {
            let mut take = || match values {
                Values::Texts(texts) => {
                    texts.iter().try_for_each(|text| room.take_text(text, count / texts.len()))
                }
                Values::Integers(_) | Values::Reals(_) => room.take(count, size_of::<f64>()),
            };
            take().map_err(|why| format!("{name}: {why}"))?;
        }
        let mut repeat = count;
        let columns = axes.into_iter().map(|(name, values)| {
            repeat /= values.len();
            let column = values.taken((0..count).map(|point| point / repeat % values.len()));
            (name, column)
        });
        Ok(Points { columns: columns.collect(), count })
    }

    /// Returns one point for each row of columns.
    ///
    /// # Errors
    /// There are no points, too many, or columns of different lengths.
    pub fn table(columns: Vec<(String, Values)>) -> Result<Points, String> {
        let count = columns.first().map_or(0, |(_, values)| values.len());
        if count == 0 {
            return Err("there are no points".into());
        }
        if count > MOST_POINTS {
            return Err(too_many());
        }
        match columns.iter().find(|(_, values)| values.len() != count) {
            Some((name, values)) => Err(format!("{name}: {} values, not {count}", values.len())),
            None => Ok(Points { columns, count }),
        }
    }

    /// Returns the SHA-256 of the names and of all values row by row: numbers as 8 little-endian bytes, texts as length
    /// and UTF-8.
    pub fn sha256(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
        let mut digest = Sha256::new();
        digest.update(serde_json::to_string(&names).unwrap_or_default());
        for point in 0..self.count {
            self.columns.iter().for_each(|(_, values)| values.digest(point, &mut digest));
        }
        hex(&digest.finalize())
    }
}

pub(crate) fn too_many() -> String {
    format!("there are more than {MOST_POINTS} points")
}

/// Hexadecimal, as hashes in a manifest.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_name_varies_fastest() {
        let axes = vec![
            ("a".to_owned(), Values::Reals(vec![1.0, 2.0])),
            ("b".to_owned(), Values::Texts(vec!["x".into(), "y".into(), "z".into()])),
        ];
        let points = Points::grid(axes).unwrap();
        assert_eq!(points.count, 6);
        assert_eq!(points.columns[0].1, Values::Reals(vec![1.0, 1.0, 1.0, 2.0, 2.0, 2.0]));
        assert_eq!(points.columns[1].1.text(4), "y");
        assert!(
            Points::grid(vec![("a".into(), Values::Reals(vec![]))]).unwrap_err().contains("a: no values")
        );
        let long = || ("a".to_owned(), Values::Integers((0..5000).collect()));
        assert!(Points::grid(vec![long(), long()]).unwrap_err().contains("more than"));
    }

    /// They took all the memory that there was.
    #[test]
    fn many_parameters_at_many_points_are_refused() {
        let many = ("a".to_owned(), Values::Integers((0..1_000_000).collect()));
        let ones = (0..1000).map(|k| (format!("p{k}"), Values::Reals(vec![1.0])));
        let said = Points::grid(std::iter::once(many.clone()).chain(ones).collect()).unwrap_err();
        assert!(
            said.starts_with("p124: the values of all parameters at all points need more than 1000 MB"),
            "{said}"
        );
        let text = ("t".to_owned(), Values::Texts(vec!["x".repeat(10_000)]));
        let said = Points::grid(vec![many, text]).unwrap_err();
        assert!(said.starts_with("t: the values"), "{said}");
    }
}
