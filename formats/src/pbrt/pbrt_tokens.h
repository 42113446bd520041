// The words of pbrt's scene files.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace pvol::formats::detail {

/// A place in a file, for messages.
struct PbrtWhere {
  std::shared_ptr<const std::string> file;
  std::size_t line = 0;
  [[nodiscard]] std::string text() const;  ///< "scene.pbrt:12"
};

/// Throws Error: "<place>: found <found>; expected <expected>".
[[noreturn]] void fail_at(const PbrtWhere& where, const std::string& found,
                          const std::string& expected);

struct PbrtToken {
  enum class Kind { word, string, open, close };  ///< open and close: brackets
  Kind kind = Kind::word;
  std::string_view text;  ///< of a string, without its quotes
  PbrtWhere where;
};

/// Cuts the text of a file into tokens. Comments run from # to the end of the line, which is CR, LF
/// or both. A UTF-8 byte order mark at the start is skipped.
class PbrtTokens {
 public:
  /// Reads the file. Throws Error where it cannot be read, and for names that end in .gz.
  explicit PbrtTokens(const std::filesystem::path& file);

  /// The next token; nothing at the end. Throws Error for a string without an end.
  [[nodiscard]] std::optional<PbrtToken> next();

  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] PbrtWhere where() const { return {name_, line_}; }

 private:
  void skip_blanks();

  std::filesystem::path file_;
  std::shared_ptr<const std::string> name_;
  std::shared_ptr<const std::string> text_;  // tokens point into it
  std::size_t at_ = 0, line_ = 1;
};

}  // namespace pvol::formats::detail
