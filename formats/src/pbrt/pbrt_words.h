// The words of a scene of pbrt one after the other, through the files that it includes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pbrt/pbrt_params.h"

namespace pvol::formats::detail {

/// All but `next` throw Error, which names the place, for words that are not what they read.
class PbrtWords {
 public:
  explicit PbrtWords(const std::filesystem::path& file);

  /// Moves on to the next token, which `token` is then; false at the end of the first file.
  bool next();
  [[nodiscard]] const PbrtToken& token() const { return token_; }
  [[nodiscard]] const PbrtWhere& where() const { return token_.where; }

  /// Whether the next token is of a kind; it stays the next one.
  bool next_is(PbrtToken::Kind kind);

  // What comes next; `expected` is for errors.
  const PbrtToken& need(const char* expected);
  double number();
  Vec3d vector();
  std::string string(const char* expected);
  std::vector<double> matrix();  ///< 16 numbers, in brackets or not
  /// All parameters that follow, "float fov" 45 and so on.
  std::vector<PbrtParameter> parameters();

  /// Goes on in another file, whose name is relative to the folder of the first, as pbrt has it,
  /// else to that of the one at hand. `where` is the place that names it.
  void include(const std::string& name, const PbrtWhere& where);

  /// The files that were read so far, and those that parameters called filename refer to.
  [[nodiscard]] const std::vector<std::filesystem::path>& named() const { return named_; }

 private:
  PbrtParameter parameter();
  void value(PbrtParameter& p);

  std::filesystem::path folder_;   // of the first file
  std::vector<PbrtTokens> files_;  // that are being read, the outermost first
  std::vector<std::filesystem::path> named_;
  std::size_t read_ = 1;
  PbrtToken token_{};
  bool ahead_ = false;  // whether token_ is still to be taken
  PbrtWhere last_;
};

}  // namespace pvol::formats::detail
