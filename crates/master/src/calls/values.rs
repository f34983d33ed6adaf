//! The values that an FMU is asked for or given: numbers and texts.

use super::{Calls, c_text};
use crate::error::{Error, Result};
use crate::ssp::{Affine, Fmi, Type};
use std::ffi::{CStr, CString, c_char, c_int};
use std::fmt::Display;
use std::ptr::null;

/// Values: numbers of any type (integers as an `i32` has them, Booleans 0 or 1), or texts.
pub trait Value: Clone + Default + PartialEq + 'static {
    /// Reads all values of variables of a type; leaves them as they are if the FMU refuses.
    ///
    /// # Errors
    /// The FMU lacks the function, or has a value that is none of this type.
    fn get(calls: &Calls, of: Type, references: &[u32], values: &mut [Self]) -> Result<()>;

    /// Sets all values of variables of a type.
    ///
    /// # Errors
    /// The FMU lacks the function, or a value is none of the variables' type.
    fn set(calls: &Calls, of: Type, references: &[u32], values: &[Self]) -> Result<()>;

    /// Returns the value in the unit of the input to which it is sent; only Reals have units.
    fn converted(&self, _: Affine) -> Self {
        self.clone()
    }
}

/// A number as the FMU has it, if that is no double.
trait Number: Copy + Default + Display {
    /// Returns its value, if it is not too large.
    fn value(self) -> Option<f64>;

    /// Returns the number with a value, if there is one.
    fn of(value: f64) -> Option<Self>;
}

impl Number for f32 {
    fn value(self) -> Option<f64> {
        Some(f64::from(self))
    }

    fn of(value: f64) -> Option<f32> {
        Some(value as f32)
    }
}

macro_rules! whole_numbers {
    ($($of:ty)*) => {$(
        impl Number for $of {
            fn value(self) -> Option<f64> {
                i32::try_from(self).ok().map(f64::from)
            }

            fn of(value: f64) -> Option<$of> {
                let whole = value as i64;
                if whole as f64 == value { whole.try_into().ok() } else { None }
            }
        }
    )*};
}

whole_numbers! { i8 u8 i16 u16 i32 u32 i64 u64 }

/// Calls a function with the type in C of the numbers of variables, if that is no double.
macro_rules! with_number {
    ($function:ident($calls:ident, $of:ident, $($argument:ident),*)) => {
        match ($of, $calls.fmi) {
            (Type::Float32, _) => $function::<f32>($calls, $of, $($argument),*),
            (Type::Boolean | Type::Enumeration, Fmi::V2) => $function::<c_int>($calls, $of, $($argument),*),
            // Not `bool`: the FMU might write something else.
            (Type::Boolean | Type::UInt8, _) => $function::<u8>($calls, $of, $($argument),*),
            (Type::Int8, _) => $function::<i8>($calls, $of, $($argument),*),
            (Type::Int16, _) => $function::<i16>($calls, $of, $($argument),*),
            (Type::UInt16, _) => $function::<u16>($calls, $of, $($argument),*),
            (Type::UInt32, _) => $function::<u32>($calls, $of, $($argument),*),
            (Type::Int64 | Type::Enumeration, _) => $function::<i64>($calls, $of, $($argument),*),
            (Type::UInt64, _) => $function::<u64>($calls, $of, $($argument),*),
            _ => $function::<i32>($calls, $of, $($argument),*),
        }
    };
}

fn get_numbers<N: Number>(calls: &Calls, of: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
    let (call, mut read) = (calls.accessor("Get", of), vec![N::default(); values.len()]);
    calls.get(&call, references, &mut read)?;
    for (value, read) in values.iter_mut().zip(read) {
        let large = || Error::new(format!("{call}: {read} is not a value of Int32, to which it is read"));
        *value = read.value().ok_or_else(large)?;
        if of == Type::Boolean {
            *value = f64::from(*value != 0.0);
        }
    }
    Ok(())
}

fn set_numbers<N: Number>(calls: &Calls, of: Type, references: &[u32], values: &[f64]) -> Result<()> {
    let call = calls.accessor("Set", of);
    let none = |value: f64| Error::new(format!("{call}: {value} is not a value of {}", of.name()));
    let numbers = values.iter().map(|value| N::of(*value).ok_or_else(|| none(*value)));
    calls.set(&call, references, &numbers.collect::<Result<Vec<N>>>()?)
}

impl Value for f64 {
    fn get(calls: &Calls, of: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        match of {
            Type::Real | Type::Float64 => calls.get(&calls.accessor("Get", of), references, values),
            _ => with_number!(get_numbers(calls, of, references, values)),
        }
    }

    fn set(calls: &Calls, of: Type, references: &[u32], values: &[f64]) -> Result<()> {
        match of {
            Type::Real | Type::Float64 => calls.set(&calls.accessor("Set", of), references, values),
            _ => with_number!(set_numbers(calls, of, references, values)),
        }
    }

    fn converted(&self, map: Affine) -> f64 {
        map.apply(*self)
    }
}

impl Value for String {
    fn get(calls: &Calls, of: Type, references: &[u32], values: &mut [String]) -> Result<()> {
        let mut read = vec![null::<c_char>(); values.len()];
        calls.get(&calls.accessor("Get", of), references, &mut read)?;
        for (value, text) in values.iter_mut().zip(read) {
            // SAFETY: not NULL, so a text of the FMU's, which lives until its next call.
            let text = (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) });
            *value = text.map(|text| text.to_string_lossy().into_owned()).unwrap_or_default();
        }
        Ok(())
    }

    fn set(calls: &Calls, of: Type, references: &[u32], values: &[String]) -> Result<()> {
        let zero = |text: &String| format!("{text:?}: a text for an FMU holds no zero");
        let texts = values.iter().map(|text| c_text(text, || zero(text)));
        let texts = texts.collect::<Result<Vec<CString>>>()?;
        let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        calls.set(&calls.accessor("Set", of), references, &pointers)
    }
}
