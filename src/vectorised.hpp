// SPDX-License-Identifier: MIT
#pragma once

// One source, compiled for the plain instruction set and for AVX2; the machine chooses when the
// library is loaded. Both give the same bits. Sanitizers are not ready that early, and a build with
// HANDYAR_PLAIN is plain.
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(HANDYAR_PLAIN)
#define HANDYAR_VECTORISED [[gnu::target_clones("avx2", "default")]]
#else
#define HANDYAR_VECTORISED
#endif

// What a vectorised function calls must be compiled with it, in its instruction set.
#if defined(__GNUC__)
#define HANDYAR_ALWAYS_INLINE [[gnu::always_inline]] inline
#elif defined(_MSC_VER)
#define HANDYAR_ALWAYS_INLINE __forceinline
#else
#define HANDYAR_ALWAYS_INLINE inline
#endif

// Before a loop over the lanes of a few vectors: GCC would unroll it before it could vectorise it.
#if defined(__GNUC__) && !defined(__clang__)
#define HANDYAR_LANES _Pragma("GCC unroll 1")
#else
#define HANDYAR_LANES
#endif
