//! The C functions of FMI 3.0.

use super::v2::{Heard, Listener};
use super::{Answer, CallError, Calls, Named, Plain, Result, c_text, functions, there};
use lemons_fmi::Status;
use lemons_ssp::Native;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{MAIN_SEPARATOR, Path};
use std::ptr::null;

type Get<T> = unsafe extern "C" fn(*mut c_void, *const u32, usize, *mut T, usize) -> c_int;
type Set<T> = unsafe extern "C" fn(*mut c_void, *const u32, usize, *const T, usize) -> c_int;
type Logger = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);
type DoStep = unsafe extern "C" fn(*mut c_void, f64, f64, bool, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int;

functions! {
    required {
        make: unsafe extern "C" fn(
            *const c_char, *const c_char, *const c_char, bool, bool, bool, bool, *const u32, usize,
            *mut c_void, Option<Logger>, *const c_void
        ) -> *mut c_void = "fmi3InstantiateCoSimulation";
        free_instance: unsafe extern "C" fn(*mut c_void) = "fmi3FreeInstance";
        begin_initialization: unsafe extern "C" fn(*mut c_void, bool, f64, f64, bool, f64) -> c_int
            = "fmi3EnterInitializationMode";
        exit_initialization: Plain = "fmi3ExitInitializationMode";
        terminate: Plain = "fmi3Terminate";
        reset: Plain = "fmi3Reset";
        step: DoStep = "fmi3DoStep";
    }
    optional {
        enter_configuration: Plain = "fmi3EnterConfigurationMode";
        exit_configuration: Plain = "fmi3ExitConfigurationMode";
        get_float64: Get<f64> = "fmi3GetFloat64";
        get_float32: Get<f32> = "fmi3GetFloat32";
        get_int8: Get<i8> = "fmi3GetInt8";
        get_uint8: Get<u8> = "fmi3GetUInt8";
        get_int16: Get<i16> = "fmi3GetInt16";
        get_uint16: Get<u16> = "fmi3GetUInt16";
        get_int32: Get<i32> = "fmi3GetInt32";
        get_uint32: Get<u32> = "fmi3GetUInt32";
        get_int64: Get<i64> = "fmi3GetInt64";
        get_uint64: Get<u64> = "fmi3GetUInt64";
        get_boolean: Get<u8> = "fmi3GetBoolean";
        get_string: Get<*const c_char> = "fmi3GetString";
        set_float64: Set<f64> = "fmi3SetFloat64";
        set_float32: Set<f32> = "fmi3SetFloat32";
        set_int8: Set<i8> = "fmi3SetInt8";
        set_uint8: Set<u8> = "fmi3SetUInt8";
        set_int16: Set<i16> = "fmi3SetInt16";
        set_uint16: Set<u16> = "fmi3SetUInt16";
        set_int32: Set<i32> = "fmi3SetInt32";
        set_uint32: Set<u32> = "fmi3SetUInt32";
        set_int64: Set<i64> = "fmi3SetInt64";
        set_uint64: Set<u64> = "fmi3SetUInt64";
        set_boolean: Set<u8> = "fmi3SetBoolean";
        set_string: Set<*const c_char> = "fmi3SetString";
    }
}

/// `fmi3LogMessageCallback`: a message is a text, without arguments.
///
/// # Safety
/// The environment is a listener that lives, the message ends in a zero.
unsafe extern "C" fn log(environment: *mut c_void, status: c_int, _: *const c_char, message: *const c_char) {
    if environment.is_null() || message.is_null() {
        return;
    }
    // SAFETY: as said above, and not NULL.
    let (listener, text) = unsafe { (&*environment.cast::<Listener>(), CStr::from_ptr(message)) };
    let status = Answer { code: status, call: "fmi3LogMessageCallback" }.status();
    let text = text.to_bytes();
    (listener.hears)(status, &String::from_utf8_lossy(&text[..text.len().min(LONGEST)]));
}

/// \[byte\] Of a message; the rest is cut off.
const LONGEST: usize = 1_000_000;

/// All values of the variables.
fn get<T>(
    calls: &Calls,
    function: Named<Option<Get<T>>>,
    references: &[u32],
    values: &mut [T],
) -> Result<Answer> {
    let (function, call) = there(function)?;
    let component = calls.component.as_ptr();
    // SAFETY: an instance of this library; both arrays are as long as said.
    let code = unsafe {
        function(component, references.as_ptr(), references.len(), values.as_mut_ptr(), values.len())
    };
    Ok(Answer { code, call })
}

/// All values of the variables.
fn set<T>(
    calls: &Calls,
    function: Named<Option<Set<T>>>,
    references: &[u32],
    values: &[T],
) -> Result<Answer> {
    let (function, call) = there(function)?;
    let component = calls.component.as_ptr();
    // SAFETY: an instance of this library; both arrays are as long as said.
    let code =
        unsafe { function(component, references.as_ptr(), references.len(), values.as_ptr(), values.len()) };
    Ok(Answer { code, call })
}

/// Through a buffer of another type. What the FMU has not written is not looked at.
fn get_whole<T: Copy + Default + Into<i128>>(
    calls: &Calls,
    function: Named<Option<Get<T>>>,
    references: &[u32],
    values: &mut [i32],
) -> Result<Answer> {
    let mut buffer = vec![T::default(); values.len()];
    let answer = get(calls, function, references, &mut buffer)?;
    if matches!(answer.status(), Some(Status::Ok | Status::Warning)) {
        for (value, read) in values.iter_mut().zip(buffer) {
            let read: i128 = read.into();
            let range =
                |_| CallError::Range { call: function.1, value: read, of: "Int32, to which it is read" };
            *value = i32::try_from(read).map_err(range)?;
        }
    }
    Ok(answer)
}

fn set_whole<T: TryFrom<i32>>(
    calls: &Calls,
    function: Named<Option<Set<T>>>,
    references: &[u32],
    values: &[i32],
    of: Native,
) -> Result<Answer> {
    let number = |value: &i32| {
        let range = |_| CallError::Range { call: function.1, value: i128::from(*value), of: of.name() };
        T::try_from(*value).map_err(range)
    };
    let buffer = values.iter().map(number).collect::<Result<Vec<T>>>()?;
    set(calls, function, references, &buffer)
}

impl Functions {
    /// A pointer to the instance or NULL, and the name of the function.
    pub(super) fn instantiate(
        &self,
        name: &CStr,
        token: &CStr,
        resources: Option<&CStr>,
        heard: &Heard,
    ) -> (*mut c_void, &'static str) {
        let (function, call) = self.make;
        let resources = resources.map_or(null(), CStr::as_ptr);
        // SAFETY: FMI's arguments; the environment lives as long as the instance.
        let component = unsafe {
            function(
                name.as_ptr(),
                token.as_ptr(),
                resources,
                false,
                // Else an FMU tells no warnings; what it tells with the status `fmi3OK` is not kept.
                true,
                // Without Event Mode, early return and intermediate updates.
                false,
                false,
                null(),
                0,
                heard.environment(),
                Some(log),
                null(),
            )
        };
        (component, call)
    }

    pub(super) fn enter_initialization(&self, calls: &Calls, start: f64, tolerance: Option<f64>) -> Answer {
        let (function, call) = self.begin_initialization;
        let (defined, tolerance) = (tolerance.is_some(), tolerance.unwrap_or(0.0));
        // SAFETY: an instance of this library.
        let code = unsafe { function(calls.component.as_ptr(), defined, tolerance, start, false, 0.0) };
        Answer { code, call }
    }

    pub(super) fn get_real(
        &self,
        calls: &Calls,
        of: Native,
        references: &[u32],
        values: &mut [f64],
    ) -> Result<Answer> {
        if of != Native::Float32 {
            return get(calls, self.get_float64, references, values);
        }
        let mut buffer = vec![0.0; values.len()];
        let answer = get(calls, self.get_float32, references, &mut buffer)?;
        values.iter_mut().zip(buffer).for_each(|(value, read)| *value = f64::from(read));
        Ok(answer)
    }

    pub(super) fn set_real(
        &self,
        calls: &Calls,
        of: Native,
        references: &[u32],
        values: &[f64],
    ) -> Result<Answer> {
        if of != Native::Float32 {
            return set(calls, self.set_float64, references, values);
        }
        let buffer: Vec<f32> = values.iter().map(|value| *value as f32).collect();
        set(calls, self.set_float32, references, &buffer)
    }

    pub(super) fn get_integer(
        &self,
        calls: &Calls,
        of: Native,
        references: &[u32],
        values: &mut [i32],
    ) -> Result<Answer> {
        match of {
            Native::Int8 => get_whole(calls, self.get_int8, references, values),
            Native::UInt8 => get_whole(calls, self.get_uint8, references, values),
            Native::Int16 => get_whole(calls, self.get_int16, references, values),
            Native::UInt16 => get_whole(calls, self.get_uint16, references, values),
            Native::UInt32 => get_whole(calls, self.get_uint32, references, values),
            Native::Int64 => get_whole(calls, self.get_int64, references, values),
            Native::UInt64 => get_whole(calls, self.get_uint64, references, values),
            _ => get(calls, self.get_int32, references, values),
        }
    }

    pub(super) fn set_integer(
        &self,
        calls: &Calls,
        of: Native,
        references: &[u32],
        values: &[i32],
    ) -> Result<Answer> {
        match of {
            Native::Int8 => set_whole(calls, self.set_int8, references, values, of),
            Native::UInt8 => set_whole(calls, self.set_uint8, references, values, of),
            Native::Int16 => set_whole(calls, self.set_int16, references, values, of),
            Native::UInt16 => set_whole(calls, self.set_uint16, references, values, of),
            Native::UInt32 => set_whole(calls, self.set_uint32, references, values, of),
            Native::Int64 => {
                let buffer: Vec<i64> = values.iter().map(|value| i64::from(*value)).collect();
                set(calls, self.set_int64, references, &buffer)
            }
            Native::UInt64 => set_whole(calls, self.set_uint64, references, values, of),
            _ => set(calls, self.set_int32, references, values),
        }
    }

    pub(super) fn get_boolean(
        &self,
        calls: &Calls,
        references: &[u32],
        values: &mut [i32],
    ) -> Result<Answer> {
        // Not `bool`: the FMU might write something else.
        let mut buffer = vec![0; values.len()];
        let answer = get(calls, self.get_boolean, references, &mut buffer)?;
        values.iter_mut().zip(buffer).for_each(|(value, read)| *value = i32::from(read != 0));
        Ok(answer)
    }

    pub(super) fn set_boolean(&self, calls: &Calls, references: &[u32], values: &[i32]) -> Result<Answer> {
        let buffer: Vec<u8> = values.iter().map(|value| u8::from(*value != 0)).collect();
        set(calls, self.set_boolean, references, &buffer)
    }

    pub(super) fn get_string(
        &self,
        calls: &Calls,
        references: &[u32],
        values: &mut [*const c_char],
    ) -> Result<Answer> {
        get(calls, self.get_string, references, values)
    }

    pub(super) fn set_string(
        &self,
        calls: &Calls,
        references: &[u32],
        values: &[*const c_char],
    ) -> Result<Answer> {
        set(calls, self.set_string, references, values)
    }

    /// Sets structural parameters in Configuration Mode.
    pub(super) fn configure(&self, calls: &Calls, references: &[u32], sizes: &[u64]) -> Result<Answer> {
        let answer = calls.plain(there(self.enter_configuration)?);
        if answer.status() != Some(Status::Ok) {
            return Ok(answer);
        }
        let answer = set(calls, self.set_uint64, references, sizes)?;
        if answer.status() != Some(Status::Ok) {
            return Ok(answer);
        }
        Ok(calls.plain(there(self.exit_configuration)?))
    }

    pub(super) fn do_step(&self, calls: &Calls, time: f64, step: f64) -> Result<Answer> {
        let (function, call) = self.step;
        let (mut event, mut end, mut early, mut last) = (0, 0, 0, f64::NAN);
        // SAFETY: an instance of this library; it is told where all four go.
        let code = unsafe {
            function(
                calls.component.as_ptr(),
                time,
                step,
                true,
                &raw mut event,
                &raw mut end,
                &raw mut early,
                &raw mut last,
            )
        };
        let answer = Answer { code, call };
        if matches!(answer.status(), Some(Status::Ok | Status::Warning)) {
            let ended = |why: String| Err(CallError::Ended { call, why });
            if end != 0 {
                return ended(format!(
                    "the FMU ends the simulation at t = {last:?} s, within the step from {time:?} s over {step:?} s"
                ));
            }
            if event != 0 {
                return ended(format!(
                    "the FMU wants Event Mode at t = {last:?} s, which this master has not"
                ));
            }
            if early != 0 {
                return ended(format!(
                    "the FMU has returned at t = {last:?} s, within the step from {time:?} s over {step:?} s"
                ));
            }
        }
        Ok(answer)
    }
}

/// The directory, with a separator at its end, as FMI 3.0 wants it.
pub(super) fn path(directory: &Path) -> Result<CString> {
    let unknown = |source| CallError::Resources { path: directory.to_owned(), source };
    let path = std::path::absolute(directory).map_err(unknown)?;
    let text = path.to_str().ok_or_else(|| unknown(std::io::ErrorKind::InvalidFilename.into()))?;
    let text = format!("{}{MAIN_SEPARATOR}", text.trim_end_matches(MAIN_SEPARATOR));
    c_text(&text, || text.clone())
}
