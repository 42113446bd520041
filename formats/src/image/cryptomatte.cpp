#include "image/cryptomatte.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <nlohmann/json.hpp>

namespace pvol::formats::detail {
namespace {

constexpr std::size_t kRanks = 6, kRanksOfLayer = 2;

std::uint32_t mix_block(std::uint32_t k) { return std::rotl(k * 0xcc9e2d51u, 15) * 0x1b873593u; }

}  // namespace

std::uint32_t hash_name(std::string_view name) {
  const auto byte = [&](std::size_t i) { return std::uint32_t(std::uint8_t(name[i])); };
  std::uint32_t h = 0;
  const std::size_t whole = name.size() / 4 * 4;
  for (std::size_t i = 0; i < whole; i += 4) {
    h ^= mix_block(byte(i) | byte(i + 1) << 8 | byte(i + 2) << 16 | byte(i + 3) << 24);
    h = std::rotl(h, 13) * 5 + 0xe6546b64u;
  }
  std::uint32_t rest = 0;
  for (std::size_t i = name.size(); i > whole; --i) rest = rest << 8 | byte(i - 1);
  if (whole < name.size()) h ^= mix_block(rest);
  h ^= std::uint32_t(name.size());
  h = (h ^ h >> 16) * 0x85ebca6bu;
  h = (h ^ h >> 13) * 0xc2b2ae35u;
  return h ^ h >> 16;
}

float object_id(std::string_view name) {
  std::uint32_t hash = hash_name(name);
  const std::uint32_t exponent = hash >> 23 & 255;
  if (exponent == 0 || exponent == 255) hash ^= 1u << 23;  // no denormal, infinity or NaN
  return std::bit_cast<float>(hash);
}

Cryptomatte::Cryptomatte(const Film& film)
    : film_(film), ranked_(std::numeric_limits<std::size_t>::max()) {
  const std::string_view prefix = kObjectLayer;
  for (const Layer& layer : film.layers) {
    if (!layer.name.starts_with(prefix)) continue;
    const std::string name = layer.name.substr(prefix.size());
    objects_.push_back({&layer, name, object_id(name)});
  }
}

std::vector<std::string> Cryptomatte::channels() {
  std::vector<std::string> names;
  for (std::size_t layer = 0; layer < kRanks / kRanksOfLayer; ++layer) {
    for (const char c : {'R', 'G', 'B', 'A'}) {
      names.push_back(fmt::format("{}{:02}.{}", kCryptomatte, layer, c));
    }
  }
  return names;
}

void Cryptomatte::rank(std::size_t pixel) const {
  ranks_.clear();
  for (const Object& o : objects_) {
    const auto coverage = float(pvol::value(*o.layer, film_, pixel).x);
    if (coverage > 0) ranks_.push_back({o.id, coverage});
  }
  std::ranges::stable_sort(ranks_, std::ranges::greater(), &Rank::coverage);
  ranks_.resize(kRanks);
  ranked_ = pixel;
}

double Cryptomatte::value(std::size_t channel, std::size_t pixel) const {
  if (pixel != ranked_) rank(pixel);
  const Rank& r = ranks_[channel / 2];
  return double(channel % 2 == 0 ? r.id : r.coverage);
}

std::map<std::string, std::string> Cryptomatte::attributes() const {
  nlohmann::json manifest = nlohmann::json::object();
  for (const Object& o : objects_) {
    manifest[o.name] = fmt::format("{:08x}", std::bit_cast<std::uint32_t>(o.id));
  }
  const std::string key =
      "cryptomatte/" + fmt::format("{:08x}", hash_name(kCryptomatte)).substr(0, 7) + "/";
  return {{key + "name", kCryptomatte},
          {key + "hash", "MurmurHash3_32"},
          {key + "conversion", "uint32_to_float32"},
          {key + "manifest", manifest.dump()}};
}

}  // namespace pvol::formats::detail
