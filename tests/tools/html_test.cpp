#include "report/html.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <regex>

#include "report/colour_map.h"
#include "report/svg.h"
#include "support/html_check.h"
#include "support/temporary_folder.h"

namespace pvol::html {
namespace html_test {

TEST(Html, EscapesWhatHasAMeaning) {
  EXPECT_EQ(escape("<a href=\"x\">&'</a>"), "&lt;a href=&quot;x&quot;&gt;&amp;&#39;&lt;/a&gt;");
  EXPECT_EQ(escape("Wölkchen ☁ 𝛕\n\t"), "Wölkchen ☁ 𝛕\n\t");
}

TEST(Html, BytesThatAreNoTextAreReplaced) {
  const std::string r = "\xEF\xBF\xBD";
  EXPECT_EQ(escape("a\xFF"
                   "b"),
            "a" + r + "b");
  EXPECT_EQ(escape("\xC3"), r);                                     // cut short
  EXPECT_EQ(escape("\xC0\xAF"), r + r);                             // overlong '/'
  EXPECT_EQ(escape("\xE0\x80\xBC"), r + r + r);                     // overlong '<'
  EXPECT_EQ(escape("\xED\xA0\x80"), r + r + r);                     // a surrogate
  EXPECT_EQ(escape("\xF4\x90\x80\x80"), r + r + r + r);             // beyond Unicode
  EXPECT_EQ(escape(std::string_view("\0\x1B\x7F", 3)), r + r + r);  // control characters
}

TEST(Html, ImagesHoldTheirBytes) {
  const auto bytes = [](std::string_view s) { return std::as_bytes(std::span(s)); };
  EXPECT_NE(image(bytes("Man"), "a", false).find("base64,TWFu\""), std::string::npos);
  EXPECT_NE(image(bytes("Ma"), "a", false).find("base64,TWE=\""), std::string::npos);
  EXPECT_NE(image(bytes("M"), "\"", true).find("alt=\"&quot;\""), std::string::npos);
  EXPECT_NE(image(bytes("M"), "a", true).find("base64,TQ==\""), std::string::npos);
}

svg::Plot some_plot() {
  svg::Plot p;
  p.title = "A & B <C>";
  p.x = {"x \"quoted\"", true};
  p.y = {"y", false};
  svg::Series s{"points", {}, svg::Style::points};
  for (int i = 0; i < 40; ++i) {
    s.points.push_back(
        {std::exp(0.01 * i), std::sin(0.02 * i), 0.1, "setting " + std::to_string(i)});
  }
  p.series = {s,
              {"front", {{1, 0.5}, {1.2, 0.3}, {1.4, 0.1}}, svg::Style::steps},
              {"curve", {{1, 0.1}, {2, 0.2}}, svg::Style::curve, 3, true}};
  p.bars = {{"bars", {{1, 1.1, 0.4}, {1.1, 1.2, 0.3}}}};
  return p;
}

TEST(Html, WholePagesAreWellFormed) {
  using report::Mood;
  report::Document page{.title = "\xFFile <& \"name\".exr", .subject = "<s>", .lead = "a <lead>"};
  add(page, report::Heading{"<h>"});
  add(page, report::Text{"a < b & c"});
  add(page, report::Verdict{"no bias", Mood::good, "type <this>"});
  add(page, report::Verdict{"bias", Mood::bad});
  add(page, report::Table{"caption", {"a", "<b>"}, {{"1", "2"}, {"&", "\""}}, {1}, "<marked>"});
  add(page, report::Figures{{{svg::draw(some_plot()), "a <plot>"}}});
  add(page, report::Figures{{{image({}, "empty", false), "x"},
                             {cli::colour_bar(cli::ColourMap::diverging, -1, 1, "a<b"), "y"}}});
  add(page, report::Details{"more", "text\n<lines>"});
  const TemporaryFolder folder;
  write_page(folder.file("page.html"), page);
  EXPECT_TRUE(testing::is_page(folder.file("page.html")));
}

/// Where labels stand, from their <text> elements.
struct Label {
  double x, y, width;
};

std::vector<Label> labels_of(const std::string& svg) {
  std::vector<Label> labels;
  const std::regex pattern("<text x=\"([0-9.]+)\" y=\"([0-9.]+)\"[^>]*>(setting [0-9]+)</text>");
  for (std::sregex_iterator at(svg.begin(), svg.end(), pattern), end; at != end; ++at) {
    labels.push_back({std::stod((*at)[1]), std::stod((*at)[2]), 6.8 * double((*at)[3].length())});
  }
  return labels;
}

TEST(Svg, LabelsDoNotCollide) {
  const std::vector<Label> labels = labels_of(svg::draw(some_plot()));
  EXPECT_GT(labels.size(), 5u);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Label &a = labels[i], &b = labels[j];
      const bool apart = a.x + a.width <= b.x || b.x + b.width <= a.x || std::abs(a.y - b.y) >= 13;
      EXPECT_TRUE(apart) << i << ' ' << j;
    }
  }
}

TEST(Svg, WhatCannotBeDrawnIsLeftOut) {
  svg::Plot p;
  p.x.logarithmic = p.y.logarithmic = true;
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  p.series = {{"s", {{0, 1}, {-1, 1}, {1, nan}, {infinity, 2}, {3, 0}, {3, 5}}}};
  const std::string svg = svg::draw(p);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  EXPECT_EQ(svg.find("<circle"), svg.rfind("<circle"));  // one point
  EXPECT_NE(svg::draw({}).find("</svg>"), std::string::npos);
}

std::string texts(const std::vector<svg::Mark>& marks) {
  std::string s;
  for (const svg::Mark& m : marks) s += (s.empty() ? "" : " ") + m.text;
  return s;
}

TEST(Svg, MarksAreRoundNumbers) {
  EXPECT_EQ(texts(svg::marks(0, 1, false, 5)), "0 0.2 0.4 0.6 0.8 1");
  EXPECT_EQ(texts(svg::marks(-3.1, 3.9, false, 5)), "−2 0 2");
  EXPECT_EQ(texts(svg::marks(1, 1000, true, 6)), "1 10 100 1000");
  EXPECT_EQ(texts(svg::marks(1.5, 30, true, 6)), "2 5 10 20");
  EXPECT_EQ(texts(svg::marks(1e-9, 1e9, true, 6)), "10⁻⁹ 10⁻⁶ 0.001 1 1000 10⁶ 10⁹");
  EXPECT_LE(svg::marks(1e300, 1.0000001e300, false, 5).size(), 16u);
}

TEST(ColourMap, EndsAreFarApartAndTheMiddleIsNeutral) {
  const cli::Srgb middle = cli::colour_at(cli::ColourMap::diverging, 0.5);
  EXPECT_NEAR(middle[0], middle[2], 4);
  EXPECT_EQ(cli::colour_at(cli::ColourMap::diverging, -7),
            cli::colour_at(cli::ColourMap::diverging, 0));
  EXPECT_EQ(cli::colour_at(cli::ColourMap::sequential, std::nan("")), (cli::Srgb{255, 0, 255}));
  int last = -1;  // lightness rises, so that grey prints tell values apart
  for (double t = 0; t <= 1; t += 0.05) {
    const cli::Srgb c = cli::colour_at(cli::ColourMap::sequential, t);
    const int lightness = 2126 * c[0] + 7152 * c[1] + 722 * c[2];
    EXPECT_GT(lightness, last);
    last = lightness;
  }
}

}  // namespace html_test
}  // namespace pvol::html
