// Opinions about the same prim, put together.
#pragma once

#include "usda/usda_prim.h"

namespace pvol::formats::detail {

/// Adds to a prim what a weaker one says that it does not say itself.
void merge(UsdPrim& strong, UsdPrim weak);

/// Moves the targets of all attributes in a prim from what lies under one path to another.
void move_targets(UsdPrim& prim, const std::string& from, const std::string& to);

/// About as much memory as a copy takes.
[[nodiscard]] std::size_t bytes_of(const UsdPrim& prim);

}  // namespace pvol::formats::detail
