// Films that can be gone on with and merged: EXR pictures with the exact sums in a part of their
// own, "sums". Other programs see the picture.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "pvol/formats/image.h"

namespace pvol::formats {

/// What can be told of a picture without its pixels.
struct PictureHeader {
  Film window;                                    ///< without pixels
  std::map<std::string, std::string> attributes;  ///< of type string, such as "pvol:seed"
  bool has_sums = false;
  /// As write_exr laid it out; the first ones of other programs' pictures.
  bool multipart = false;
  PixelType pixels = PixelType::single;
  ExrCompression compression = ExrCompression::zip;
};

/// Throws Error for files that are damaged, or cut off.
[[nodiscard]] PictureHeader read_picture_header(const std::filesystem::path& file);

/// A picture with its sums.
struct FilmFile {
  Film film;
  FilmRecord record;
  std::map<std::string, std::string> attributes;
};

/// Reads such pictures row by row: memory is that of the rows asked for. Throws Error for files
/// that are damaged, incomplete or without sums.
class FilmReader {
 public:
  explicit FilmReader(const std::filesystem::path& file);
  ~FilmReader();
  FilmReader(FilmReader&&) noexcept;

  /// The windows, first sample and layers of the film, without pixels.
  [[nodiscard]] const Film& window() const;
  [[nodiscard]] const FilmRecord& record() const;
  /// Of the picture, such as "pvol:seed".
  [[nodiscard]] const std::map<std::string, std::string>& attributes() const;

  /// Some rows of the film, of its crop from the top: with sums, and the others rounded from them.
  /// Throws Error where they are damaged.
  [[nodiscard]] Film rows(int begin, int count);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// All rows.
[[nodiscard]] FilmFile read_film_file(const std::filesystem::path& file);

}  // namespace pvol::formats
