#include "pvol/render/plan.h"

#include <algorithm>

#include "math/digits.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/motion.h"
#include "pvol/volume/moving_places.h"
#include "render/light/emission/emission_setup.h"
#include "render/plan/check_scene.h"
#include "render/plan/choose_wavefront.h"
#include "render/plan/fire_lights.h"
#include "render/plan/forecast.h"
#include "render/plan/lamp_choice.h"
#include "render/plan/sanity.h"
#include "render/scene/surface/surfaces.h"

namespace pvol {
namespace {

using detail::digits;

double count_paths(const RenderOptions& o) {
  return double(o.width) * o.height * expected_samples(o);
}

Kernel choose_kernel(const RenderPlan& p) {
  const auto any = [&](const auto& is) { return std::ranges::any_of(p.volumes, is); };
  return {.kind = p.scene.options.kernel,
          .count = p.scene.options.count || counted(p.scene.options.aovs),
          .endless = any(detail::has_endless_flights),
          .moving = any([](const Volume& v) { return motion_of(v) != nullptr; }) ||
                    (p.surfaces && p.surfaces->move()),
          .places_move = any(places_move)};
}

Decision decide_cut(const Volume& v, const RenderOptions& o) {
  return {"octree", "walks stop at depth " + std::to_string(v.density.octree.depth) + " or above",
          o.depth                              ? "as set"
          : o.tracker == Tracker::delta_global ? "the tracker uses one majorant"
                                               : "the depth of least cost"};
}

Decision decide_micro_bounds(const Volume& v, const RenderOptions& o) {
  const VolumeField& f = v.density;
  const std::string edge = std::to_string(f.micro.edge);
  const std::string choice = f.codes             ? "codes of samples"
                             : f.micro.edge == 0 ? "none"
                                                 : "of " + edge + "^3 voxels";
  if (f.motion != nullptr) return {"micro-bounds", choice, "the volume moves"};
  if (o.micro_bounds != MicroBoundsUse::automatic) return {"micro-bounds", choice, "as set"};
  return {"micro-bounds", choice,
          f.codes             ? "they decide all but one tentative collision in a hundred or more"
          : f.micro.edge == 0 ? "look-ups are cheap, bounds are already tight, or paths are few"
          : f.micro_stored    ? "from the file: look-ups cost more than micro-bounds"
                              : "built: look-ups cost more than micro-bounds"};
}

Decision decide_motion(const Motion& m) {
  return {"motion", "blurred",
          "it moves by up to " + digits(m.longest) +
              " voxels along an axis between the files' time and the shutter's farther end"};
}

Decision decide_moving_places(const Volume& v) {
  const MovingPlaces& m = *v.moving_places;
  const auto moving = std::ranges::count_if(m.all, &MovingPlace::moves);
  const std::string which =
      m.all.size() == 1
          ? "it moves"
          : std::to_string(moving) + " of its " + std::to_string(m.all.size()) + " instances move";
  return {"motion", "as a whole",
          which + " by up to " + digits(m.longest) +
              " world units between the files' time and the shutter's farther end"};
}

Decision decide_camera(const Camera& c, const MovingMap& motion) {
  if (c.shutter.open == c.shutter.close) {
    return {"camera", "stands still", "the shutter is open for an instant"};
  }
  const double frames = c.shutter.close - c.shutter.open;
  double turn = 0;
  for (const MovingTurn& t : motion.turns) turn += std::abs(t.rate);
  return {"camera", "moves",
          "by " + digits(length(motion.shift_rate) * frames) + " world units and " +
              digits(turn * frames * 180 / std::numbers::pi) +
              " degrees while the shutter is open"};
}

/// The reason is the estimate, whoever chose: it is worth knowing.
Decision decide_shell(const ShellChoice& shell) {
  const ShellEstimate& e = shell.estimate;
  const double rejected = e.boxed > 0 ? 100.0 * e.rejected / e.boxed : 0;
  return {"shell", shell.kept ? "used" : "left out",
          "it would reject " + digits(rejected) +
              " % of the camera rays in the box; a test costs about " + digits(e.spent) +
              " ns and saves " + digits(e.saved) + " ns"};
}

Decision decide_guide(const GuideChoice& guide) {
  std::string reason = guide.reason;
  if (guide.scatterings > 0) reason += ", about " + digits(guide.scatterings) + " scatterings";
  return {"paths", guide.used ? "guided" : "not guided", std::move(reason)};
}

Decision decide_transmittance(const TransmittanceChoice& t, bool by_user, bool in_lanes) {
  return {"shadow rays", name(t.estimator),
          by_user    ? "as set"
          : in_lanes ? "many paths are traced at once"
                     : "optical thickness about " + digits(t.thickness) + " on average, " +
                           digits(100 * t.control_share) + " % of the majorants are minorants"};
}

/// Of volumes whose media emit, and of fires.
std::optional<Decision> decide_emission(const RenderPlan& p, const RenderOptions& wanted) {
  if (p.emission == nullptr) {
    const auto glows = [](const Volume& v) { return emits(v.medium); };
    if (std::ranges::none_of(p.volumes, glows)) return std::nullopt;
    return Decision{"emission", "gathered at collisions",
                    wanted.line_emission == LineEmission::off ? "as set" : "the clouds are thick"};
  }
  const detail::EmissionSetup& e = *p.emission;
  const bool fires = std::ranges::any_of(p.volumes, [](const Volume& v) { return bool(v.fire); });
  const bool collide = std::ranges::any_of(e.at_collisions, [](const auto& f) { return bool(f); });
  std::string choice = !collide ? "gathered along flights"
                       : e.lines.sources.empty()
                           ? "gathered at collisions"
                           : "gathered at collisions, in thin parts along flights";
  if (e.sampled_in_volumes) {
    choice += ", and sampled as a light";
  } else if (e.sampled_on_surfaces && !p.scene.surfaces.empty()) {
    choice += ", and sampled as a light by surfaces";
  }
  return Decision{"emission", std::move(choice),
                  wanted.line_emission != LineEmission::automatic ? "as set"
                  : collide                                       ? "paths collide where it burns"
                  : fires                                         ? "a field emits"
                                                                  : "the cloud is thin"};
}

/// Whether lanes serve the flights through any volume.
bool any_in_lanes(const RenderPlan& p) {
  return std::ranges::any_of(p.one_by_one, [](const char* reason) { return reason == nullptr; });
}

/// The choices in words, in the order in which they bear on each other.
std::vector<Decision> decide(const RenderPlan& p, const RenderOptions& wanted,
                             const detail::LampChoice& lamps, const std::string& kernel_reason) {
  std::vector<Decision> all;
  const Camera& camera = p.scene.camera;
  if (const auto motion = motion_of(camera)) all.push_back(decide_camera(camera, *motion));
  for (std::size_t i = 0; i < p.volumes.size(); ++i) {
    const Volume& v = p.volumes[i];
    const std::size_t first = all.size();
    all.push_back(decide_cut(v, wanted));
    all.push_back(decide_micro_bounds(v, wanted));
    if (const Motion* m = motion_of(v)) all.push_back(decide_motion(*m));
    if (places_move(v)) all.push_back(decide_moving_places(v));
    if (v.shell) all.push_back(decide_shell(p.shells[i]));
    for (std::size_t k = first; k < all.size(); ++k) all[k].volume = int(i);
  }
  if (auto emission = decide_emission(p, wanted)) all.push_back(std::move(*emission));
  if (lamps.reason) all.push_back(detail::in_words(lamps));
  all.push_back(decide_guide(p.guide));
  all.push_back({"kernel", name(p.kernel.kind), kernel_reason});
  for (std::size_t i = 0; i < p.volumes.size(); ++i) {
    if (const char* const reason = p.one_by_one[i]; reason && p.kernel.kind != KernelKind::scalar)
      all.push_back({"flights", "one by one", reason, int(i)});
  }
  all.push_back(decide_transmittance(
      p.transmittance, wanted.transmittance != Transmittance::automatic, any_in_lanes(p)));
  return all;
}

}  // namespace

RenderPlan plan(std::span<const Volume> volumes, const Scene& scene, const PlanOptions& options) {
  RenderPlan p{.volumes = volumes, .scene = scene};
  // Lights by kind, as scene files have them: a picture can be repeated from its header to the bit.
  std::stable_sort(p.scene.lights.begin(), p.scene.lights.end(),
                   [](const Light& a, const Light& b) { return a.index() < b.index(); });
  RenderOptions& o = p.scene.options;
  p.transmittance = choose_transmittance(volumes);
  if (o.transmittance != Transmittance::automatic) p.transmittance.estimator = o.transmittance;
  o.transmittance = p.transmittance.estimator;
  detail::check(volumes, p.scene);
  const detail::KernelChoice choice = detail::choose_wavefront(o.kernel);
  o.kernel = choice.kernel;
  RenderOptions asked = o;
  asked.transmittance = scene.options.transmittance;
  for (const Volume& v : volumes) p.one_by_one.push_back(detail::why_one_by_one(v, asked));
  if (any_in_lanes(p) && scene.options.transmittance == Transmittance::automatic)
    o.transmittance = Transmittance::ratio;
  p.transmittance.estimator = o.transmittance;
  for (std::size_t i = 0; i < volumes.size() && !options.force; ++i) {
    detail::refuse_endless_flights(volumes[i],
                                   i < options.facts.size() ? &options.facts[i] : nullptr, o);
  }
  for (const Volume& v : volumes) p.shells.push_back(choose_shell(v, scene));
  p.lighting = options.lighting ? options.lighting
                                : std::make_shared<const Lighting>(make_lighting(p.scene));
  p.guide = choose_guide(volumes, p.scene, *p.lighting,
                         options.paths > 0 ? options.paths : count_paths(o));
  p.surfaces = detail::make_surfaces(scene.surfaces, scene.camera.shutter);
  p.kernel = choose_kernel(p);
  p.emission = detail::prepare_emission(volumes, p.scene);
  if (p.emission && p.emission->lit) p.emission = detail::choose_fire_lights(p);
  const detail::LampChoice lamps = detail::choose_lamps(p);
  p.line_lamps = lamps.along_flights;
  p.decisions = decide(p, scene.options, lamps, choice.reason);
  if (!options.forecast) return p;
  const detail::CameraProbe probe = detail::probe_camera(p);
  if (!options.force) detail::refuse_endless_paths(p, probe);
  p.warnings = detail::find_warnings(p, probe);
  p.forecast = detail::forecast(p, probe);
  return p;
}

double estimate_scatterings(double optical_thickness, double albedo) {
  return 1 / (1 / (1 + optical_thickness) + (1 - albedo));
}

}  // namespace pvol
