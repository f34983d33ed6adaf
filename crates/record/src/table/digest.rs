//! A digest of what was written of a table: by it, a table is known again that nobody has changed since.

#[cfg(feature = "parquet")]
use lemons_columns::Cell;

/// FNV-1a of 128 bits. It is made byte by byte, so that a writer goes on with the digest of the writer before. It
/// protects against mistakes, not against forgery.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Digest(u128);

impl Digest {
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;

    /// Of no bytes.
    pub fn new() -> Digest {
        Digest(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d)
    }

    pub fn add(&mut self, bytes: &[u8]) {
        self.0 = bytes.iter().fold(self.0, |all, byte| (all ^ u128::from(*byte)).wrapping_mul(Digest::PRIME));
    }

    /// Its kind, then its value: different cells give different bytes.
    #[cfg(feature = "parquet")]
    pub fn add_cell(&mut self, cell: &Cell<'_>) {
        match cell {
            Cell::Real(value) => self.add_value(b'd', &value.to_bits().to_le_bytes()),
            Cell::Integer(value) => self.add_value(b'i', &value.to_le_bytes()),
            Cell::Long(value) => self.add_value(b'l', &value.to_le_bytes()),
            Cell::Boolean(value) => self.add_value(b'b', &[u8::from(*value)]),
            Cell::Text(value) => {
                self.add_value(b't', &(value.len() as u64).to_le_bytes());
                self.add(value.as_bytes());
            }
            Cell::Missing => self.add(b"-"),
        }
    }

    #[cfg(feature = "parquet")]
    fn add_value(&mut self, kind: u8, bytes: &[u8]) {
        self.add(&[kind]);
        self.add(bytes);
    }

    pub fn value(self) -> u128 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values of the definition: Fowler, Noll, Vo, <http://www.isthe.com/chongo/tech/comp/fnv/>.
    #[test]
    fn it_is_fnv_1a() {
        let of = |text: &str| {
            let mut digest = Digest::new();
            text.bytes().for_each(|byte| digest.add(&[byte]));
            digest.value()
        };
        assert_eq!(of(""), 0x6c62272e07bb014262b821756295c58d);
        assert_eq!(of("a"), 0xd228cb696f1a8caf78912b704e4a8964);
        assert_eq!(of("foobar"), 0x343e1662793c64bf6f0d3597ba446f18);
    }
}
