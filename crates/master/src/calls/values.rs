//! The values that an FMU is asked for or given: numbers and texts.

use super::{Instance, c_text};
use crate::error::{Error, Result};
use crate::ssp::{Affine, Type};
use lemons_fmi::Version;
use std::ffi::{CStr, CString, c_char, c_int};
use std::fmt::Display;
use std::ptr::null;

/// Values: numbers of any type (integers as an `i32` has them, Booleans 0 or 1), or texts.
pub trait Value: Clone + Default + PartialEq + 'static {
    /// Reads all values of variables of a type: so many.
    ///
    /// # Errors
    /// The FMU lacks the function, refuses it, or has a value that is none of this type.
    fn get(instance: &Instance, of: Type, references: &[u32], count: usize) -> Result<Vec<Self>>;

    /// Sets all values of variables of a type.
    ///
    /// # Errors
    /// The FMU lacks the function, refuses it, or a value is none of the variables' type.
    fn set(instance: &Instance, of: Type, references: &[u32], values: &[Self]) -> Result<()>;

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
    ($function:ident($instance:ident, $of:ident, $($argument:ident),*)) => {
        match ($of, $instance.version()) {
            (Type::Float32, _) => $function::<f32>($instance, $of, $($argument),*),
            (Type::Boolean | Type::Enumeration, Version::V2) => {
                $function::<c_int>($instance, $of, $($argument),*)
            }
            // Not `bool`: the FMU might write something else.
            (Type::Boolean | Type::UInt8, _) => $function::<u8>($instance, $of, $($argument),*),
            (Type::Int8, _) => $function::<i8>($instance, $of, $($argument),*),
            (Type::Int16, _) => $function::<i16>($instance, $of, $($argument),*),
            (Type::UInt16, _) => $function::<u16>($instance, $of, $($argument),*),
            (Type::UInt32, _) => $function::<u32>($instance, $of, $($argument),*),
            (Type::Int64 | Type::Enumeration, _) => $function::<i64>($instance, $of, $($argument),*),
            (Type::UInt64, _) => $function::<u64>($instance, $of, $($argument),*),
            _ => $function::<i32>($instance, $of, $($argument),*),
        }
    };
}

fn get_numbers<N: Number>(
    instance: &Instance,
    of: Type,
    references: &[u32],
    count: usize,
) -> Result<Vec<f64>> {
    let (call, mut read) = (instance.accessor("Get", of), vec![N::default(); count]);
    instance.get_all(&call, references, &mut read)?;
    let value = |read: N| {
        let value = read.value().ok_or_else(|| {
            Error::new(format!("{call}: {read} is not a value of Int32, to which it is read"))
        })?;
        Ok(if of == Type::Boolean { f64::from(value != 0.0) } else { value })
    };
    read.into_iter().map(value).collect()
}

fn set_numbers<N: Number>(instance: &Instance, of: Type, references: &[u32], values: &[f64]) -> Result<()> {
    let call = instance.accessor("Set", of);
    let none = |value: f64| Error::new(format!("{call}: {value} is not a value of {of}"));
    let numbers = values.iter().map(|value| N::of(*value).ok_or_else(|| none(*value)));
    instance.set_all(&call, references, &numbers.collect::<Result<Vec<N>>>()?)
}

impl Value for f64 {
    fn get(instance: &Instance, of: Type, references: &[u32], count: usize) -> Result<Vec<f64>> {
        if !matches!(of, Type::Real | Type::Float64) {
            return with_number!(get_numbers(instance, of, references, count));
        }
        let mut values = vec![0.0; count];
        instance.get_all(&instance.accessor("Get", of), references, &mut values)?;
        Ok(values)
    }

    fn set(instance: &Instance, of: Type, references: &[u32], values: &[f64]) -> Result<()> {
        if !matches!(of, Type::Real | Type::Float64) {
            return with_number!(set_numbers(instance, of, references, values));
        }
        instance.set_all(&instance.accessor("Set", of), references, values)
    }

    fn converted(&self, map: Affine) -> f64 {
        map.apply(*self)
    }
}

impl Value for String {
    fn get(instance: &Instance, of: Type, references: &[u32], count: usize) -> Result<Vec<String>> {
        let mut read = vec![null::<c_char>(); count];
        instance.get_all(&instance.accessor("Get", of), references, &mut read)?;
        let text = |text: *const c_char| {
            // SAFETY: not NULL, so a text of the FMU's, which lives until its next call.
            let text = (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) });
            text.map(|text| text.to_string_lossy().into_owned()).unwrap_or_default()
        };
        Ok(read.into_iter().map(text).collect())
    }

    fn set(instance: &Instance, of: Type, references: &[u32], values: &[String]) -> Result<()> {
        let zero = |text: &String| format!("{text:?}: a text for an FMU holds no zero");
        let texts = values.iter().map(|text| c_text(text, || zero(text)));
        let texts = texts.collect::<Result<Vec<CString>>>()?;
        let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        instance.set_all(&instance.accessor("Set", of), references, &pointers)
    }
}
