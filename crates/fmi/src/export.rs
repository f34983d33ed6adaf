//! What [`export_fmi2!`](crate::export_fmi2) and [`export_fmi3!`](crate::export_fmi3) share.

/// Defines the C functions of a list that `fmi2_functions!` or `fmi3_functions!` gives.
#[doc(hidden)]
#[macro_export]
macro_rules! export_functions {
    ($version:ident $model:path; $($name:ident = $body:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?;)*) => {
        $(
            #[doc = concat!("`", stringify!($name), "`")]
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name($($argument: $type),*) $(-> $result)? {
                // SAFETY: the importer keeps FMI's contract, which is the body's.
                unsafe { $crate::$version::component::$body::<$model>($($argument),*) }
            }
        )*
    };
}
