// The look-ups of a volume's field, by their kind, and the field that trackers ask.
#pragma once

#include <type_traits>

#include "pvol/field/brick_field.h"
#include "pvol/field/procedural.h"
#include "pvol/field/shared_field.h"
#include "pvol/math/field_map.h"
#include "pvol/track/field.h"
#include "pvol/volume/volume.h"

namespace pvol {

/// What look-ups of this kind read (track/field.h), where some fields may share samples or none
/// does. Refers to the field.
template <LookUp kLookUp, bool kShared = false>
[[nodiscard]] auto extinction_source(const VolumeField& f) {
  if constexpr (kShared) {
    const bool shares = f.shares_samples();
    return SharedExtinction<kLookUp>{shares ? &f.shared() : nullptr, shares ? nullptr : &f.bricks(),
                                     f.octree, f.scale};
  } else if constexpr (kLookUp == LookUp::procedural) {
    return ProceduralExtinction{f.recipe(), f.octree, f.scale};
  } else {
    return BrickExtinction<kLookUp>{f.bricks(), f.octree, f.scale};
  }
}

/// A source whose densities are mapped before they become mu_t. Refers to the map.
template <class Source>
struct MappedExtinction {
  static constexpr LookUp kLookUp = Source::kLookUp;

  Source source;  ///< of scale 1
  const FieldMap& map;
  float scale;

  [[nodiscard]] float operator()(const Segment& s, const LatticePoint& p) const {
    return scale * value_at(map, source(s, p));
  }
  /// The density at a point of the cube with a handle, without the scale.
  [[nodiscard]] float density(LeafHandle leaf, const LatticePoint& p) const {
    return value_at(map, source.density(leaf, p));
  }
};

/// What look-ups of a field with a map read. Refers to the field.
template <LookUp kLookUp, bool kShared = false>
[[nodiscard]] auto mapped_source(const VolumeField& f) {
  auto source = extinction_source<kLookUp, kShared>(f);
  source.scale = 1;
  return MappedExtinction<decltype(source)>{source, *f.map, f.scale};
}

/// What a field has to decide collisions by.
[[nodiscard]] inline Squeeze squeeze_of(const VolumeField& f) {
  if (f.codes != nullptr) return Squeeze::codes;
  return f.micro.edge != 0 ? Squeeze::micro_bounds : Squeeze::none;
}

/// The field of trackers: every question a look-up, or bounds first, which the field has. Refers to
/// the field.
template <LookUp kLookUp, Squeeze kSqueeze, bool kShared = false>
[[nodiscard]] auto make_field(const VolumeField& f) {
  using Source = decltype(extinction_source<kLookUp, kShared>(f));
  const Source source = extinction_source<kLookUp, kShared>(f);
  if constexpr (kSqueeze == Squeeze::none) {
    return PlainField{source};
  } else if constexpr (kSqueeze == Squeeze::codes) {
    return SqueezedField<CodeBounds<kLookUp>, Source>{source, {*f.codes}};
  } else {
    return SqueezedField<CubeBounds, Source>{source, {f.micro}};
  }
}

/// f(constant), and its result, with what decides collisions in a field as a
/// std::integral_constant.
template <LookUp kLookUp, class F>
decltype(auto) visit_squeeze(Squeeze squeeze, const F& f) {
  switch (squeeze) {
    case Squeeze::micro_bounds:
      return f(std::integral_constant<Squeeze, Squeeze::micro_bounds>{});
    case Squeeze::codes:
      if constexpr (has_closed_form(kLookUp)) {
        return f(std::integral_constant<Squeeze, Squeeze::codes>{});
      }
      break;  // are not made
    case Squeeze::none:
      break;
  }
  return f(std::integral_constant<Squeeze, Squeeze::none>{});
}

/// f(constant), and its result, with the field's kind of look-up as a std::integral_constant.
template <class F>
decltype(auto) visit_look_up(LookUp look_up, const F& f) {
  switch (look_up) {
    case LookUp::nearest:
      return f(std::integral_constant<LookUp, LookUp::nearest>{});
    case LookUp::tricubic:
      return f(std::integral_constant<LookUp, LookUp::tricubic>{});
    case LookUp::procedural:
      return f(std::integral_constant<LookUp, LookUp::procedural>{});
    case LookUp::trilinear:
      break;
  }
  return f(std::integral_constant<LookUp, LookUp::trilinear>{});
}

/// The same where look-ups have closed forms.
template <class F>
decltype(auto) visit_closed_look_up(LookUp look_up, const F& f) {
  if (look_up == LookUp::nearest) return f(std::integral_constant<LookUp, LookUp::nearest>{});
  return f(std::integral_constant<LookUp, LookUp::trilinear>{});
}

/// f(source), and its result, with the field's source, mapped or not.
template <class F>
decltype(auto) visit_source(const VolumeField& field, const F& f) {
  const auto visit = [&](auto look_up, auto shared) {
    return field.map != nullptr ? f(mapped_source<look_up, shared>(field))
                                : f(extinction_source<look_up, shared>(field));
  };
  if (field.shares_samples()) {
    return visit_closed_look_up(field.look_up,
                                [&](auto look_up) { return visit(look_up, std::true_type{}); });
  }
  return visit_look_up(field.look_up,
                       [&](auto look_up) { return visit(look_up, std::false_type{}); });
}

}  // namespace pvol
