// One plan for a render: every choice with its reason, the work to expect, and the refusal of what
// would not end. `render` carries it out and decides nothing.
//
//   const RenderPlan p = plan(volumes, scene);      // throws Error for what cannot be
//   for (const Decision& d : p.decisions) ...       // tell the user
//   const RenderResult r = render(p);
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pvol/render/guide_choice.h"
#include "pvol/render/scene.h"
#include "pvol/render/shell_choice.h"
#include "pvol/volume/estimators.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/volume.h"

namespace pvol {

/// How paths go through a scene's volumes.
enum class Paths { one_volume, many_volumes, guided };
[[nodiscard]] constexpr auto names(Paths) {
  return std::to_array<Named<Paths>>({{Paths::one_volume, "one volume"},
                                      {Paths::many_volumes, "many volumes"},
                                      {Paths::guided, "guided"}});
}

/// Which compiled loops render: those through the field and those of paths.
struct Kernel {
  LookUp look_up = LookUp::trilinear;
  int micro_edge = 0;  ///< of micro-bounds that all volumes have: 0 (none), 1 or 2 cells
  Paths paths = Paths::one_volume;
  bool count = false;
  friend bool operator==(const Kernel&, const Kernel&) = default;
};

/// A choice in words.
struct Decision {
  std::string what;    ///< "shadow rays"
  std::string choice;  ///< "analog"
  std::string reason;  ///< "optical thickness about 12 on average, ..."
  int volume = -1;     ///< number of the one that it is about; -1: all
};

/// What the render will take, by the bounds and the cost model (THEORY.md, T6.1): within a factor
/// of about three, on one core of the machine that the model was solved on.
struct Forecast {
  double samples = 0;      ///< of the camera
  double collisions = 0;   ///< of all paths
  double cpu_seconds = 0;  ///< of all threads together
};

struct RenderPlan {
  std::span<const Volume> volumes{};  ///< must outlive the plan
  Scene scene{};                      ///< with nothing left to choose
  TransmittanceChoice transmittance{};
  GuideChoice guide{};
  std::vector<ShellChoice> shells{};  ///< one for each volume
  Kernel kernel{};
  std::vector<Decision> decisions{};
  Forecast forecast{};
};

struct PlanOptions {
  /// Facts about each volume, for the refusal of endless work; without them nothing is refused.
  std::span<const VolumeFacts> facts{};
  /// Plan what would hardly end, too.
  bool force = false;
  /// Camera paths that choices reckon with; 0: those of the scene. For measurements on small
  /// pictures that stand for large ones.
  double paths = 0;
};

/// Throws Error for values out of range (sizes, crops, lights, degenerate cameras), for volumes
/// that were not made for the scene's options, for several volumes and a tracker with weights, for
/// regular tracking or transmittance of tricubic or procedural fields, and, by facts, for what
/// would not end in reasonable time: paths that scatter for ever, nearly, weights that grow without
/// end, and null collisions in empty space under an enormous majorant; messages then begin with
/// the volume's name. Deterministic.
[[nodiscard]] RenderPlan plan(std::span<const Volume> volumes, const Scene& scene,
                              const PlanOptions& options = {});

/// Rough number of scatterings of a path that enters a cloud of this mean optical thickness: with
/// albedo 1 it grows without limit, and so does the time of a picture (THEORY.md, T6.1).
[[nodiscard]] double estimate_scatterings(double optical_thickness, double albedo);

}  // namespace pvol
