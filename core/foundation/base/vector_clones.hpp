#pragma once
/// Before a kernel: it is compiled once for each kind of vector unit and the machine's is picked when the program starts. The
/// bits are the same from each (no fused multiply-add). Sanitizers cannot run before the resolvers that pick a clone.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define KLANG_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define KLANG_CLONES
#endif
