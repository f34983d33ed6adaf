//! What [`export_fmi2!`](crate::export_fmi2) and [`export_fmi3!`](crate::export_fmi3) share.

/// Defines the C functions of a list that `fmi2_functions!` or `fmi3_functions!` gives.
#[doc(hidden)]
#[macro_export]
macro_rules! export_functions {
    (
        $model:path;
        $($name:ident = $module:ident::$body:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?;)*
        $([not offered] $($other:ident(instance: $instance:ty $(, $unused:ident: $unused_type:ty)*);)*)?
    ) => {
        $(
            #[doc = concat!("`", stringify!($name), "`")]
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name($($argument: $type),*) $(-> $result)? {
                // SAFETY: the importer keeps FMI's contract, which is the body's.
                unsafe { $crate::$module::$body::<$model>(stringify!($name), $($argument),*) }
            }
        )*
        $($(
            #[doc = concat!("`", stringify!($other), "`: not offered.")]
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $other(instance: $instance $(, $unused: $unused_type)*) -> Status {
                $(let _ = $unused;)*
                // SAFETY: the importer keeps FMI's contract, which is the body's.
                unsafe { $crate::v3::not_offered::<$model>(stringify!($other), instance) }
            }
        )*)?
    };
}
