// The prims of a scene that pvol makes something of, each with its place in the world.
#pragma once

#include <string>
#include <vector>

#include "usda/usda_xform.h"

namespace pvol::formats::detail {

struct UsdItem {
  const UsdPrim* prim = nullptr;
  std::string path{};
  UsdPlace place{};        ///< of instances, before theirs
  std::string material{};  ///< the path of what is bound to it, or to a prim around it; ""
  std::vector<UsdPlace> instances{};  ///< none: it is there once
};

struct UsdStage {
  UsdPrim root{};
  double frame = 0;
  bool is_chosen = false;  ///< whether somebody asked for that frame
  bool z_up = false;       ///< else y
  double metres = 0.01;    ///< of a unit
  double fps = 24;         ///< one time code is one frame
  std::vector<UsdItem> cameras{}, lights{}, volumes{}, surfaces{}, settings{}, products{};

  /// The prim at a path, or null.
  [[nodiscard]] const UsdPrim* find(const std::string& path) const;
  [[nodiscard]] UsdView view(const UsdPrim& prim) const { return UsdView(prim, frame); }
};

/// Gathers what is there and visible at the frame. Prims of other types are named in `notes`.
/// Without a frame it is the first.
[[nodiscard]] UsdStage stage_of(UsdPrim root, std::optional<int> frame, ImportNotes& notes);

/// The places of a PointInstancer's instances of each of so many prototypes, without those that are
/// inactive or invisible. They stay in place, as `notes` say, where others are there a frame later.
[[nodiscard]] std::vector<std::vector<UsdPlace>> instances_of(const UsdView& instancer,
                                                              std::size_t prototypes,
                                                              ImportNotes& notes);

}  // namespace pvol::formats::detail
