// LATELIGHT_VECTOR_CLONES before a function also compiles it for wide vectors; the loader selects the version for the
// processor. The clones compute the same bits: -ffp-contract=off, and no sum is reordered.
#pragma once

// Sanitizers instrument the function that picks the version, which runs before they are ready.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define LATELIGHT_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define LATELIGHT_VECTOR_CLONES
#endif
