// Damage to the parts of a .pvol file, with all sums made right again.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <string>

#include "pvol/formats/pvol_file.h"
#include "support/messages.h"
#include "support/pvol_bytes.h"
#include "support/pvol_content.h"

namespace pvol::test {

using Damage = std::function<void(PvolBytes&)>;

// Other values in a chunk that is not compressed.
inline Damage u32(std::size_t chunk, std::size_t at, std::uint32_t v) {
  return [=](PvolBytes& f) { f.put(chunk, at, v); };
}
inline Damage f32(std::size_t chunk, std::size_t at, float v) {
  return [=](PvolBytes& f) { f.put(chunk, at, v); };
}
inline Damage f64(std::size_t chunk, std::size_t at, double v) {
  return [=](PvolBytes& f) { f.put(chunk, at, v); };
}

/// Other text in META, the first chunk.
inline Damage meta(const std::string& from, const std::string& to) {
  return [=](PvolBytes& f) { f.replace_text(0, from, to); };
}

/// Expects that the file is refused with the error of this key, which tells its name.
inline void expect_refused(const PvolBytes& bad, const char* key) {
  const std::string error = error_of([&] { (void)formats::read_pvol(bad.bytes(), "a.pvol"); });
  EXPECT_TRUE(says(error, key));
  EXPECT_EQ(error.find("a.pvol"), 0u);
}

}  // namespace pvol::test
