// The exact sums of a film as planes of whole numbers, as a part of an EXR keeps them.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pvol/render/film.h"

namespace pvol::formats::detail {

/// 32 bits of every pixel.
struct Plane {
  std::string name;  ///< of its channel
  std::function<std::uint32_t(const Film&, std::size_t pixel)> get;
  std::function<void(Film&, std::size_t pixel, std::uint32_t bits)> put;  ///< in their order
};

/// What of a film is kept beside its sums.
struct PlaneChoice {
  bool counts = false;  ///< of its pixels
  bool needs = false;   ///< the shares of its pixels
};

/// Planes of a film with these layers. Together they restore samples, sums, least values, counts
/// and needs to the bit.
[[nodiscard]] std::vector<Plane> planes_of(const std::vector<Layer>& layers, PlaneChoice choice);

/// Throws Error for sums that no terms have, as many as the pixel has samples.
void check_sums(const Film& film, std::size_t pixel);

}  // namespace pvol::formats::detail
