//! Functions for both sample formats.

/// Generates a function for each sample type, because `multiversion` does not accept generic functions.
macro_rules! of_both_formats {
    ($($name:ident: $eight:ident, $sixteen:ident($($argument:ident: $type:ty),* $(,)?);)*) => {$(
        $crate::levels::both_formats::of_both_formats!(@one $name, $eight, i8, ($($argument: $type),*));
        $crate::levels::both_formats::of_both_formats!(@one $name, $sixteen, i16, ($($argument: $type),*));
    )*};
    (@one $name:ident, $own:ident, $texel:ty, ($($argument:ident: $type:ty),*)) => {
        #[multiversion::multiversion(targets(
            "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl",
            "x86_64+avx2"
        ))]
        pub(super) fn $own(sampler: &LevelSampler<'_, $texel>, $($argument: $type),*) {
            $name(sampler, $($argument),*);
        }
    };
}
pub(super) use of_both_formats;
