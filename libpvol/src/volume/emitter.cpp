#include "pvol/volume/emitter.h"

#include "pvol/volume/value_field.h"

namespace pvol {

Emitter make_emitter(const Fire& fire, const BoundedGrid& field, const BoundedGrid* color_by,
                     const Affine& object_to_world) {
  validate(fire);
  Emitter e{.fire = fire, .field = make_value_field(field, fire.map, object_to_world, "fires")};
  if (color_by != nullptr && fire.colored()) {
    e.color_by = make_value_field(*color_by, {}, object_to_world, "fires");
  }
  return e;
}

Rgb emission_at(const Emitter& e, Vec3d world) {
  const float value = value_at(e.field, world);
  return emission(e.fire, value, e.color_by ? value_at(*e.color_by, world) : value);
}

}  // namespace pvol
