#include "render/denoise/frame_planes.h"

#include <algorithm>
#include <cmath>

#include "pvol/error.h"
#include "pvol/math/parallel.h"
#include "render/film/window.h"
#include "render/scene/projection.h"

namespace pvol::detail {
namespace {

/// A component of a feature in its own units, or another value where the film does not tell it.
class Component {
 public:
  Component(const Features& features, FeatureKind kind, int component, double otherwise)
      : centre_(otherwise) {
    const auto of = std::ranges::find_if(features.scales, [&](const FeatureScale& s) {
      return s.kind == kind && s.component == component;
    });
    if (of == features.scales.end()) return;
    centre_ = of->centre, spread_ = of->spread;
    if (of->plane) plane_ = &features.planes[*of->plane];
  }
  [[nodiscard]] double at(int x, int y) const {
    return plane_ ? centre_ + spread_ * double(plane_->row(y)[x]) : centre_;
  }
  /// Whether it is the same, and this, everywhere.
  [[nodiscard]] bool is(double value) const { return plane_ == nullptr && centre_ == value; }

 private:
  const Plane* plane_ = nullptr;
  double centre_, spread_ = 1;
};

/// How far what pixels show moves from a frame to another, in world units.
class Ways {
 public:
  Ways(const FramePlanes& from, double frames) : frames_(from.velocity ? frames : 0) {
    if (!from.velocity) return;
    for (int axis = 0; axis < 3; ++axis) {
      velocity_.emplace_back(*from.velocity, FeatureKind::velocity, axis, 0.0);
    }
  }
  [[nodiscard]] bool any() const {
    return frames_ != 0 && std::ranges::any_of(velocity_, [](const auto& v) { return !v.is(0); });
  }
  [[nodiscard]] Vec3d at(int x, int y) const {
    if (frames_ == 0) return {};
    return Vec3d(velocity_[0].at(x, y), velocity_[1].at(x, y), velocity_[2].at(x, y)) * frames_;
  }

