// The words of usda text.
#pragma once

#include <string>
#include <string_view>

#include "usda/usda_where.h"

namespace pvol::formats::detail {

struct UsdToken {
  enum class Kind {
    word,    ///< an identifier, with its namespaces and what follows a dot: primvars:st.connect
    number,  ///< with inf and nan
    string,
    asset,  ///< @a.vdb@
    path,   ///< </World/cloud>
    mark,   ///< a character such as ( or =
    end,    ///< of the file
  };
  Kind kind = Kind::end;
  std::string_view text{};  ///< as it is in the file, without what encloses it
  double number = 0;
  std::size_t line = 1, column = 1;

  [[nodiscard]] bool is(char mark) const { return kind == Kind::mark && text.front() == mark; }
  [[nodiscard]] bool is(std::string_view word) const { return kind == Kind::word && text == word; }
};

/// Cuts the text of a file into tokens. Comments are left out.
class UsdTokens {
 public:
  /// Reads the file. Throws Error where it cannot be read, and for what is no usda text: binary
  /// files and packages with the command that makes text of them.
  explicit UsdTokens(const std::filesystem::path& file);

  [[nodiscard]] const UsdToken& peek() const { return next_; }
  UsdToken take();  ///< at the end of the file, its end again and again

  /// Takes the next token where it is this character.
  bool take_if(char mark);
  /// The same, or throws Error.
  void need(char mark, const std::string& expected);

  [[nodiscard]] UsdWhere where(const UsdToken& t) const { return {file_, t.line, t.column}; }
  [[nodiscard]] UsdWhere where() const { return where(next_); }
  [[nodiscard]] const std::filesystem::path& file() const { return *file_; }

  /// Throws Error: that the next token was found where something else was expected.
  [[noreturn]] void fail(const std::string& expected) const;

 private:
  void skip_blanks();
  void advance(std::size_t count);  // over characters of any kind
  [[nodiscard]] UsdToken scan();
  [[nodiscard]] UsdToken enclosed(UsdToken::Kind kind, std::string_view open,
                                  std::string_view close);

  std::shared_ptr<const std::filesystem::path> file_;
  std::string text_;  // tokens point into it
  std::size_t at_ = 0, line_ = 1, line_begin_ = 0;
  UsdToken next_{};
};

/// The text of a string without its escapes, as \n and \".
[[nodiscard]] std::string unescaped(std::string_view text);

}  // namespace pvol::formats::detail
