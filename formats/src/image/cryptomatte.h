// Which object covers how much of a pixel, as compositing programs read it: Cryptomatte. Based on:
// Psyop, Cryptomatte Specification, version 1.2.0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "pvol/render/film.h"

namespace pvol::formats::detail {

/// Name of the layer, with which the names of all its channels begin.
inline constexpr const char* kCryptomatte = "CryptoObject";

/// The 32-bit hash of a name (MurmurHash3 of A. Appleby, x86, seed 0).
[[nodiscard]] std::uint32_t hash_name(std::string_view name);

/// The id of an object: the float of its name's hash, made finite and normal.
[[nodiscard]] float object_id(std::string_view name);

/// The objects of a film with layers of objects, from the one that covers most of a pixel down to
/// the sixth.
class Cryptomatte {
 public:
  /// The film outlives this.
  explicit Cryptomatte(const Film& film);

  [[nodiscard]] bool empty() const { return objects_.empty(); }
  /// "CryptoObject00.R" and so on: ids and coverages of two objects in each layer.
  [[nodiscard]] static std::vector<std::string> channels();
  /// Of a channel by its place among them. Not to be called by several threads.
  [[nodiscard]] double value(std::size_t channel, std::size_t pixel) const;
  /// The attributes of a header, with the names of all objects.
  [[nodiscard]] std::map<std::string, std::string> attributes() const;

 private:
  struct Object {
    const Layer* layer;
    std::string name;
    float id;
  };
  struct Rank {
    float id = 0, coverage = 0;
  };
  void rank(std::size_t pixel) const;

  const Film& film_;
  std::vector<Object> objects_;
  mutable std::size_t ranked_;  ///< the pixel that `ranks_` are of
  mutable std::vector<Rank> ranks_;
};

}  // namespace pvol::formats::detail