 private:
  double frames_;
  std::vector<Component> velocity_;
};

/// Where each pixel's point lies in another frame: its pixel there, and how much deeper it is.
struct Places {
  std::vector<int> pixel;  ///< -1: not in the picture
  std::vector<float> deeper;
};

/// Of a frame that shows the same in the same pixels.
Places same_places(int width, int height) {
  Places p;
  for (int i = 0; i < width * height; ++i) p.pixel.push_back(i);
  p.deeper.assign(p.pixel.size(), 0);
  return p;
}

Places find_places(const FramePlanes& other, const FramePlanes& own) {
  const Film& w = own.window;
  const auto& from = own.view.camera;
  const auto& to = other.view.camera;
  const Ways ways(own, other.view.time - own.view.time);
  if (!from || !to || (*from == *to && !ways.any())) {
    return same_places(w.crop_width, w.crop_height);
  }
  const Projection here(*from, w.width, w.height);
  const Projection there(*to, w.width, w.height);
  const Component depths(own.features, FeatureKind::depth, 0, kNothingMet);
  const std::size_t size = std::size_t(w.crop_width) * std::size_t(w.crop_height);
  Places p{std::vector<int>(size, -1), std::vector<float>(size)};
  parallel_for(0, std::size_t(w.crop_height), [&](std::size_t row) {
    for (int x = 0; x < w.crop_width; ++x) {
      const int y = int(row);
      const double depth = depths.at(x, y);
      const Vec3d place = here.place(w.x + x + 0.5, w.y + y + 0.5, depth) + ways.at(x, y);
      const auto seen = there.seen(place);
      if (!seen) continue;
      const double px = std::floor((*seen)[0]) - w.x, py = std::floor((*seen)[1]) - w.y;
      if (!(px >= 0 && px < w.crop_width && py >= 0 && py < w.crop_height)) continue;
      const std::size_t i = w.index(x, y);
      p.pixel[i] = int(w.index(int(px), int(py)));
      p.deeper[i] = float(there.depth(place) - depth);
    }
  });
  return p;
}

/// A plane of the other frame in the pixels of this one: value(number of the pixel here, value
/// there).
template <class F>
Plane take(const Plane& from, const Places& places, int margin, const F& value) {
  Plane to(from.width(), from.height(), margin);
  const int width = from.width();
  parallel_for(0, std::size_t(from.height()), [&](std::size_t y) {
    for (int x = 0; x < width; ++x) {
      const std::size_t i = y * std::size_t(width) + std::size_t(x);
      const int at = std::max(0, places.pixel[i]);
      to.row(int(y))[x] = value(i, from.row(at / width)[at % width]);
    }
  });
  to.repeat_edges();
  return to;
}

Planes take_scaled(const Planes& from, const Places& places, int margin, double scale) {
  Planes to;
  for (const Plane& p : from) {
    to.push_back(take(p, places, margin, [&](std::size_t, float v) { return v * float(scale); }));
  }
  return to;
}

/// The other frame's plane of a feature in this one's units; where that is the same all over the
/// other frame, or unknown there, its one value or the middle.
Plane take_feature(const FramePlanes& other, const FeatureScale& own, const Places& places,
                   int margin) {
  const auto same = [&](const FeatureScale& s) {
    return s.kind == own.kind && s.component == own.component;
  };
  const auto found = std::ranges::find_if(other.features.scales, same);
  const FeatureScale theirs = found == other.features.scales.end() ? own : *found;
  const bool varies = found != other.features.scales.end() && theirs.plane.has_value();
  const Plane& from = varies ? other.features.planes[*theirs.plane] : other.halves.filtered;
  const double slope = varies ? theirs.spread / own.spread : 0;
  const double at_zero = (theirs.centre - own.centre) / own.spread;
  const double of_depth = own.kind == FeatureKind::depth ? 1 / own.spread : 0;
  return take(from, places, margin, [&](std::size_t i, float v) {
    return float(at_zero + slope * double(v) - of_depth * double(places.deeper[i]));
  });
}

Planes take_features(const FramePlanes& other, const FramePlanes& own, const Places& places,
                     int margin) {
  Planes to{own.features.planes[0], own.features.planes[1]};  // a point has one place: that here
  to.resize(own.features.planes.size());
  for (const FeatureScale& s : own.features.scales) {
    if (s.plane) to[*s.plane] = take_feature(other, s, places, margin);
  }
  return to;
}

void check_alike(const FramePlanes& other, const FramePlanes& own) {
  if (!have_same_window(other.window, own.window)) {
    throw Error("denoise: the frames differ in size or crop; expected one for all of a sequence");
  }
  if (other.window.color_space != own.window.color_space) {
    throw Error("denoise: the frames differ in colour space; expected one for all of a sequence");
  }
  if (other.names != own.names) {
    throw Error(
        "denoise: the frames have different layers of light; render all of a sequence "
        "with the same --aov and lights");
  }
}

}  // namespace

FramePlanes make_frame_planes(const Film& film, const PatchOptions& patches, const FrameView& view,
                              const std::function<bool()>& stop) {
  const int margin = margin_of(patches);
  FramePlanes f;
  f.patches = patches, f.view = view;
  f.halves = make_halves(film, margin);
  f.features = make_features(film, margin, stop);
  if (view.camera) f.velocity = make_velocity(film, margin, stop);
  const std::vector<ColourParts> sets = find_colour_parts(film);
  f.parts = planes_of_parts(film, sets, f.halves, margin);
  for (const ColourParts& parts : sets) {
    for (const std::size_t k : parts) f.names.push_back(film.layers[k].name);
  }
  f.window = window_of(film);
  return f;
}

AlignedFrame align(const FramePlanes& other, const FramePlanes& own) {
  check_alike(other, own);
  const Places places = find_places(other, own);
  const int margin = margin_of(own.patches);
  const double scale = other.halves.scale / own.halves.scale;
  AlignedFrame a;
  for (const std::size_t half : {0u, 1u}) {
    const Guide& from = other.halves.colour[half];
    a.colour[half].values = take_scaled(from.values, places, margin, scale);
    a.colour[half].variances = take_scaled(from.variances, places, margin, scale * scale);
  }
  a.parts = take_scaled(other.parts, places, margin, scale);
  a.features = take_features(other, own, places, margin);
  a.known = take(other.halves.filtered, places, margin,
                 [&](std::size_t i, float) { return places.pixel[i] >= 0 ? 1.0f : 0.0f; });
  return a;
}

}  // namespace pvol::detail
