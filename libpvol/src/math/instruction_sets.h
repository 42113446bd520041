// For which instruction sets lanes are compiled: included before hwy/foreach_target.h by each
// source that is compiled once for each.

// No kernel is the compiler's default: which one runs is decided when the program does.
#define HWY_BASELINE_TARGETS HWY_BASELINE_SCALAR
#define HWY_COMPILE_ALL_ATTAINABLE
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
// Those that have lanes; the compiler's default has none.
#define PVOL_TARGETS_WITH_LANES (HWY_SSE4 | HWY_AVX2 | HWY_AVX3 | HWY_NEON)
#undef HWY_TARGET_INCLUDE
