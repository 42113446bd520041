// The exact sums of a film as planes of whole numbers, as a part of an EXR keeps them.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pvol/render/film.h"

namespace pvol::formats::detail {

/// What is kept of a pixel.
struct PixelRecord {
  std::uint32_t samples = 0, group_samples = 0;
  ExactSums sums{};
  std::vector<Vec3d> least{};  ///< of each layer; those that have sums leave it as it is
  PixelCounts counts{};
  float share = 0;  ///< of its needs
};

/// 32 bits of every pixel.
struct Plane {
  std::string name;  ///< of its channel
  std::function<std::uint32_t(const PixelRecord&)> get;
  std::function<void(PixelRecord&, std::uint32_t bits)> put;  ///< in their order
};

/// What of a film is kept beside its sums.
struct PlaneChoice {
  bool counts = false;  ///< of its pixels
  bool needs = false;   ///< the shares of its pixels
};

/// Planes of a film with these layers. Together they restore samples, sums, least values, counts
/// and needs to the bit.
[[nodiscard]] std::vector<Plane> planes_of(const std::vector<Layer>& layers, PlaneChoice choice);

/// An empty record of a film with these layers.
[[nodiscard]] PixelRecord empty_record(const std::vector<Layer>& layers);

/// What a film with exact sums has of a pixel; the record's memory is used again.
void load(const Film& film, std::size_t pixel, PixelRecord& to);

/// Sets what a film with exact sums has of a pixel, and its counts and needs where it has any.
/// Throws Error for sums that no terms have, as many as the pixel has samples.
void store(const PixelRecord& from, std::size_t pixel, Film& film);

}  // namespace pvol::formats::detail
