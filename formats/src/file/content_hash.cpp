#include "pvol/formats/content_hash.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <fstream>
#include <memory>
#include <vector>

#include "pvol/error.h"

namespace pvol::formats {
namespace {

std::string to_text(XXH128_hash_t h) { return fmt::format("{:016x}{:016x}", h.high64, h.low64); }

}  // namespace

std::string content_hash(const std::filesystem::path& file) {
  constexpr std::size_t kBlock = 1 << 20;
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state{XXH3_createState(),
                                                                       XXH3_freeState};
  XXH3_128bits_reset(state.get());
  std::ifstream in(file, std::ios::binary);
  std::vector<char> block(kBlock);
  while (in) {
    in.read(block.data(), std::streamsize(block.size()));
    XXH3_128bits_update(state.get(), block.data(), std::size_t(in.gcount()));
  }
  if (!in.eof()) throw Error(file.string() + ": cannot be read");
  return to_text(XXH3_128bits_digest(state.get()));
}

std::string text_hash(const std::string& text) {
  return to_text(XXH3_128bits(text.data(), text.size()));
}

}  // namespace pvol::formats
