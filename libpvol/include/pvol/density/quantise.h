// Densities in fewer bits: a grid's samples as codes, what codes stand for, and the error.
//
// Biased: pictures of decoded samples differ from those of the samples, by an error that is
// measured and stated. The widths that vary by brick follow NanoVDB's FpN (Museth 2021), but step
// through the positive samples of a brick alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pvol/density/voxel_grid.h"
#include "pvol/math/keys.h"
#include "pvol/math/names.h"

namespace pvol {

/// What a sample is kept in. fp32: as it is. fp16: an IEEE half times a power of two that all
/// bricks share. fp8: 8 bits of a scale of its brick. fpn: as few of 1, 2, 4, 8 or 16 bits as keep
/// the brick's error below a tolerance.
enum class Precision { fp32, fp16, fp8, fpn };
[[nodiscard]] constexpr auto names(Precision) {
  return std::to_array<Named<Precision>>({
      {Precision::fp32, "fp32"},
      {Precision::fp16, "fp16"},
      {Precision::fp8, "fp8"},
      {Precision::fpn, "fpn"},
  });
}

/// Sixteen bits can keep any error above the smaller limit.
inline constexpr double kLeastTolerance = 1e-5, kLargestTolerance = 1;
inline constexpr Range kToleranceRange = Range::closed(kLeastTolerance, kLargestTolerance);

struct Quantisation {
  Precision precision = Precision::fp32;
  /// Of fpn: the largest error of a sample over the grid's largest sample. The default is NanoVDB's
  /// for fog in [0, 1].
  double tolerance = 0.01;
  friend bool operator==(const Quantisation&, const Quantisation&) = default;
};

/// Of a density that is to be rounded, or stays as it is stored.
template <std::same_as<std::optional<Quantisation>> Q>
[[nodiscard]] constexpr auto keys(const Q&) {
  return std::to_array<Key<Q>>({
      {{.key = "density",
        .metavar = "NAME",
        .limits = name_of<Precision>().or_word("stored"),
        .help = "Round the density as pvol-fit --density would; biased, it shows what such a file "
                "loses",
        .otherwise = "as stored",
        .effect = Effect::bias,
        .factor = "density",
        .sweep = "fp16 fp8 fpn"},
       [](const Q& q) { return q ? to_value(q->precision) : Value(); },
       [](Q& q, const Value& v) {
         const auto precision = find_named<Precision>(*v.word());
         q = precision ? Q(Quantisation{.precision = *precision}) : Q();
       }},
      {{.key = "density_tolerance",
        .metavar = "X",
        .limits = number(kToleranceRange),
        .help = "Largest error of a sample in fpn, relative to the largest sample",
        .effect = Effect::bias,
        .goes_with = "density",
        .of_value = "fpn"},
       [](const Q& q) {
         return q && q->precision == Precision::fpn ? Value(q->tolerance) : Value();
       },
       [](Q& q, const Value& v) {
         if (q) assign(q->tolerance, v);
       }},
  });
}

/// How far decoded samples are off.
struct QuantisationError {
  double absolute = 0;  ///< largest |decoded - exact| of a sample
  double relative = 0;  ///< largest |decoded - exact| / exact of a positive sample
  double mass = 0;      ///< sum of decoded - exact over sum of exact, over all samples
  friend bool operator==(const QuantisationError&, const QuantisationError&) = default;
};

/// A grid as codes. Tiles stay exact. The support is the grid's own: samples of 0 are 0, positive
/// ones stay positive; with fp8 and fpn none leaves the range of its brick's positive samples, and
/// the error is at most (hi - lo) / (2 n) and half an ulp (THEORY.md, T1.9).
struct QuantisedGrid {
  /// Of a brick with codes of fp8 or fpn: n + 1 codes stand for lo, hi and values at equal
  /// distances between, the c-th for lo + c * ((hi - lo) / n), computed in double and rounded to
  /// float. Where `zero` is set they are codes 1 to n + 1, and code 0 stands for 0.
  struct Scale {
    float lo = 0, hi = 0;   ///< 0 < lo <= hi
    std::uint8_t bits = 8;  ///< 1, 2, 4, 8 or 16
    bool zero = false;
    friend bool operator==(const Scale&, const Scale&) = default;
  };

  std::string name;
  Affine index_to_world;
  Quantisation how;
  QuantisationError error;
  int exponent = 0;            ///< of fp16: a code stands for half(code) * 2^exponent
  std::vector<Tile> tiles;     ///< by origin
  std::vector<Vec3i> origins;  ///< of bricks, in order; those of zeros are left out
  std::vector<Scale> scales;   ///< by brick; empty for fp16
  /// By brick: sample s has the bits from s * bits on, low bits and low bytes first.
  std::vector<std::uint8_t> codes;
};

/// Bytes that the codes of a brick take.
[[nodiscard]] constexpr std::size_t code_bytes(int bits) {
  return std::size_t(bits) * kBrickSamples / 8;
}

/// Codes for the samples, in parallel; the same for any number of threads and any order of the
/// grid's bricks. Throws Error for fp32 and for a tolerance out of range.
[[nodiscard]] QuantisedGrid quantise(const VoxelGrid& grid, const Quantisation& how);

/// What the codes stand for.
[[nodiscard]] VoxelGrid decode(const QuantisedGrid& grid);

/// Replaces the samples by what their codes stand for; fp32 leaves them alone.
QuantisationError quantise_in_place(VoxelGrid& grid, const Quantisation& how);

/// A half float times 2^exponent, rounded to float. The code is one of a finite number that is not
/// negative, below 7C00.
[[nodiscard]] float decode_half(std::uint16_t code, int exponent);

}  // namespace pvol
