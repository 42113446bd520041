// What a film that can be gone on with says of itself.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace pvol::formats {

/// A rectangle of an image with samples of one seed.
struct FilmPiece {
  std::uint64_t seed = 0;
  int x = 0, y = 0, width = 0, height = 0;
  std::uint32_t begin = 0, end = 0;  ///< numbers of each pixel's samples; adaptive: 0, 0
  bool complete = false;             ///< whether all of them are there
  friend bool operator==(const FilmPiece&, const FilmPiece&) = default;
};

struct FilmRecord {
  /// Of the scene and the contents of its clouds: films with another key are of other pictures.
  std::string key;
  std::vector<FilmPiece> pieces;  ///< what samples there are; that of a render is one
  friend bool operator==(const FilmRecord&, const FilmRecord&) = default;
};

}  // namespace pvol::formats
