// Reports as documents: what a verb measured, as blocks in order, which a terminal (terminal.h) and
// a page (html.h) print.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace pvol::report {

/// Begins a part: a heading on a page, a blank line in a terminal.
struct Heading {
  std::string text;
};

/// A paragraph.
struct Text {
  std::string text;
};

/// A paragraph that stands out. On a page `good` and `bad` also differ in their sign, not in colour
/// alone.
enum class Mood { plain, good, bad };
struct Verdict {
  std::string text;
  Mood mood = Mood::plain;
  std::string command{};  ///< to be typed as it is; none where empty
};

/// The first column is set left, as names, the others right, as numbers.
struct Table {
  std::string caption{};
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows{};  ///< each as long as the header
  std::vector<std::size_t> marked{};             ///< rows that stand out
  std::string marks{};    ///< what those are: "on the Pareto front of time and bytes"
  std::size_t split = 0;  ///< a terminal shows columns from this one on in a table of their own
};

/// An <svg> or <img> with a line below it.
struct Figure {
  std::string markup;
  std::string caption;
};
/// Side by side where the page is wide enough. Terminals show none.
struct Figures {
  std::vector<Figure> figures;
};

/// What may be looked up, closed at first on a page; its lines are kept.
struct Details {
  std::string summary, text;
};

using Content = std::variant<Heading, Text, Verdict, Table, Figures, Details>;

/// Some blocks belong to one printer only: what pages draw, terminals tell in a line, and what is
/// to be read first stands at the top of a page but at the end in a terminal.
enum class Shown { everywhere, on_terminal, on_page };

struct Block {
  Content content;
  Shown shown = Shown::everywhere;
};

/// Texts may hold what file names hold: printers escape them. "±" and "³" become "+-" and "^3" in
/// terminals.
struct Document {
  std::string title;    ///< of the page
  std::string subject;  ///< the terminal's first line is "subject: lead", to wit a file's name
  std::string lead;     ///< the page's first paragraph, as a sentence
  std::vector<Block> blocks{};
};

inline void add(Document& document, Content content, Shown shown = Shown::everywhere) {
  document.blocks.push_back({std::move(content), shown});
}
inline void add(Document& document, const std::vector<Content>& part, Shown shown) {
  for (const Content& c : part) add(document, c, shown);
}

}  // namespace pvol::report
