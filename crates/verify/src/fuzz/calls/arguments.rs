//! Arguments of FMI calls from the fuzzer's bytes: numbers, arrays, texts, damaged states.

use crate::fuzz::models::{Fmu, OUTPUTS};
use arbitrary::{Arbitrary, Unstructured};
use lemons_fmi::testing::functions::ArgumentSource;
use std::any::TypeId;
use std::ffi::{CString, c_char, c_void};
use std::ptr::{null, null_mut};

/// A number, often one of interest.
#[derive(Debug, Clone, Copy, Arbitrary)]
pub(super) enum Real {
    Small(i16),
    Special(u8),
    Bits(u64),
}

impl Real {
    pub(super) fn value(self) -> f64 {
        const INF: f64 = f64::INFINITY;
        const TINY: f64 = f64::MIN_POSITIVE;
        const SPECIAL: [f64; 12] =
            [0.0, -0.0, 1.0, -1.0, 1e-3, 1e-4, 5e-324, TINY, 1e160, 1e300, INF, f64::NAN];
        match self {
            Real::Small(n) => f64::from(n) / 256.0,
            Real::Special(k) => SPECIAL[usize::from(k) % SPECIAL.len()],
            Real::Bits(bits) => f64::from_bits(bits),
        }
    }
}

/// Largest number of variables in a call.
pub(super) const MOST: usize = 12;
/// Largest number of elements in an array: see `models::LONGEST`.
pub(super) const ROOM: usize = 4096;

/// A change to a serialised state, in its content unless said otherwise.
#[derive(Debug, Clone, Arbitrary)]
pub(super) enum Edit {
    Byte(u16, u8),
    Real(u16, Real),
    Insert(u16, u8),
    Remove(u16, u8),
    Cut(u16),
    Whole(Vec<u8>),
    Header(u8, u8),
}

/// Choice whether a changed state gets the length and the checksum that belong to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Arbitrary)]
pub(super) enum Seal {
    Good,
    Old,
}

/// Magic, version, GUID, length: see `lemons_fmi::slave`.
pub(super) const HEADER: usize = 36;

pub(super) fn edited(bytes: &[u8], edits: &[Edit], seal: Seal) -> Vec<u8> {
    let end = bytes.len().saturating_sub(4).max(HEADER);
    let (mut header, mut content) = (bytes[..HEADER].to_vec(), bytes[HEADER..end].to_vec());
    for edit in edits.iter().take(MOST) {
        let place = |at: u16| usize::from(at) % content.len().max(1);
        match *edit {
            Edit::Header(at, byte) => header[usize::from(at) % HEADER] = byte,
            Edit::Whole(ref whole) => content.clone_from(whole),
            Edit::Insert(at, byte) => content.insert(place(at).min(content.len()), byte),
            _ if content.is_empty() => {}
            Edit::Byte(at, byte) => {
                let at = place(at);
                content[at] = byte;
            }
            Edit::Real(at, real) => {
                let at = place(at);
                let to = content.len().min(at + 8);
                content[at..to].copy_from_slice(&real.value().to_le_bytes()[..to - at]);
            }
            Edit::Remove(at, count) => {
                let at = place(at);
                content.drain(at..content.len().min(at + usize::from(count)));
            }
            Edit::Cut(at) => content.truncate(place(at)),
        }
    }
    if seal == Seal::Good {
        header[28..36].copy_from_slice(&(content.len() as u64).to_le_bytes());
    }
    header.extend(content);
    let checksum = match seal {
        Seal::Good => crc32fast::hash(&header).to_le_bytes().to_vec(),
        Seal::Old => bytes[end..].to_vec(),
    };
    header.extend(checksum);
    header
}

/// Arguments from the fuzzer's bytes, such as a function of this name expects.
pub(super) struct Drawn<'a, 'b> {
    pub(super) input: &'a mut Unstructured<'b>,
    pub(super) fmu: &'a Fmu,
    pub(super) slots: &'a mut [*mut c_void; 3],
    pub(super) sizes: &'a [u64],
    /// Serialised states.
    pub(super) saved: [&'a [u8]; 2],
    /// Variables of the type that the function is about.
    pub(super) fitting: &'a [u32],
    /// Which pointers are NULL, one bit each; mostly none.
    pub(super) nulls: u8,
    pub(super) pointers: u32,
    /// The variables that the function gets, until it gets their number.
    pub(super) references: Option<Vec<u32>>,
    /// The number of their values.
    pub(super) values: usize,
    /// True if a text may be a directory into which files are written.
    pub(super) writes: bool,
    pub(super) texts: Vec<CString>,
    pub(super) rooms: Vec<Vec<u64>>,
    pub(super) states: Vec<Vec<u8>>,
}

impl Drawn<'_, '_> {
    pub(super) fn draw<T: for<'c> Arbitrary<'c> + Default>(&mut self) -> T {
        self.input.arbitrary().unwrap_or_default()
    }

    pub(super) fn real(&mut self) -> u64 {
        self.input.arbitrary::<Real>().map_or(1.0, Real::value).to_bits()
    }

