#include "report/terminal.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "cli/columns.h"

namespace pvol::report {
namespace {

constexpr std::size_t kWidest = 118;  // of tables; names that make them wider get their own lines

/// Characters that a page has and not every terminal.
std::string plain(std::string text) {
  for (const auto& [from, to] : {std::pair<std::string_view, const char*>{"±", "+-"},
                                 std::pair<std::string_view, const char*>{"³", "^3"}}) {
    for (std::size_t at; (at = text.find(from)) != std::string::npos;) {
      text.replace(at, from.size(), to);
    }
  }
  return text;
}

/// Letters, not bytes.
std::size_t width_of(const std::string& text) {
  return std::size_t(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

/// Puts blocks one after the other, with a blank line where one is due.
class Printer {
 public:
  void operator()(const Heading&) { end_part(); }
  void operator()(const Text& t) { put(cli::wrapped(plain(t.text))); }
  void operator()(const Verdict& v) {
    put(cli::wrapped(plain(v.text)));
    if (!v.command.empty()) put("  " + v.command + '\n');
  }
  void operator()(const Figures&) {}
  void operator()(const Details& d) { put(d.text.ends_with('\n') ? d.text : d.text + '\n'); }
  void operator()(const Table& t) {
    end_part();
    if (!t.caption.empty()) put(cli::wrapped(plain(t.caption)));
    const std::size_t count = t.header.size(), split = t.split > 0 ? t.split : count;
    put_columns(t, 1, split);
    if (split < count) {
      end_part();
      put_columns(t, split, count);
    }
    end_part();
    if (!t.marked.empty() && !t.marks.empty()) put(cli::wrapped("* " + plain(t.marks)));
  }

  void put(const std::string& text) {
    if (due_ && !out_.empty()) out_ += '\n';
    due_ = false;
    out_ += text;
  }
  [[nodiscard]] std::string result() { return std::move(out_); }

 private:
  void end_part() { due_ = true; }

  /// The first column and those in [begin, end).
  void put_columns(const Table& t, std::size_t begin, std::size_t end) {
    std::vector<std::size_t> columns{0}, widths{0};
    std::size_t others = 2;
    for (std::size_t i = begin; i < end; ++i) {
      std::size_t width = width_of(plain(t.header[i]));
      for (const auto& row : t.rows) width = std::max(width, width_of(plain(row[i])));
      columns.push_back(i), widths.push_back(width);
      others += 2 + width;
    }
    for (const auto& row : t.rows) {
      const std::size_t width = width_of(plain(row[0]));
      if (others + width <= kWidest) widths[0] = std::max(widths[0], width);
    }
    widths[0] = std::max(widths[0], width_of(plain(t.header[0])));
    put_row(t.header, columns, widths, false);
    for (std::size_t r = 0; r < t.rows.size(); ++r) {
      const bool marked = std::find(t.marked.begin(), t.marked.end(), r) != t.marked.end();
      put_row(t.rows[r], columns, widths, marked);
    }
  }

  void put_row(const std::vector<std::string>& cells, const std::vector<std::size_t>& columns,
               const std::vector<std::size_t>& widths, bool marked) {
    std::string name = plain(cells[0]), line = marked ? "* " : "  ";
    if (width_of(name) > widths[0]) {
      put(line + name + '\n');
      name.clear(), line = "  ";
    }
    line += fmt::format("{:<{}}", name, widths[0]);
    for (std::size_t i = 1; i < columns.size(); ++i) {
      line += fmt::format("  {:>{}}", plain(cells[columns[i]]), widths[i]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    if (!line.empty()) put(line + '\n');
  }

  std::string out_;
  bool due_ = false;  // a blank line
};

}  // namespace

std::string to_terminal(const Document& d) {
  Printer print;
  print.put(cli::wrapped(d.lead.empty() ? d.subject + ':' : d.subject + ": " + d.lead));
  for (const Block& b : d.blocks) {
    if (b.shown != Shown::on_page) std::visit(print, b.content);
  }
  return print.result();
}

}  // namespace pvol::report
