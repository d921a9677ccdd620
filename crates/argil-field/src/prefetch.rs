/// Asks the processor to fetch the words of a slice from `at` on, if possible. The parameters of many brushes
/// exceed the caches, and each is used once per program. Any `at` is allowed.
#[inline(always)]
pub(crate) fn prefetch(words: &[f32], at: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let first = words.as_ptr().wrapping_add(at).cast::<i8>();
        // SAFETY: every x86-64 has SSE; a prefetch reads nothing and never faults, whatever the address.
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(first);
            // A brush takes two cache lines.
            _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(64));
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (words, at);
}