    pub(super) fn reference(&mut self) -> u32 {
        let (way, k) = self.draw::<(u8, u8)>();
        match way {
            0..160 => {
                self.fitting.get(usize::from(k) % self.fitting.len().max(1)).copied().unwrap_or(k.into())
            }
            160..240 => u32::from(k) % (self.fmu.count + 2),
            _ => self.draw(),
        }
    }

    /// Some values, drawn by a function.
    pub(super) fn some<T>(&mut self, value: impl Fn(&mut Self) -> T) -> Vec<T> {
        let count = 1 + usize::from(self.draw::<u8>()) % MOST;
        (0..count).map(|_| value(self)).collect()
    }

    /// An array of these values again and again.
    pub(super) fn array<T: Copy>(&mut self, values: &[T]) -> *mut c_void {
        self.rooms.push(vec![0; ROOM]);
        let room = self.rooms.last_mut().expect("it was pushed").as_mut_ptr().cast::<T>();
        for (k, value) in values.iter().cycle().take(ROOM).enumerate() {
            // SAFETY: the room has ROOM elements of eight bytes, and no type here is longer.
            #[allow(unsafe_code)]
            unsafe {
                room.add(k).write(*value);
            }
        }
        room.cast()
    }

    /// A text, or NULL. Files are written into OutputDirectory: it is one of ours.
    pub(super) fn text(&mut self) -> *const c_char {
        let known = if self.writes { &self.fmu.texts[..OUTPUTS] } else { &self.fmu.texts };
        let (way, k) = self.draw::<(u8, u8)>();
        let text = match way {
            0..160 => known[usize::from(k) % known.len()].clone(),
            160..220 if !self.writes => {
                let bytes: Vec<u8> = self.some(|drawn| drawn.draw::<u8>().max(1));
                CString::new(bytes).unwrap_or_default()
            }
            _ => return null(),
        };
        self.texts.push(text);
        self.texts.last().map_or(null(), |text| text.as_ptr())
    }
}

impl ArgumentSource for Drawn<'_, '_> {
    fn number(&mut self, of: TypeId) -> u64 {
        if of == TypeId::of::<f64>() {
            return self.real();
        }
        if of == TypeId::of::<u32>() {
            return self.reference().into();
        }
        let byte: u8 = self.draw();
        if of != TypeId::of::<usize>() {
            return i64::from(byte as i8).rem_euclid(3) as u64;
        }
        let Some(references) = self.references.take() else {
            // The number of values; sometimes more or less.
            let more = if byte < 200 { 0 } else { isize::from(byte % 8) - 3 };
            return self.values.saturating_add_signed(more) as u64;
        };
        let count = usize::from(byte) % (MOST + 1);
        self.values = self.fmu.length(&references[..count], self.sizes);
        count as u64
    }

    fn pointer(&mut self, of: TypeId) -> *mut c_void {
        let null = self.nulls >> self.pointers.min(7) & 1 == 1;
        self.pointers += 1;
        let array = if of == TypeId::of::<*const u32>() {
            let references: Vec<u32> = (0..MOST).map(|_| self.reference()).collect();
            let output = self.fmu.reference_of("OutputDirectory");
            self.writes |= references.iter().any(|reference| Some(*reference) == output);
            let array = self.array(&references);
            self.references = Some(references);
            array
        } else if of == TypeId::of::<*const f64>() {
            let values = self.some(Drawn::real);
            self.array(&values)
        } else if of == TypeId::of::<*const i32>() {
            let values = self.some(|drawn| match drawn.draw::<u8>() {
                0..128 => 1,
                128..240 => i32::from(drawn.draw::<i8>()),
                _ => drawn.draw(),
            });
            self.array(&values)
        } else if of == TypeId::of::<*const u64>() {
            let values = self.some(|drawn| match drawn.draw::<u8>() {
                byte @ 0..240 => u64::from(byte % 4),
                _ => drawn.draw(),
            });
            self.array(&values)
        } else if of == TypeId::of::<*const bool>() {
            let values = self.some(Drawn::draw::<bool>);
            self.array(&values)
        } else if of == TypeId::of::<*const *const c_char>() {
            let texts = self.some(Drawn::text);
            self.array(&texts)
        } else if of == TypeId::of::<*mut c_void>() {
            self.slots[usize::from(self.draw::<u8>()) % 3]
        } else if of == TypeId::of::<*mut *mut c_void>() {
            let slot = usize::from(self.draw::<u8>()) % 3;
            (&raw mut self.slots[slot]).cast()
        } else if of == TypeId::of::<*const u8>() {
            let (second, edits) = self.input.arbitrary::<(bool, Vec<Edit>)>().unwrap_or_default();
            let seal = if self.draw() { Seal::Good } else { Seal::Old };
            let saved = self.saved[usize::from(second)];
            let bytes = edited(saved, &edits, seal);
            self.values = bytes.len();
            self.states.push(bytes);
            self.states.last_mut().map_or(null_mut(), |bytes| bytes.as_mut_ptr().cast())
        } else {
            let array = self.array(&[0_u64]);
            if of == TypeId::of::<*mut u8>() {
                self.values = 8 * ROOM - 8;
            }
            array
        };
        if null { null_mut() } else { array }
    }
}
