// What all paths of an image share, computed once a render: by who uses it.
#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pvol/render/film.h"
#include "pvol/render/lights.h"
#include "pvol/render/plan.h"
#include "render/light/emission/emission_setup.h"
#include "render/light/lamp.h"
#include "render/light/many_lights.h"
#include "render/light/met_lights.h"
#include "render/light/open_sky.h"
#include "render/path/free_radii.h"
#include "render/path/instances.h"
#include "render/path/pixel_importance.h"
#include "render/path/scene_objects.h"
#include "render/path/volume_setup.h"
#include "render/scene/filter_offsets.h"
#include "render/scene/image_part.h"
#include "render/scene/projection.h"
#include "render/scene/surface/surfaces.h"
#include "volume/dense_bounds.h"

namespace pvol::detail {

class Importance;
struct LampPilot;

/// How a camera moves about where it is in the middle of the shutter.
struct CameraMotion {
  MovingMap map;
  Affine from_middle;

  [[nodiscard]] Ray at(double frames, const Ray& ray) const {
    const Affine to_then = map.at(frames) * from_middle;
    return {to_then.point(ray.o), normalize(to_then.vector(ray.d))};
  }
  /// Where the camera in the middle of the shutter has what the one at a time has at a place.
  [[nodiscard]] Affine to_middle(double frames) const {
    return inverse(map.at(frames) * from_middle);
  }
};

/// Where camera rays begin (camera_rays.h).
struct CameraSetup {
  Camera camera;
  Projection projection;  ///< of the camera in the middle of the shutter
  FilterOffsets filter;
  std::optional<CameraMotion> motion;  ///< none: it stands still while the shutter is open

  explicit CameraSetup(const Scene& scene);
};

/// Light from outside the volumes, ready for sampling (gather_light.h, photon_sources.h).
struct LightSetup {
  std::shared_ptr<const Lighting> lighting;
  SkyLight sky;  ///< that of the lighting, as are the lights
  std::vector<LightSource> sources;
  std::vector<std::uint32_t> suns;           ///< their numbers
  std::shared_ptr<const ManyLights> many;    ///< the same, for drawing some
  bool drawn_in_volumes, drawn_on_surfaces;  ///< whether there are so many that some are drawn
  float shadow_unit;  ///< radiance for which there is one shadow ray (THEORY.md, T5.2)
  MetLights met;
  float bright_sky;  ///< luminance from which on the sky is seen as lights are
  /// Numbers of those that the camera may see; that of the sky is the one after them.
  std::vector<std::uint32_t> seen;
  std::shared_ptr<const OpenSky> open_sky;  ///< where surfaces catch shadows, else null

  /// `box` is around the volumes.
  LightSetup(const RenderPlan& plan, const Box& box);
};

/// Layers of light in the film (film_layers.h).
struct LayerNames {
  /// Each once: "sun_1", "sun_2", "point_1", a group's, "sky", "emission".
  std::vector<std::string> names;
  /// Number of the layer of each light, of the sky and of emission.
  std::vector<std::size_t> of;

  explicit LayerNames(const Lighting& lighting);
};

struct PathSetup {
  std::span<const Volume> scene_volumes;  ///< those of the plan
  RenderOptions options;
  CameraSetup view;
  LightSetup light;
  LayerNames layers;

  /// Radiance that is everywhere and is left out of sky, emission and paths, to be added to every
  /// camera path as it is (THEORY.md, T5.5); 0 where paths are not guided.
  Rgb constant;
  std::shared_ptr<const Importance> importance;             ///< of guided paths
  std::shared_ptr<const PixelImportance> pixel_importance;  ///< likewise; null: all count alike

  std::vector<VolumeSetup> volumes;
  std::shared_ptr<const Instances> instances;     ///< of the volumes
  FreeRadii free_radii;                           ///< of them
  std::shared_ptr<const EmissionSetup> emission;  ///< along flights; null: there is none
  /// By the numbers of lights; where flights through any volume ask them (lamps_along.h), else
  /// none.
  std::vector<Lamp> lamps{};
  /// Of the volumes before lights that are seen (seen_lights-inl.h); null: flights add these.
  std::shared_ptr<const LineSources> depths;
  std::shared_ptr<const Surfaces> surfaces;     ///< null: there are none
  std::shared_ptr<const SceneObjects> objects;  ///< null: nobody asks

  KernelKind kernel;  ///< of lanes
  /// Of each volume; setups may share them. Those of empty volumes, and of those through which
  /// flights go one by one, have no words.
  std::shared_ptr<const std::vector<DenseBounds>> dense;
  std::uint32_t max_bounces;
  bool count;                  ///< whether flights do
  bool halves;                 ///< whether samples are of two halves, independent of each other
  bool first_collisions;       ///< whether somebody asks where they are
  bool moving;                 ///< whether samples have times
  bool albedo_varies;          ///< whether that of any volume is a field
  bool by_channel;             ///< whether the extinction of any volume differs by channel
  bool weighs;                 ///< whether flights have weights: by channel, or by the tracker
  FirePilot* pilot = nullptr;  ///< null: nobody asks
  LampPilot* lamp_pilot = nullptr;
  /// Once it is true, paths end as they please, and what they bring is to be dropped.
  const std::atomic<bool>* stop = &kNeverStop;

  explicit PathSetup(const RenderPlan& plan, Rgb constant_ = Rgb(0.0f),
                     std::shared_ptr<const std::vector<DenseBounds>> dense_ = nullptr);

  /// The same paths through a picture of about so many pixels in place of the large one.
  [[nodiscard]] PathSetup in_small(int pixels) const;

  /// Whether paths go through one volume alone, which stands still: in its cells.
  [[nodiscard]] bool is_one_still() const { return instances->is_one_still() && !surfaces; }
  /// Whether flights bring light besides that of their ends: of fires, or of lights that they pass.
  [[nodiscard]] bool flights_bring_light() const { return emission != nullptr || light.met.any(); }
  /// Whether scatterings in volumes sample fires as lights.
  [[nodiscard]] bool samples_fires() const {
    return emission != nullptr && emission->sampled_in_volumes;
  }

  /// Whether what is under way is to end. Asked at each collision and for each light: next to
  /// flights that costs nothing, and they may be long.
  [[nodiscard]] bool stopped() const { return stop->load(std::memory_order_relaxed); }
};

}  // namespace pvol::detail
