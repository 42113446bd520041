// One plan for a render: every choice with its reason, the work to expect, and the refusal of what
// would not end. `render` carries it out and decides nothing.
//
//   const RenderPlan p = plan(volumes, scene);      // throws Error for what cannot be
//   for (const Decision& d : p.decisions) ...       // tell the user
//   const RenderResult r = render(p);
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pvol/render/guide_choice.h"
#include "pvol/render/lighting.h"
#include "pvol/render/scene.h"
#include "pvol/render/shell_choice.h"
#include "pvol/volume/estimators.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/volume.h"

namespace pvol {

namespace detail {
struct EmissionSetup;  // src/render/light/emission
struct Surfaces;       // src/render/scene/surface
}  // namespace detail

/// How paths are followed.
struct Kernel {
  KernelKind kind = KernelKind::scalar;  ///< not automatic
  bool count = false;
  bool endless = false;      ///< flights may be, nearly
  bool moving = false;       ///< velocities move some density: samples have times
  bool places_move = false;  ///< some volume moves as a whole: samples have times
  friend bool operator==(const Kernel&, const Kernel&) = default;
};

/// A choice in words.
struct Decision {
  std::string what;    ///< "shadow rays"
  std::string choice;  ///< "analog"
  std::string reason;  ///< "optical thickness about 12 on average, ..."
  int volume = -1;     ///< number of the one that it is about; -1: all
};

/// The work of the render, by a few of its paths (THEORY.md, T6.1). The time that it takes is
/// measured when it begins: TimeForecast in render.h.
struct Forecast {
  double samples = 0;     ///< of the camera
  double collisions = 0;  ///< of all paths
};

struct RenderPlan {
  std::span<const Volume> volumes{};  ///< must outlive the plan
  Scene scene{};                      ///< with nothing left to choose
  /// Of the scene, made once; null: made where it is asked for.
  std::shared_ptr<const Lighting> lighting{};
  TransmittanceChoice transmittance{};
  GuideChoice guide{};
  std::vector<ShellChoice> shells{};  ///< one for each volume
  Kernel kernel{};
  /// For each volume, why flights through it go one by one; null: many go at once.
  std::vector<const char*> one_by_one{};
  std::shared_ptr<const detail::EmissionSetup> emission{};  ///< null: none along flights
  std::vector<bool> line_lamps{};  ///< for each volume, whether flights ask lamps all along
  std::shared_ptr<const detail::Surfaces> surfaces{};  ///< null: there are none
  std::vector<Decision> decisions{};
  /// Whole sentences about what is likely to be a mistake, such as an extinction in another unit or
  /// a camera that looks away.
  std::vector<std::string> warnings{};
  Forecast forecast{};  ///< all 0 where nobody asked for it
};

/// Collisions of a camera path, on average, above which a picture is refused: on one core 10^5
/// samples then take minutes.
inline constexpr double kMostScatterings = 5000;

struct PlanOptions {
  /// Facts about each volume, for the refusal of weights that grow without end.
  std::span<const VolumeFacts> facts{};
  /// Plan what would hardly end, too.
  bool force = false;
  /// Follow a few paths of the camera. Without them there is no forecast, and neither long paths
  /// are refused nor is there a warning about the camera.
  bool forecast = true;
  /// Camera paths that choices reckon with; 0: those of the scene. For measurements on small
  /// pictures that stand for large ones.
  double paths = 0;
  /// Of an earlier plan for the same environment and lights, which takes time to make: of a clear
  /// sky some 0.03 s. Null: it is made.
  std::shared_ptr<const Lighting> lighting{};
};

/// Throws Error for values out of range (sizes, crops, lights, degenerate cameras), for volumes
/// that were not made for the scene's options, for regular tracking or transmittance where the
/// density along a ray has no closed form (tricubic, procedural, mapped, moving), for extinction by
/// channel with regular tracking or deep pictures, and for what would not end in reasonable time:
/// paths that scatter more often than kMostScatterings, weights that grow without end, and null
/// collisions in empty space under an enormous majorant; messages then begin with the volume's
/// name. The paths of the forecast take about a million steps, and one path beyond them.
/// Deterministic.
[[nodiscard]] RenderPlan plan(std::span<const Volume> volumes, const Scene& scene,
                              const PlanOptions& options = {});

/// Rough number of scatterings of a path that enters a cloud of this mean optical thickness: with
/// albedo 1 it grows without limit, and so does the time of a picture (THEORY.md, T6.1).
[[nodiscard]] double estimate_scatterings(double optical_thickness, double albedo);

}  // namespace pvol
