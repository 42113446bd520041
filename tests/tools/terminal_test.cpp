#include "report/terminal.h"

#include <gtest/gtest.h>

namespace pvol::report {
namespace terminal_test {

Table small_table() {
  return {.caption = "sizes",
          .header = {"name", "a", "bb"},
          .rows = {{"x", "1", "22³"}, {"yy", "3 ± 1", ""}}};
}

TEST(Terminal, PrintsWhatIsForIt) {
  Document d{.title = "the page's", .subject = "cloud.vdb", .lead = "a lead"};
  add(d, Text{"for both"});
  add(d, Text{"for pages"}, Shown::on_page);
  add(d, Text{"for terminals"}, Shown::on_terminal);
  add(d, Figures{{{"<svg></svg>", "a plot"}}});
  add(d, Heading{"a part"});
  add(d, Verdict{"good news", Mood::good, "type this"});
  add(d, Details{"more", "line 1\n  line 2"});
  EXPECT_EQ(to_terminal(d),
            "cloud.vdb: a lead\nfor both\nfor terminals\n\ngood news\n  type this\nline 1\n  line "
            "2\n");
  EXPECT_EQ(to_terminal({.title = "", .subject = "cloud.vdb", .lead = ""}), "cloud.vdb:\n");
}

TEST(Terminal, SetsColumnsInTheirWidthsAndLeavesBlankLinesAroundTables) {
  Document d{.title = "", .subject = "s", .lead = "l"};
  add(d, small_table());
  add(d, Text{"end"});
  EXPECT_EQ(to_terminal(d),
            "s: l\n\nsizes\n  name       a    bb\n  x          1  22^3\n  yy    3 +- 1\n\nend\n");
}

TEST(Terminal, MarksRowsAndSaysWhatTheyAre) {
  Table t = small_table();
  t.caption.clear(), t.marked = {1}, t.marks = "the best";
  Document d{.title = "", .subject = "s", .lead = "l"};
  add(d, t);
  const std::string text = to_terminal(d);
  EXPECT_NE(text.find("\n  x "), std::string::npos);
  EXPECT_NE(text.find("\n* yy "), std::string::npos);
  EXPECT_NE(text.find("\n\n* the best\n"), std::string::npos);
}

TEST(Terminal, SplitsTablesAndGivesLongNamesTheirOwnLine) {
  Table t{.header = {"n", "a", "b"}, .rows = {{"x", "1", "2"}}, .split = 2};
  Document d{.title = "", .subject = "s", .lead = "l"};
  add(d, t);
  EXPECT_EQ(to_terminal(d), "s: l\n\n  n  a\n  x  1\n\n  n  b\n  x  2\n");
  const std::string name(130, 'y');
  t.rows.push_back({name, "3", "4"}), t.split = 0;
  d.blocks = {{t}};
  EXPECT_EQ(to_terminal(d), "s: l\n\n  n  a  b\n  x  1  2\n  " + name + "\n     3  4\n");
}

}  // namespace terminal_test
}  // namespace pvol::report
