//! Functions for both sample formats.

/// Generates a function for each sample type of a sampler, because `multiversion` does not accept generic functions.
macro_rules! of_both_formats {
    ($sampler:ident; $($name:ident: $eight:ident, $sixteen:ident($($argument:ident: $type:ty),* $(,)?);)*) => {$(
        $crate::both_formats::of_both_formats!(@one $sampler, $name, $eight, i8, ($($argument: $type),*));
        $crate::both_formats::of_both_formats!(@one $sampler, $name, $sixteen, i16, ($($argument: $type),*));
    )*};
    (@one $sampler:ident, $name:ident, $function:ident, $texel:ty, ($($argument:ident: $type:ty),*)) => {
        #[multiversion::multiversion(targets(
            "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl",
            "x86_64+avx2"
        ))]
        pub(super) fn $function(sampler: &$sampler<'_, $texel>, $($argument: $type),*) {
            $name(sampler, $($argument),*);
        }
    };
}
pub(crate) use of_both_formats;
