// What the processor that the program runs on can do.
#pragma once

namespace pvol::detail {

/// The second level of x86-64, with the instructions for AES that its processors have had since
/// 2010. False elsewhere.
[[nodiscard]] bool has_sse4();

/// The third level of x86-64: AVX2, fused multiply-add, bit manipulation. False elsewhere.
[[nodiscard]] bool has_x86_64_v3();

/// That, and the parts of AVX-512 that processors have had since 2017.
[[nodiscard]] bool has_avx512();

/// The vectors of 64-bit ARM, with the instructions for AES: kernels are compiled for both.
[[nodiscard]] bool has_neon();

}  // namespace pvol::detail
