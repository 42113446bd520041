// The grids that a UsdVol Volume is made of.
#pragma once

#include "usda/usda_world.h"

namespace pvol::formats::detail {

struct UsdField {
  std::string role{};            ///< the name of its relationship, as "density"
  std::filesystem::path file{};  ///< absolute; a pattern where it is a sequence
  std::string grid{};            ///< its name in the file
  UsdWhere where{};
};

/// The fields of OpenVDB files. Others are named.
[[nodiscard]] std::vector<UsdField> fields_of(const UsdView& volume, const UsdMaking& making);

}  // namespace pvol::formats::detail
