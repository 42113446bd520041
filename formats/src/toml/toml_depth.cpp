#include "toml/toml_depth.h"

#include <algorithm>
#include <vector>

namespace pvol::formats::detail {
namespace {

/// Reads a text character by character. Text that is not TOML is the parser's business: here it may
/// count as anything.
class DepthScan {
 public:
  explicit DepthScan(std::string_view text) : text_(text) {}

  std::size_t run() {
    while (at_ < text_.size()) {
      take(text_[at_]);
      if (depth_ > kDeepestToml) return line_;
    }
    return 0;
  }

 private:
  void take(char c) {
    if (c == '#') {
      at_ = std::min(text_.find('\n', at_), text_.size());
    } else if (c == '\n') {
      ++at_;
      end_line();
    } else if (c == ' ' || c == '\t' || c == '\r') {
      ++at_;
    } else if (begins_) {
      begin_statement(c);
    } else if (c == '"' || c == '\'') {
      skip_string(c);
    } else {
      ++at_;
      // The dot of a number counts, too, until the next comma or the end of the line.
      if (c == '.') ++depth_;
      if (!in_header_) take_bracket(c);
    }
  }

  void begin_statement(char c) {
    begins_ = false;
    in_header_ = c == '[';
    depth_ = in_header_ ? 1 : header_ + 1;
    if (in_header_) ++at_;
  }

  void take_bracket(char c) {
    if (c == '[' || c == '{') {
      around_.push_back(depth_);
      ++depth_;
    } else if ((c == ']' || c == '}') && !around_.empty()) {
      depth_ = around_.back();
      around_.pop_back();
    } else if (c == ',' && !around_.empty()) {
      depth_ = around_.back() + 1;
    }
  }

  /// A statement ends with its line, but for what brackets keep together; a key does in any case,
  /// or each line after a forgotten bracket would seem to nest in the one before it.
  void end_line() {
    ++line_;
    if (!around_.empty()) {
      depth_ = around_.back() + 1;
      return;
    }
    if (in_header_) header_ = depth_;
    in_header_ = false;
    begins_ = true;
  }

  /// Skips a string in one or three quotes; one in one quote ends at the end of the line at the
  /// latest.
  void skip_string(char quote) {
    std::string_view end = quote == '"' ? R"(""")" : "'''";
    const bool many = text_.substr(at_).starts_with(end);
    if (!many) end.remove_suffix(2);
    at_ += end.size();
    while (at_ < text_.size() && !text_.substr(at_).starts_with(end)) {
      if (text_[at_] == '\n' && !many) return;
      const bool escape = text_[at_] == '\\' && quote == '"';
      if (text_[at_] == '\n' || (escape && text_.substr(at_ + 1).starts_with('\n'))) ++line_;
      at_ += escape ? 2 : 1;
    }
    at_ += end.size();
  }

  std::string_view text_;
  std::size_t at_ = 0, line_ = 1;
  std::size_t depth_ = 0, header_ = 0;  // of what comes next, and of the last [header]
  std::vector<std::size_t> around_;     // depths outside the brackets that are open
  bool begins_ = true;                  // a statement
  bool in_header_ = false;
};

}  // namespace

std::size_t find_too_deep(std::string_view toml) { return DepthScan(toml).run(); }

}  // namespace pvol::formats::detail
