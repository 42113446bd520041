// Handles of the C API, and what is set of them.
#include <cmath>
#include <new>
#include <string>

#include "capi/committed.h"
#include "capi/guard.h"
#include "pvol/given_density.h"
#include "pvol/version.h"

using namespace pvol;
using namespace pvol::detail;

namespace {

[[nodiscard]] FieldSamples& field_of(pvol_volume& volume, int field) {
  if (field < 0 || field >= PVOL_MOST_FIELDS) {
    throw Error("there is no field " + std::to_string(field) + "; expected 0, the density, to " +
                std::to_string(PVOL_MOST_FIELDS - 1));
  }
  return volume.settings.fields[std::size_t(field)];
}

template <class Samples>
[[nodiscard]] pvol_status set_samples(pvol_volume* volume, int field, const Samples* samples,
                                      bool shared = false) {
  return guarded(volume, [&] {
    FieldSamples& f = field_of(*volume, field);
    require_not_null(samples, "the description of the samples");
    require_cleared(samples->reserved);
    require_samples(*samples);
    if (shared && field != PVOL_DENSITY) {
      throw Error(
          "only samples of field 0, the density, can be shared; set those of other fields, which "
          "copies them");
    }
    f.from = *samples;
    f.shared = shared;
    f.changed.clear();
  });
}

[[nodiscard]] Affine affine_of(const double m[12]) {
  require_not_null(m, "the map from lattice points to the world");
  Affine a;
  for (int row = 0; row < 3; ++row) {
    a.m[std::size_t(row)] = {m[4 * row], m[4 * row + 1], m[4 * row + 2]};
    a.t[row] = m[4 * row + 3];
  }
  const Affine back = inverse(a);
  bool usable = is_finite(a.t) && is_finite(back.t);
  for (std::size_t row = 0; row < 3; ++row) {
    usable = usable && is_finite(a.m[row]) && is_finite(back.m[row]);
  }
  if (!usable) {
    throw Error(
        "the map from lattice points to the world is not finite or has no inverse; expected rows "
        "for x, y and z of the world, each with the translation last");
  }
  return a;
}

[[nodiscard]] LookUp look_up_of(pvol_interpolation interpolation) {
  switch (interpolation) {
    case PVOL_TRILINEAR:
      return LookUp::trilinear;
    case PVOL_NEAREST:
      return LookUp::nearest;
    case PVOL_TRICUBIC:
      return LookUp::tricubic;
  }
  throw Error("there is no interpolation " + std::to_string(int(interpolation)) +
              "; expected PVOL_TRILINEAR, PVOL_NEAREST or PVOL_TRICUBIC");
}

}  // namespace

extern "C" {

int pvol_api_version(void) { return PVOL_API_VERSION; }
const char* pvol_version(void) { return PVOL_VERSION; }

pvol_volume* pvol_new_volume(void) { return new (std::nothrow) pvol_volume; }

void pvol_retain(pvol_volume* volume) {
  if (volume != nullptr) volume->references.fetch_add(1, std::memory_order_relaxed);
}

void pvol_release(pvol_volume* volume) {
  if (volume != nullptr && volume->references.fetch_sub(1, std::memory_order_acq_rel) == 1) {
    delete volume;
  }
}

const char* pvol_message(const pvol_volume* volume) {
  return volume == nullptr ? "the volume is null" : volume->message.c_str();
}

pvol_status pvol_set_error_function(pvol_volume* volume, pvol_error_function function, void* user) {
  return guarded(volume, [&] {
    volume->error_function = function;
    volume->error_user = user;
  });
}

pvol_status pvol_set_array(pvol_volume* volume, int field, const pvol_array* array) {
  return set_samples(volume, field, array);
}

pvol_status pvol_set_bricks(pvol_volume* volume, int field, const pvol_bricks* bricks) {
  return set_samples(volume, field, bricks);
}

pvol_status pvol_set_leaves(pvol_volume* volume, int field, const pvol_leaves* leaves) {
  return set_samples(volume, field, leaves);
}

pvol_status pvol_share_array(pvol_volume* volume, int field, const pvol_array* array) {
  return set_samples(volume, field, array, true);
}

pvol_status pvol_share_leaves(pvol_volume* volume, int field, const pvol_leaves* leaves) {
  return set_samples(volume, field, leaves, true);
}

pvol_status pvol_clear_field(pvol_volume* volume, int field) {
  return guarded(volume, [&] {
    FieldSamples& f = field_of(*volume, field);
    f.from = FieldSamples::None{};
    f.shared = false;
    f.changed.clear();
  });
}

pvol_status pvol_set_changed(pvol_volume* volume, int field, const int32_t lo[3],
                             const int32_t hi[3]) {
  return guarded(volume, [&] {
    FieldSamples& f = field_of(*volume, field);
    require_not_null(lo, "the low corner of the box of changed samples");
    require_not_null(hi, "the high corner of the box of changed samples");
    const LatticeBox box{Vec3l(lo[0], lo[1], lo[2]), Vec3l(hi[0], hi[1], hi[2])};
    if (min_component(box.hi - box.lo) < 1) {
      throw Error(
          "the box of changed samples is empty; expected a high corner beyond the last changed "
          "sample");
    }
    f.changed.push_back(box);
  });
}

pvol_status pvol_set_transform(pvol_volume* volume, int field, const double m[12]) {
  return guarded(volume, [&] { field_of(*volume, field).index_to_world = affine_of(m); });
}

pvol_status pvol_set_extinction(pvol_volume* volume, double extinction) {
  return guarded(volume, [&] {
    if (!(extinction >= 0 && std::isfinite(extinction))) {
      throw Error("the extinction is " + std::to_string(extinction) +
                  "; expected a finite number of at least 0");
    }
    volume->settings.extinction = extinction;
  });
}

pvol_status pvol_set_extinction_color(pvol_volume* volume, const float share[3]) {
  return guarded(volume, [&] {
    require_not_null(share, "the array of the extinction's shares");
    const Rgb c(share[0], share[1], share[2]);
    if (!(is_finite(c) && min_component(c) >= 0 && max_component(c) == 1)) {
      throw Error("the shares of the extinction are (" + std::to_string(c.x) + ", " +
                  std::to_string(c.y) + ", " + std::to_string(c.z) +
                  "); expected numbers in [0, 1], of which the largest is 1");
    }
    volume->settings.share = c;
  });
}

pvol_status pvol_set_interpolation(pvol_volume* volume, pvol_interpolation interpolation) {
  return guarded(volume, [&] { volume->settings.look_up = look_up_of(interpolation); });
}

pvol_status pvol_set_shell(pvol_volume* volume, int wanted) {
  return guarded(volume, [&] { volume->settings.shell = wanted != 0; });
}

}  // extern "C"

pvol_status pvol::detail::set_density(pvol_volume* volume, const GetDensity& read) {
  return guarded(volume, [&] {
    std::shared_ptr<const BoundedDensity> given = read();
    FieldSamples& f = volume->settings.fields[PVOL_DENSITY];
    f.index_to_world = given->grid.index_to_world;
    f.from = std::move(given);
    f.shared = false;
    f.changed.clear();
  });
}
