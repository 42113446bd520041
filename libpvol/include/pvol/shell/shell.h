// Bounding shells: a closed region in a few hundred bytes that holds every occupied cell of a
// cloud.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "pvol/form/free_form.h"
#include "pvol/math/vec.h"

namespace pvol {

/// How a shell's perturbations act. The kinds are not interchangeable: a soft shell read as a hard
/// one cuts occupied cells away.
enum class ShellKind {
  hard,  ///< ({F >= 0} or some bulge Q_i >= 0) and no dent Q_i > 0: the limit of large strengths;
         ///< strengths are +1 (bulge) or -1 (dent). Rays meet it in roots of quadratics
  soft,  ///< {F' >= 0}, a C1 surface. Rays meet it in roots of quartics
};

/// Proof that a shell holds its cloud: over all occupied cells the shell's slack is at least
/// `bound`. The slack is F' for a soft shell; for a hard one the least of -Q_i over dents and of
/// the greatest of F and the bulges.
struct Certificate {
  double bound = 0;         ///< > 0, in units of the forms' values
  std::uint64_t boxes = 0;  ///< that branch and bound looked at
  int depth = 0;  ///< of its smallest box: log2 of its edge in cells, negative below cells
  friend bool operator==(const Certificate&, const Certificate&) = default;
};

/// What a fit measured about its shell. Ratios are against the support itself: 1 is perfect.
struct ShellTightness {
  double volume_ratio = 0;      ///< volume of the shell over that of the occupied cells
  double hit_ratio = 0;         ///< isotropic lines that meet the shell over those that meet a cell
  double box_volume_ratio = 0;  ///< the same for the box alone
  double box_hit_ratio = 0;
  friend bool operator==(const ShellTightness&, const ShellTightness&) = default;
};

/// The region of index space inside both the box [lo, hi] and the form. Coefficients and strengths
/// are floats, as files store them. The form lives in the shell's own frame (see `frame`), so that
/// placing or instancing the cloud changes one affine map and never the shell.
struct Shell {
  ShellKind kind = ShellKind::hard;
  Vec3l lo, hi;   ///< tight box of the occupied cells, [lo, hi)
  FreeForm form;  ///< not nested, at most kMaxPerturbations
  Certificate certificate;
  ShellTightness tightness;
  friend bool operator==(const Shell&, const Shell&) = default;
};

inline constexpr int kMaxPerturbations = 64;

/// A shell's frame: p = (x - centre) / unit with x in index space. The centre is that of the box
/// and the unit the least power of two at or above half its longest side, so that |p| <= 1 on each
/// axis and lattice points have exact coordinates.
struct ShellFrame {
  Vec3d centre;
  double unit = 1;
  [[nodiscard]] Vec3d to_shell(Vec3d index) const { return (index - centre) * (1 / unit); }
  [[nodiscard]] Vec3d to_index(Vec3d p) const { return p * unit + centre; }
};
[[nodiscard]] ShellFrame frame(Vec3l lo, Vec3l hi);
[[nodiscard]] inline ShellFrame frame(const Shell& shell) { return frame(shell.lo, shell.hi); }

/// A continuous function of p (in the shell's frame), >= 0 exactly inside the form: the slack of
/// `Certificate`. The box is not part of it.
[[nodiscard]] double slack(const Shell& shell, Vec3d p);

/// Whether a point of index space lies in the shell: in the box and in the form.
[[nodiscard]] bool contains(const Shell& shell, Vec3d index);

/// Rounds every coefficient and strength to float.
[[nodiscard]] FreeForm round_to_float(const FreeForm& form);

/// Nothing if the invariants above hold and all coefficients are finite, else what does not.
[[nodiscard]] std::optional<std::string> validate(const Shell& shell);

}  // namespace pvol
