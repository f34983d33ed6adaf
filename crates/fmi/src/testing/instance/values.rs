//! Values of variables, read and set by an importer.

use super::{TestInstance, VersionFunctions};
use crate::Status;
use std::ffi::{CStr, CString};
use std::ptr::null;

impl TestInstance {
    /// `fmi2GetReal`, `fmi3GetFloat64`: so many values.
    pub fn get_real(&self, references: &[u32], length: usize) -> (Status, Vec<f64>) {
        let mut values = vec![f64::NAN; length];
        let to = self.or_null_mut(1, values.as_mut_ptr());
        (values!(self, fmi2GetReal / fmi3GetFloat64, references, to, length), values)
    }

    /// `fmi2SetReal`, `fmi3SetFloat64`
    pub fn set_real(&self, references: &[u32], values: &[f64]) -> Status {
        let from = self.or_null(1, values.as_ptr());
        values!(self, fmi2SetReal / fmi3SetFloat64, references, from, values.len())
    }

    /// `fmi2GetInteger`, `fmi3GetInt32`
    pub fn get_integer(&self, references: &[u32], length: usize) -> (Status, Vec<i32>) {
        let mut values = vec![i32::MIN; length];
        let to = self.or_null_mut(1, values.as_mut_ptr());
        (values!(self, fmi2GetInteger / fmi3GetInt32, references, to, length), values)
    }

    /// `fmi2SetInteger`, `fmi3SetInt32`
    pub fn set_integer(&self, references: &[u32], values: &[i32]) -> Status {
        let from = self.or_null(1, values.as_ptr());
        values!(self, fmi2SetInteger / fmi3SetInt32, references, from, values.len())
    }

    /// `fmi2GetBoolean`, `fmi3GetBoolean`: 0 or 1.
    pub fn get_boolean(&self, references: &[u32], length: usize) -> (Status, Vec<i32>) {
        let (mut integers, mut values) = (vec![i32::MIN; length], vec![false; length]);
        let (at, count) = (self.or_null(0, references.as_ptr()), references.len());
        // SAFETY: an instance, and arrays as long as said, or NULL.
        let status = match &self.functions {
            VersionFunctions::V2(c) => unsafe {
                assert_eq!(count, length);
                (c.fmi2GetBoolean)(self.raw, at, count, self.or_null_mut(1, integers.as_mut_ptr()))
            },
            VersionFunctions::V3(c) => unsafe {
                let to = self.or_null_mut(1, values.as_mut_ptr());
                let status = (c.fmi3GetBoolean)(self.raw, at, count, to, length);
                integers = values.into_iter().map(i32::from).collect();
                status
            },
        };
        (status, integers)
    }

    /// `fmi2SetBoolean`, `fmi3SetBoolean`: 0 or anything else.
    pub fn set_boolean(&self, references: &[u32], values: &[i32]) -> Status {
        let (at, count) = (self.or_null(0, references.as_ptr()), references.len());
        // SAFETY: an instance, and arrays as long as said, or NULL.
        match &self.functions {
            VersionFunctions::V2(c) => unsafe {
                assert_eq!(count, values.len());
                (c.fmi2SetBoolean)(self.raw, at, count, self.or_null(1, values.as_ptr()))
            },
            VersionFunctions::V3(c) => unsafe {
                let values: Vec<bool> = values.iter().map(|value| *value != 0).collect();
                (c.fmi3SetBoolean)(self.raw, at, count, self.or_null(1, values.as_ptr()), values.len())
            },
        }
    }

    /// `fmi2GetString`, `fmi3GetString`; no texts after a refusal.
    pub fn get_string(&self, references: &[u32], length: usize) -> (Status, Vec<CString>) {
        let mut values = vec![null(); length];
        let to = self.or_null_mut(1, values.as_mut_ptr());
        let status = values!(self, fmi2GetString / fmi3GetString, references, to, length);
        let texts = match status {
            // SAFETY: texts that live until the next call.
            Status::Ok => values.iter().map(|text| unsafe { CStr::from_ptr(*text) }.to_owned()).collect(),
            _ => Vec::new(),
        };
        (status, texts)
    }

    /// `fmi2SetString`, `fmi3SetString`
    pub fn set_string(&self, references: &[u32], values: &[Option<&CStr>]) -> Status {
        let pointers: Vec<_> = values.iter().map(|text| text.map_or(null(), CStr::as_ptr)).collect();
        let from = self.or_null(1, pointers.as_ptr());
        values!(self, fmi2SetString / fmi3SetString, references, from, pointers.len())
    }

    /// `fmi3GetUInt64`
    pub fn get_size(&self, references: &[u32], length: usize) -> (Status, Vec<u64>) {
        let mut values = vec![0; length];
        let (at, to) = (self.or_null(0, references.as_ptr()), self.or_null_mut(1, values.as_mut_ptr()));
        // SAFETY: an instance, and arrays as long as said, or NULL.
        let status = unsafe { (self.v3().fmi3GetUInt64)(self.raw, at, references.len(), to, length) };
        (status, values)
    }

    /// `fmi3SetUInt64`
    pub fn set_size(&self, references: &[u32], values: &[u64]) -> Status {
        let (at, from) = (self.or_null(0, references.as_ptr()), self.or_null(1, values.as_ptr()));
        // SAFETY: an instance, and arrays as long as said, or NULL.
        unsafe { (self.v3().fmi3SetUInt64)(self.raw, at, references.len(), from, values.len()) }
    }

    /// `fmi2GetRealOutputDerivatives`, `fmi3GetOutputDerivatives`
    pub fn output_derivatives(
        &self,
        references: &[u32],
        orders: &[i32],
        length: usize,
    ) -> (Status, Vec<f64>) {
        assert_eq!(references.len(), orders.len());
        let mut values = vec![1.0; length];
        let (at, of) = (self.or_null(0, references.as_ptr()), self.or_null(2, orders.as_ptr()));
        let (count, to) = (references.len(), self.or_null_mut(1, values.as_mut_ptr()));
        // SAFETY: an instance, and arrays as long as said, or NULL.
        let status = match &self.functions {
            VersionFunctions::V2(c) => unsafe {
                assert_eq!(count, length);
                (c.fmi2GetRealOutputDerivatives)(self.raw, at, count, of, to)
            },
            VersionFunctions::V3(c) => unsafe {
                (c.fmi3GetOutputDerivatives)(self.raw, at, count, of, to, length)
            },
        };
        (status, values)
    }

    /// `fmi2SetRealInputDerivatives`
    pub fn set_input_derivatives(&self, references: &[u32], orders: &[i32], values: &[f64]) -> Status {
        assert_eq!((references.len(), orders.len()), (values.len(), values.len()));
        let (at, of) = (self.or_null(0, references.as_ptr()), self.or_null(1, orders.as_ptr()));
        let (count, from) = (values.len(), self.or_null(2, values.as_ptr()));
        // SAFETY: an instance, and arrays as long as said, or NULL.
        unsafe { (self.v2().fmi2SetRealInputDerivatives)(self.raw, at, count, of, from) }
    }
}
