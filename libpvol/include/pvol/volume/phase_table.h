// A phase function by a table, measured or computed.
#pragma once

#include <memory>
#include <vector>

#include "pvol/volume/henyey_greenstein.h"

namespace pvol {

/// Linear in the cosine between points, and of integral 1 whatever their unit. Copies share the
/// table (THEORY.md, T4.6).
struct PhaseTable {
  static constexpr const char* kName = "table";
  struct Point {
    double angle = 0;  ///< of scattering, in degrees
    double value = 0;  ///< per steradian, in any unit
    friend bool operator==(const Point&, const Point&) = default;
  };
  struct Knot {
    double one_minus_cos, pdf;
    double share;  ///< of all scattering, at smaller angles
  };
  struct Data {
    std::vector<Point> points;
    std::vector<Knot> knots;
    double mean_cosine;
  };
  std::shared_ptr<const Data> data;  ///< not null

  PhaseTable();  ///< of the same value everywhere
  /// Throws Error where `expect_phase_table` expects something else.
  explicit PhaseTable(std::vector<Point> points);
  friend bool operator==(const PhaseTable& a, const PhaseTable& b) {
    return a.data->points == b.data->points;
  }
};

/// What was expected of points that are no table, or null: angles that ascend from 0 to 180, values
/// that are finite, not negative and not all zero, and no peak that is one spike in float.
[[nodiscard]] const char* expect_phase_table(const std::vector<PhaseTable::Point>& points);

// The questions that every phase function answers, see phase.h.

[[nodiscard]] double mean_cosine(const PhaseTable& p);
[[nodiscard]] float pdf_phase(const PhaseTable& p, Vec3f from, Vec3f to);
[[nodiscard]] PhaseSample sample_phase(const PhaseTable& p, Vec3f from, float u, float azimuth);

}  // namespace pvol
