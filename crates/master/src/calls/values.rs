//! The values that an FMU is asked for or given: numbers and texts.

use super::{FmuInstance, c_text};
use crate::error::Result;
use crate::ssp::{Affine, FmiType};
use lemons_fmi::Version;
use std::ffi::{CStr, CString, c_char, c_int};
use std::fmt::Display;
use std::ptr::null;

/// Values: numbers of any type (integers as an `i32` has them, Booleans 0 or 1), or texts.
pub trait FmiValue: Clone + Default + PartialEq + 'static {
    /// Reads all values of variables of a type: so many.
    ///
    /// # Errors
    /// The FMU lacks the function, refuses it, or has a value that is none of this type.
    fn get(instance: &FmuInstance, of: FmiType, references: &[u32], count: usize) -> Result<Vec<Self>>;

    /// Sets all values of variables of a type.
    ///
    /// # Errors
    /// The FMU lacks the function, refuses it, or a value is none of the variables' type.
    fn set(instance: &FmuInstance, of: FmiType, references: &[u32], values: &[Self]) -> Result<()>;

    /// Returns the value in the unit of the input to which it is sent; only Reals have units.
    fn converted(&self, _: Affine) -> Self {
        self.clone()
    }
}

/// Calls a function with the type in C of the whole numbers of variables.
macro_rules! with_whole_number {
    ($function:ident($instance:ident, $of:ident, $($argument:ident),*)) => {
        match ($of, $instance.version()) {
            (FmiType::Boolean | FmiType::Enumeration, Version::V2) => {
                $function::<c_int>($instance, $of, $($argument),*)
            }
            // Not `bool`: the FMU might write something else.
            (FmiType::Boolean | FmiType::UInt8, _) => $function::<u8>($instance, $of, $($argument),*),
            (FmiType::Int8, _) => $function::<i8>($instance, $of, $($argument),*),
            (FmiType::Int16, _) => $function::<i16>($instance, $of, $($argument),*),
            (FmiType::UInt16, _) => $function::<u16>($instance, $of, $($argument),*),
            (FmiType::UInt32, _) => $function::<u32>($instance, $of, $($argument),*),
            (FmiType::Int64 | FmiType::Enumeration, _) => $function::<i64>($instance, $of, $($argument),*),
            (FmiType::UInt64, _) => $function::<u64>($instance, $of, $($argument),*),
            _ => $function::<i32>($instance, $of, $($argument),*),
        }
    };
}

fn get_whole<N>(instance: &FmuInstance, of: FmiType, references: &[u32], count: usize) -> Result<Vec<f64>>
where
    N: Copy + Default + Display + TryInto<i32>,
{
    let value = |read: N| {
        let value: i32 = read.try_into().map_err(|_| {
            let call = instance.accessor("Get", of);
            format!("{call}: {read} is not a value of Int32, to which it is read")
        })?;
        Ok(if of == FmiType::Boolean { f64::from(value != 0) } else { f64::from(value) })
    };
    instance.get_all(of, references, vec![N::default(); count])?.into_iter().map(value).collect()
}

fn set_whole<N: TryFrom<i64>>(
    instance: &FmuInstance,
    of: FmiType,
    references: &[u32],
    values: &[f64],
) -> Result<()> {
    let number = |&value: &f64| {
        let whole = N::try_from(value as i64).ok().filter(|_| value as i64 as f64 == value);
        let none = || format!("{}: {value} is not a value of {of}", instance.accessor("Set", of));
        Ok(whole.ok_or_else(none)?)
    };
    instance.set_all(of, references, &values.iter().map(number).collect::<Result<Vec<N>>>()?)
}

impl FmiValue for f64 {
    fn get(instance: &FmuInstance, of: FmiType, references: &[u32], count: usize) -> Result<Vec<f64>> {
        match of {
            FmiType::Real | FmiType::Float64 => instance.get_all(of, references, vec![0.0; count]),
            FmiType::Float32 => {
                let read = instance.get_all(of, references, vec![0_f32; count])?;
                Ok(read.into_iter().map(f64::from).collect())
            }
            _ => with_whole_number!(get_whole(instance, of, references, count)),
        }
    }

    fn set(instance: &FmuInstance, of: FmiType, references: &[u32], values: &[f64]) -> Result<()> {
        match of {
            FmiType::Real | FmiType::Float64 => instance.set_all(of, references, values),
            FmiType::Float32 => {
                let single: Vec<f32> = values.iter().map(|value| *value as f32).collect();
                instance.set_all(of, references, &single)
            }
            _ => with_whole_number!(set_whole(instance, of, references, values)),
        }
    }

    fn converted(&self, map: Affine) -> f64 {
        map.apply(*self)
    }
}

impl FmiValue for String {
    fn get(instance: &FmuInstance, of: FmiType, references: &[u32], count: usize) -> Result<Vec<String>> {
        let text = |text: *const c_char| {
            // SAFETY: not NULL, so a text of the FMU's, which lives until its next call.
            let text = (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) });
            text.map(|text| text.to_string_lossy().into_owned()).unwrap_or_default()
        };
        Ok(instance.get_all(of, references, vec![null(); count])?.into_iter().map(text).collect())
    }

    fn set(instance: &FmuInstance, of: FmiType, references: &[u32], values: &[String]) -> Result<()> {
        let zero = |text: &String| format!("{text:?}: a text for an FMU holds no zero");
        let texts = values.iter().map(|text| c_text(text, || zero(text)));
        let texts = texts.collect::<Result<Vec<CString>>>()?;
        let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        instance.set_all(of, references, &pointers)
    }
}
