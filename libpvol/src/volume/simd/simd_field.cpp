#include "volume/simd/simd_field.h"

#include <cmath>
#include <vector>

#include "pvol/bounds/walk.h"
#include "pvol/field/procedural.h"
#include "pvol/field/sample_codes.h"
#include "pvol/volume/extinction_source.h"
#include "volume/any_source.h"
#include "volume/field_samples.h"

namespace pvol::detail {

namespace {

/// Whether look-ups are made in lanes.
bool has_lanes(const VolumeField& f) {
  const bool mapped_in_motion = f.map != nullptr && f.motion != nullptr;
  const bool in_array = f.shares_samples() && !f.shared().in_leaves();
  return has_closed_form(f.look_up) && !mapped_in_motion && !in_array;
}

}  // namespace

SimdField::SimdField(const VolumeField& f, const DenseBounds& b)
    : bounds(b), scale(f.scale), look_up(f.look_up) {
  if (has_lanes(f)) {
    if (f.shares_samples()) {
      shared = f.shared().leaves.data();
    } else {
      samples = f.bricks().samples.data();
    }
    map = f.map.get();
    if (f.motion != nullptr) moving = &f;
  } else {
    one_by_one = &f;
  }
  if (f.micro.edge > 0) {
    micro_codes = reinterpret_cast<const std::uint16_t*>(f.micro.codes.data());
    micro_scales = reinterpret_cast<const float*>(f.micro.scales.data());
    micro_shift = f.micro.edge - 1;  // of 1 and 2
  }
  if (f.codes != nullptr) {
    codes = f.codes->codes.data();
    code_scales = reinterpret_cast<const float*>(f.codes->scales.data());
  }
  for (int axis = 0; axis < 3; ++axis) {
    Vec3d unit(0);
    unit[axis] = 1;
    cells[std::size_t(axis)] = Vec3f(f.world_to_cells.vector(unit));
    low[axis] = float(f.octree.support_lo[axis] + DenseBounds::kBorder);
    high[axis] = std::nextafter(float(f.octree.support_hi[axis] + DenseBounds::kBorder), 0.0f);
  }
}

void look_up_one_by_one(const VolumeField& field, const float* x, const float* y, const float* z,
                        const float* time, const std::uint32_t* brick,
                        std::span<const std::uint32_t> which, float* density) {
  const auto place_of = [&](std::uint32_t event) {
    const Vec3d place{double(x[event]), double(y[event]), double(z[event])};
    return lattice_point(field.octree, place - Vec3d(DenseBounds::kBorder));
  };
  const auto for_places = [&](const auto& density_at) {
    for (const std::uint32_t event : which) *density++ = density_at(event, place_of(event));
  };
  if (field.motion != nullptr) {
    return for_places([&](std::uint32_t event, const LatticePoint& at) {
      return density_at_time(field, brick[event], at, time[event]);
    });
  }
  if (field.look_up == LookUp::procedural) {
    std::vector<std::uint32_t> bricks;
    std::vector<LatticePoint> places;
    for (const std::uint32_t event : which) {
      bricks.push_back(brick[event]);
      places.push_back(place_of(event));
    }
    densities_in_bricks(field.recipe(), bricks, places, density);
    if (field.map == nullptr) return;
    for (float& one : std::span(density, which.size())) one = value_at(*field.map, one);
    return;
  }
  visit_source(field, [&](const auto& source) {
    for_places([&](std::uint32_t event, const LatticePoint& at) {
      return source.density(brick[event], at);
    });
  });
}

void trace_back(const VolumeField& field, const PlacesInMotion& places,
                std::span<const std::uint32_t> which) {
  const Vec3d border(DenseBounds::kBorder);
  for (const std::uint32_t event : which) {
    const Vec3d at{double(places.x[event]), double(places.y[event]), double(places.z[event])};
    const Vec3d from = place_at_rest(field, places.time[event], at - border) + border;
    places.to_x[event] = float(from.x), places.to_y[event] = float(from.y);
    places.to_z[event] = float(from.z);
  }
}

const char* simd_obstacle(const Volume& v) {
  const VolumeField& f = v.density;
  // Their constants would reach beyond the support's box, to the ends of leaves.
  if (f.homogeneous != nullptr) return "nodes are homogenised";
  if (f.octree.empty()) return "the volume is empty";
  // Places of rays are floats, whose spacing is a thousandth of a voxel up to here.
  constexpr int kMostCellsAlong = (1 << 14) - 2 * DenseBounds::kBorder;
  const Vec3i end = vec3(f.octree.support_hi);
  if (max_component(end) > kMostCellsAlong)
    return "the volume has more than 16 000 voxels along an axis";
  // Each leaf of the box has a word and the number of a brick: little beside the samples, unless
  // nearly all of a large box is air.
  constexpr std::uint64_t kFewWords = 1u << 24, kMostWords = 1u << 28, kMostOfABrick = 64;
  const std::uint64_t words = count_words(f.octree);
  if (words > kFewWords && (words > kMostWords || words > kMostOfABrick * count_bricks(f)))
    return "the volume's box has too many leaves for what it holds";
  // Lanes count copies of samples in 31 bits, shared ones and codes in 32.
  constexpr std::size_t kMostSamples = std::size_t(1) << 31;
  if (has_lanes(f) && !f.shares_samples() && count_bricks(f) > kMostSamples / kFieldSamples - 1)
    return "the volume has more than 2.9 million bricks";
  if (has_lanes(f) && f.shares_samples() && count_bricks(f) > 2 * kMostSamples / kBrickSamples)
    return "the volume has more than 8.3 million bricks";
  if (f.codes != nullptr && count_bricks(f) > 2 * kMostSamples / kFieldSamples - 1)
    return "the volume has more than 5.8 million bricks";
  float most = 0;
  for (const Octree::Entry& e : f.octree.entries) most = std::max(most, e.hi);
  // A mean free path is to be at least 64 spacings of the floats (THEORY.md, T2.2).
  const auto farthest = float(max_component(end) + DenseBounds::kBorder);
  const double spacing = double(std::nextafter(farthest, 0x1p30f) - farthest);
  const double cell = std::cbrt(std::abs(determinant(inverse(f.world_to_cells))));
  if (double(most) * cell * spacing > 1.0 / 64) return "voxels are too thick for places in floats";
  return nullptr;
}

}  // namespace pvol::detail
