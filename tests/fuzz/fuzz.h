// What fuzz targets share. A target is one function, LLVMFuzzerTestOneInput, that gives bytes to a
// reader. Only Error may leave a reader; every other exception leaves the target too, and is a
// fault, as is what the sanitizers find.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>

#include "pvol/error.h"

/// libFuzzer calls this for every input; so does replay.cpp.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace pvol::fuzz {

using Input = std::span<const std::uint8_t>;

/// Calls `read`, which may refuse its input; tells whether it did not.
template <class Read>
bool accepts(const Read& read) {
  try {
    read();
    return true;
  } catch (const Error&) {
    return false;
  }
}

/// Throws std::logic_error, a fault of pvol, where something does not hold of what was read.
inline void require(bool holds, const std::string& what) {
  if (!holds) throw std::logic_error(what);
}

/// A file with these bytes, in memory where the system has a folder for that; valid until the next
/// call with the same name.
std::filesystem::path scratch_file(const std::string& name, Input bytes);

}  // namespace pvol::fuzz
