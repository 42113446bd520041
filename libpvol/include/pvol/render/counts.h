// What a render did, counted. Each counter has one row in a table, from which sums, reports and the
// counts of pixels follow.
#pragma once

#include <array>
#include <cstdint>

#include "pvol/track/tally.h"

namespace pvol {

/// What camera paths cost, summed over paths; all zero where counting was off.
struct Counts {
  Tally path;                    ///< of the camera paths' own free flights
  Tally shadow;                  ///< of transmittances
  std::uint64_t collisions = 0;  ///< real ones of camera paths
  std::uint64_t shadow_rays = 0;
  std::uint64_t shell_tests = 0, shell_rejections = 0;  ///< of camera rays that meet the box
  std::uint64_t surface_hits = 0;                       ///< of camera paths

  Counts& operator+=(const Counts& c);
  friend bool operator==(const Counts&, const Counts&) = default;
};

/// A counter by the name that it has in reports.
struct Counter {
  const char* name;
  std::uint64_t& (*of)(Counts&);
};

inline constexpr std::array kCounters = std::to_array<Counter>({
    {"lookups_path", [](Counts& c) -> std::uint64_t& { return c.path.lookups; }},
    {"lookups_shadow", [](Counts& c) -> std::uint64_t& { return c.shadow.lookups; }},
    {"bounds_tests_path", [](Counts& c) -> std::uint64_t& { return c.path.bounds_tests; }},
    {"bounds_tests_shadow", [](Counts& c) -> std::uint64_t& { return c.shadow.bounds_tests; }},
    {"segments_path", [](Counts& c) -> std::uint64_t& { return c.path.segments; }},
    {"segments_shadow", [](Counts& c) -> std::uint64_t& { return c.shadow.segments; }},
    {"collisions", [](Counts& c) -> std::uint64_t& { return c.collisions; }},
    {"null_collisions", [](Counts& c) -> std::uint64_t& { return c.path.null_collisions; }},
    {"null_collisions_shadow",
     [](Counts& c) -> std::uint64_t& { return c.shadow.null_collisions; }},
    {"shadow_rays", [](Counts& c) -> std::uint64_t& { return c.shadow_rays; }},
    {"shell_tests", [](Counts& c) -> std::uint64_t& { return c.shell_tests; }},
    {"shell_rejections", [](Counts& c) -> std::uint64_t& { return c.shell_rejections; }},
    {"surface_hits", [](Counts& c) -> std::uint64_t& { return c.surface_hits; }},
});

[[nodiscard]] inline std::uint64_t value(const Counter& counter, Counts c) { return counter.of(c); }

inline Counts& Counts::operator+=(const Counts& c) {
  for (const Counter& counter : kCounters) counter.of(*this) += value(counter, c);
  return *this;
}

/// What is counted for each pixel by itself, for maps of where the work is.
enum class PixelCounter { lookups, bounds_tests, segments, collisions };

struct PixelCount {
  const char* name;
  std::uint64_t (*of)(const Counts&);
};

/// By PixelCounter.
inline constexpr std::array kPixelCounts = std::to_array<PixelCount>({
    {"lookups", [](const Counts& c) { return c.path.lookups + c.shadow.lookups; }},
    {"bounds_tests", [](const Counts& c) { return c.path.bounds_tests + c.shadow.bounds_tests; }},
    {"segments", [](const Counts& c) { return c.path.segments + c.shadow.segments; }},
    {"collisions", [](const Counts& c) { return c.collisions; }},
});

/// Totals over the samples of a pixel, by PixelCounter.
using PixelCounts = std::array<std::uint64_t, kPixelCounts.size()>;

}  // namespace pvol
