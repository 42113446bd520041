#include "pvol/density/flow.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <memory>
#include <string>

#include "math/digits.h"
#include "pvol/error.h"
#include "pvol/math/parallel.h"

namespace pvol {
namespace {

constexpr double kMost = 1e30;  // products with places stay finite in double
constexpr int kMostVoxels = 512;

void check(bool holds, const std::string& what, double found, const std::string& expected) {
  if (holds) return;
  throw Error("flow: " + what + " is " + detail::digits(found, 6) + "; expected " + expected);
}

void check(const Vec3d& v, const std::string& what) {
  for (int axis = 0; axis < 3; ++axis) {
    check(std::abs(v[axis]) <= kMost, what, v[axis], "numbers in [-1e30, 1e30]");
  }
}

/// Bricks of one x, by component.
struct Slab {
  std::vector<Vec3i> origins;
  std::array<std::vector<float>, 3> samples;
};

void sample_brick(const Flow& flow, Vec3i origin, double voxel, Slab& slab) {
  slab.origins.push_back(origin);
  for (int i = 0; i < kBrickSamples; ++i) {
    const Vec3i at(i / (kBrickEdge * kBrickEdge), i / kBrickEdge % kBrickEdge, i % kBrickEdge);
    const Vec3d v = velocity_at(flow, Vec3d(origin + at) * voxel);
    for (int c = 0; c < 3; ++c) {
      if (!(std::abs(v[c]) <= double(FLT_MAX))) {
        throw Error("flow: a velocity exceeds 3.4e38; check its unit");
      }
      slab.samples[std::size_t(c)].push_back(float(v[c]));
    }
  }
}

/// Component c of what the slabs hold.
VoxelGrid collect(const std::shared_ptr<const std::vector<Slab>>& slabs, std::size_t c,
                  double voxel) {
  VoxelGrid grid;
  grid.name = std::string("v.") + "xyz"[c];
  grid.index_to_world = scaling(Vec3d(voxel));
  for (const Slab& slab : *slabs) {
    for (std::size_t b = 0; b < slab.origins.size(); ++b) {
      const float* const values = slab.samples[c].data() + b * kBrickSamples;
      const bool any = std::any_of(values, values + kBrickSamples, [](float v) { return v != 0; });
      if (any) grid.bricks.push_back({slab.origins[b], values});
    }
  }
  grid.owner = slabs;
  return grid;
}

}  // namespace

void validate(const Flow& flow) {
  check(flow.velocity, "velocity");
  check(flow.spin, "spin");
  check(flow.stretch, "stretch");
  check(flow.centre, "centre");
  check(flow.turbulence >= 0 && flow.turbulence <= kMost, "turbulence", flow.turbulence,
        "a number in [0, 1e30]");
  check(flow.noise.cell >= 1 / kMost && flow.noise.cell <= kMost, "cell", flow.noise.cell,
        "a number in [1e-30, 1e30]");
  check(flow.noise.octaves >= 1 && flow.noise.octaves <= kMaxOctaves, "octaves", flow.noise.octaves,
        "1 to " + std::to_string(kMaxOctaves));
  check(flow.noise.gain > 0 && flow.noise.gain <= 1, "gain", flow.noise.gain, "a number in (0, 1]");
}

Vec3d velocity_at(const Flow& flow, Vec3d world) {
  const Vec3d from = world - flow.centre;
  Vec3d v = flow.velocity + cross(flow.spin, from) + flow.stretch * from;
  if (flow.turbulence == 0) return v;
  Fbm noise = flow.noise;
  for (int c = 0; c < 3; ++c) {
    v[c] += flow.turbulence * fbm(noise, world);
    ++noise.seed;
  }
  return v;
}

VelocityGrid sample_flow(const Flow& flow, const Box& box, double voxel) {
  validate(flow);
  check(voxel > 0 && std::isfinite(voxel), "the voxel", voxel, "a number above 0");
  if (box.empty()) throw Error("flow: there is no box in which to sample it");
  const Vec3d margin = box.extent() * 0.5 + Vec3d(voxel);
  const Vec3d low = (box.lo - margin) / (voxel * kBrickEdge);
  const Vec3d high = (box.hi + margin) / (voxel * kBrickEdge);
  constexpr double kReach = 1 << 26;  // in bricks
  check(max_component(high - low) * kBrickEdge <= kMostVoxels && max_component(high) < kReach &&
            min_component(low) > -kReach,
        "the box over the voxel", max_component(high - low) * kBrickEdge,
        "at most " + std::to_string(kMostVoxels) + " voxels along a side");
  const Vec3i first(Vec3d(std::floor(low.x), std::floor(low.y), std::floor(low.z)));
  const Vec3i last(Vec3d(std::ceil(high.x), std::ceil(high.y), std::ceil(high.z)));
  const auto slabs = std::make_shared<std::vector<Slab>>(std::size_t(last.x - first.x));
  parallel_for(0, slabs->size(), [&](std::size_t i) {
    for (std::int32_t y = first.y; y < last.y; ++y) {
      for (std::int32_t z = first.z; z < last.z; ++z) {
        const Vec3i at(first.x + std::int32_t(i), y, z);
        sample_brick(flow, at * kBrickEdge, voxel, (*slabs)[i]);
      }
    }
  });
  VelocityGrid grid;
  for (std::size_t c = 0; c < 3; ++c) grid.along[c] = collect(slabs, c, voxel);
  return grid;
}

}  // namespace pvol
