// The look-ups of a volume's field, by their kind, and the field that trackers ask.
#pragma once

#include <type_traits>

#include "pvol/field/brick_field.h"
#include "pvol/field/procedural.h"
#include "pvol/track/field.h"
#include "pvol/volume/volume.h"

namespace pvol {

/// What look-ups of this kind read (track/field.h). Refers to the field.
template <LookUp kLookUp>
[[nodiscard]] auto extinction_source(const VolumeField& f) {
  if constexpr (kLookUp == LookUp::procedural) {
    return ProceduralExtinction{f.recipe(), f.octree, f.scale};
  } else {
    return BrickExtinction<kLookUp>{f.bricks(), f.octree, f.scale};
  }
}

/// The field of trackers: every question a look-up, or the field's micro-bounds first, whose edge
/// it must be; 0: none are used. Refers to the field.
template <LookUp kLookUp, int kMicroEdge>
[[nodiscard]] auto make_field(const VolumeField& f) {
  const auto source = extinction_source<kLookUp>(f);
  if constexpr (kMicroEdge == 0) {
    return PlainField{source};
  } else {
    return SqueezedField<kMicroEdge, std::remove_const_t<decltype(source)>>{source, f.micro};
  }
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

}  // namespace pvol
