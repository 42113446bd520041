// What can be read: neither folders nor pipes.
#pragma once

#include <sys/stat.h>

#include <filesystem>

#include "pvol/error.h"

namespace pvol::formats::detail {

/// Throws Error for the mode, of stat, of what is no regular file.
inline void require_regular(const std::filesystem::path& file, mode_t mode) {
  if (S_ISDIR(mode)) throw Error(file.string() + ": is a folder; expected a file");
  if (!S_ISREG(mode)) throw Error("cannot read " + file.string() + ": expected a regular file");
}

}  // namespace pvol::formats::detail
