//! The values that an FMU is asked for or given, of one type at a time.

use super::{Calls, c_text};
use crate::error::{Error, Result};
use crate::ssp::{Affine, Fmi, Native};
use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr::null;

/// A type of values. In FMI 3.0 several types of variables have values of one: they are converted, if they can be.
pub trait Value: Clone + Default + PartialEq + 'static {
    /// Reads all values of variables of a type; leaves them as they are if the FMU refuses.
    ///
    /// # Errors
    /// The FMU lacks the function, or has a value that is none of this type.
    fn get(calls: &Calls, of: Native, references: &[u32], values: &mut [Self]) -> Result<()>;

    /// Sets all values of variables of a type.
    ///
    /// # Errors
    /// The FMU lacks the function, or a value is none of the variables' type.
    fn set(calls: &Calls, of: Native, references: &[u32], values: &[Self]) -> Result<()>;

    /// The value in the unit of the input to which it is sent; only Reals have units.
    fn converted(&self, _: Affine) -> Self {
        self.clone()
    }
}

impl Calls {
    /// Reads values of another type, which begin as `empty`. What a refusing FMU has written is not looked at.
    fn get_as<C: Copy, T>(
        &self,
        call: &'static str,
        references: &[u32],
        values: &mut [T],
        empty: C,
        convert: impl Fn(C) -> Result<T>,
    ) -> Result<()> {
        let mut read = vec![empty; values.len()];
        self.get(call, references, &mut read)?;
        for (value, read) in values.iter_mut().zip(read) {
            *value = convert(read)?;
        }
        Ok(())
    }
}

impl Value for f64 {
    fn converted(&self, map: Affine) -> f64 {
        map.apply(*self)
    }

    fn get(calls: &Calls, of: Native, references: &[u32], values: &mut [f64]) -> Result<()> {
        match (calls.fmi, of) {
            (Fmi::V2, _) => calls.get("fmi2GetReal", references, values),
            (Fmi::V3, Native::Float32) => {
                calls.get_as("fmi3GetFloat32", references, values, 0.0, |value: f32| Ok(f64::from(value)))
            }
            (Fmi::V3, _) => calls.get("fmi3GetFloat64", references, values),
        }
    }

    fn set(calls: &Calls, of: Native, references: &[u32], values: &[f64]) -> Result<()> {
        match (calls.fmi, of) {
            (Fmi::V2, _) => calls.set("fmi2SetReal", references, values),
            (Fmi::V3, Native::Float32) => {
                let values: Vec<f32> = values.iter().map(|value| *value as f32).collect();
                calls.set("fmi3SetFloat32", references, &values)
            }
            (Fmi::V3, _) => calls.set("fmi3SetFloat64", references, values),
        }
    }
}

fn get_whole<C: Copy + Default + Into<i128>>(
    calls: &Calls,
    call: &'static str,
    references: &[u32],
    values: &mut [i32],
) -> Result<()> {
    calls.get_as(call, references, values, C::default(), |value: C| {
        let value: i128 = value.into();
        i32::try_from(value).map_err(|_| out_of_range(call, value, "Int32, to which it is read"))
    })
}

fn out_of_range(call: &str, value: i128, of: &str) -> Error {
    Error::new(format!("{call}: {value} is not a value of {of}"))
}

fn set_whole<C: TryFrom<i32>>(
    calls: &Calls,
    call: &'static str,
    of: Native,
    references: &[u32],
    values: &[i32],
) -> Result<()> {
    let range = |value: &i32| out_of_range(call, i128::from(*value), of.name());
    let convert = |value: &i32| C::try_from(*value).map_err(|_| range(value));
    calls.set(call, references, &values.iter().map(convert).collect::<Result<Vec<C>>>()?)
}

impl Value for i32 {
    fn get(calls: &Calls, of: Native, references: &[u32], values: &mut [i32]) -> Result<()> {
        match (calls.fmi, of) {
            (Fmi::V2, _) => calls.get("fmi2GetInteger", references, values),
            (_, Native::Int8) => get_whole::<i8>(calls, "fmi3GetInt8", references, values),
            (_, Native::UInt8) => get_whole::<u8>(calls, "fmi3GetUInt8", references, values),
            (_, Native::Int16) => get_whole::<i16>(calls, "fmi3GetInt16", references, values),
            (_, Native::UInt16) => get_whole::<u16>(calls, "fmi3GetUInt16", references, values),
            (_, Native::UInt32) => get_whole::<u32>(calls, "fmi3GetUInt32", references, values),
            (_, Native::Int64) => get_whole::<i64>(calls, "fmi3GetInt64", references, values),
            (_, Native::UInt64) => get_whole::<u64>(calls, "fmi3GetUInt64", references, values),
            _ => calls.get("fmi3GetInt32", references, values),
        }
    }

    fn set(calls: &Calls, of: Native, references: &[u32], values: &[i32]) -> Result<()> {
        match (calls.fmi, of) {
            (Fmi::V2, _) => calls.set("fmi2SetInteger", references, values),
            (_, Native::Int8) => set_whole::<i8>(calls, "fmi3SetInt8", of, references, values),
            (_, Native::UInt8) => set_whole::<u8>(calls, "fmi3SetUInt8", of, references, values),
            (_, Native::Int16) => set_whole::<i16>(calls, "fmi3SetInt16", of, references, values),
            (_, Native::UInt16) => set_whole::<u16>(calls, "fmi3SetUInt16", of, references, values),
            (_, Native::UInt32) => set_whole::<u32>(calls, "fmi3SetUInt32", of, references, values),
            (_, Native::Int64) => set_whole::<i64>(calls, "fmi3SetInt64", of, references, values),
            (_, Native::UInt64) => set_whole::<u64>(calls, "fmi3SetUInt64", of, references, values),
            _ => calls.set("fmi3SetInt32", references, values),
        }
    }
}

impl Value for bool {
    fn get(calls: &Calls, _: Native, references: &[u32], values: &mut [bool]) -> Result<()> {
        // Not into `bool`: the FMU might write something else.
        match calls.fmi {
            Fmi::V2 => calls.get_as("fmi2GetBoolean", references, values, 0, |value: c_int| Ok(value != 0)),
            Fmi::V3 => calls.get_as("fmi3GetBoolean", references, values, 0, |value: u8| Ok(value != 0)),
        }
    }

    fn set(calls: &Calls, _: Native, references: &[u32], values: &[bool]) -> Result<()> {
        match calls.fmi {
            Fmi::V2 => {
                let values: Vec<c_int> = values.iter().map(|value| c_int::from(*value)).collect();
                calls.set("fmi2SetBoolean", references, &values)
            }
            Fmi::V3 => calls.set("fmi3SetBoolean", references, values),
        }
    }
}

impl Value for String {
    fn get(calls: &Calls, _: Native, references: &[u32], values: &mut [String]) -> Result<()> {
        let call = calls.name(["fmi2GetString", "fmi3GetString"]);
        calls.get_as(call, references, values, null(), |text: *const c_char| {
            // SAFETY: not NULL, so a text of the FMU's, which lives until its next call.
            let text = (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) });
            Ok(text.map(|text| text.to_string_lossy().into_owned()).unwrap_or_default())
        })
    }

    fn set(calls: &Calls, _: Native, references: &[u32], values: &[String]) -> Result<()> {
        let zero = |text: &String| format!("{text:?}: a text for an FMU holds no zero");
        let texts = values.iter().map(|text| c_text(text, || zero(text)));
        let texts = texts.collect::<Result<Vec<CString>>>()?;
        let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        calls.set(calls.name(["fmi2SetString", "fmi3SetString"]), references, &pointers)
    }
}
