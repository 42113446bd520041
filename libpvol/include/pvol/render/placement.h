// Where a cloud lies in the world, as users say it.
#pragma once

#include <optional>
#include <vector>

#include "pvol/math/affine.h"
#include "pvol/math/keys.h"
#include "pvol/math/moving_map.h"

namespace pvol {

/// A turn about an axis through the origin.
struct Turn {
  Vec3d axis{0, 1, 0};  ///< of any length > 0
  double degrees = 0;
  friend bool operator==(const Turn&, const Turn&) = default;
};

/// Scaled, then turned, then moved; or a matrix instead of all these.
struct Placement {
  std::optional<Vec3d> scale{};
  std::vector<Turn> rotate{};  ///< in this order
  std::optional<Vec3d> translate{};
  std::optional<Affine> matrix{};

  [[nodiscard]] Affine map() const;
  friend bool operator==(const Placement&, const Placement&) = default;
};

/// A placement at time 0 and another one a frame later. Between and beyond, translations and scales
/// change linearly, and angles about the same axes do; turns about other axes, or of matrices, by
/// the shortest turn from the first to the other (THEORY.md, T1.7).
struct MovingPlacement {
  Placement from{}, to{};

  [[nodiscard]] MovingMap map() const;
  friend bool operator==(const MovingPlacement&, const MovingPlacement&) = default;
};

/// What the rows of `rotate` and `matrix` check besides their numbers.
[[nodiscard]] const char* expect_axes(const Value& value);
[[nodiscard]] const char* expect_affine(const Value& value);

[[nodiscard]] Value turns_value(const Placement& placement);
void assign_turns(Placement& placement, const Value& value);
[[nodiscard]] Value matrix_value(const Placement& placement);
void assign_matrix(Placement& placement, const Value& value);

template <std::same_as<Placement> P>
[[nodiscard]] constexpr auto keys(const P&) {
  return std::to_array<Key<P>>({
      key<&P::scale>({.key = "scale",
                      .metavar = "XYZ",
                      .limits = number().or_three(),
                      .help = "Scale factors along the cloud's axes, applied first"}),
      {{.key = "rotate",
        .metavar = "XYZ,DEGREES",
        .limits = number().times(4).in_rows().also(expect_axes),
        .help = "Axis and angle in degrees of a rotation, or several that are applied in order; "
                "applied second"},
       turns_value,
       assign_turns},
      key<&P::translate>({.key = "translate",
                          .metavar = "XYZ",
                          .limits = number().times(3),
                          .help = "Translation in world units, applied last"}),
      {{.key = "matrix",
        .metavar = "NUMBERS",
        .limits = number().times({12, 16}).also(expect_affine),
        .help = "Replaces scale, rotate and translate: a matrix by rows, the translation in the "
                "last column"},
       matrix_value,
       assign_matrix},
  });
}

/// A matrix besides the rest, or a map that cannot be undone.
[[nodiscard]] std::optional<Misfit> misfit(const Placement& placement);
/// Of a pair that each have none: mirrored against each other, with scales that pass 0 between
/// them, or with a half turn that might go either way.
[[nodiscard]] std::optional<Misfit> misfit(const MovingPlacement& placement);

}  // namespace pvol
