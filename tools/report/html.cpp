#include "report/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <sstream>

#include "pvol/formats/atomic_file.h"
#include "pvol/version.h"

namespace pvol::html {
namespace {

// Okabe and Ito's colours, which colour-blind readers tell apart, darker on paper and lighter on
// black where they would be faint. Series of plots use --c0 to --c7.
constexpr const char* kStyle = R"(
:root { color-scheme: light dark;
  --paper: #ffffff; --ink: #1b1f24; --faint: #5d6670; --rule: #d5dae0; --wash: #f3f5f7;
  --good: #00704f; --bad: #b03a00;
  --c0: #0072b2; --c1: #d55e00; --c2: #009e73; --c3: #b0588f;
  --c4: #b07d00; --c5: #3a93c9; --c6: #6b6b6b; --c7: #8a5a2b; }
@media (prefers-color-scheme: dark) { :root {
  --paper: #15181c; --ink: #e6e9ec; --faint: #9aa4ae; --rule: #343b43; --wash: #1e2328;
  --good: #3fc79a; --bad: #ff9a5c;
  --c0: #56a8e0; --c1: #ff8c42; --c2: #2fc99b; --c3: #e79fca;
  --c4: #e8b93c; --c5: #8fd0f5; --c6: #a8a8a8; --c7: #c99a6b; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem 1rem 4rem; max-width: 72rem; background: var(--paper);
  color: var(--ink); font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0 0 .5rem; overflow-wrap: anywhere; }
h2 { font-size: 1.2rem; margin: 2.2rem 0 .5rem; padding-top: .6rem;
  border-top: 1px solid var(--rule); }
p, summary { max-width: 46rem; overflow-wrap: anywhere; }
p { margin: .5rem 0; }
.verdict { border-left: 4px solid var(--faint); background: var(--wash); padding: .6rem .9rem;
  font-weight: 600; }
.good { border-color: var(--good); color: var(--good); }
.bad { border-color: var(--bad); color: var(--bad); }
.wide { overflow-x: auto; margin: .8rem 0; }
table { border-collapse: collapse; min-width: min(100%, 30rem); font-variant-numeric: tabular-nums; font-size: .92rem; }
caption { text-align: left; color: var(--faint); padding-bottom: .3rem; }
th, td { padding: .22rem .8rem; text-align: right; white-space: nowrap;
  border-bottom: 1px solid var(--rule); }
th { color: var(--faint); font-weight: 600; vertical-align: bottom; }
th:first-child, td:first-child { text-align: left; padding-left: 0; }
tr.marked td { background: var(--wash); font-weight: 600; }
.figures { display: grid; gap: 1rem 1.5rem;
  grid-template-columns: repeat(auto-fit, minmax(min(100%, 24rem), 1fr)); }
figure { margin: .8rem 0; min-width: 0; max-width: 44rem; }
figure img, figure svg { display: block; width: 100%; height: auto; }
figure img { max-height: 36rem; object-fit: contain; object-position: left top; }
figure svg.bar { max-width: 26rem; }
figure img.crisp { image-rendering: pixelated; }
figcaption { color: var(--faint); font-size: .88rem; margin-top: .3rem; }
.word { white-space: nowrap; }
@media (max-width: 30rem) { table { font-size: .75rem; min-width: 0; }
  th, td { padding: .2rem .3rem; } th { white-space: normal; } }
details { margin: .8rem 0; color: var(--faint); }
details pre { white-space: pre-wrap; overflow-wrap: anywhere; font-size: .85rem; }
svg text { fill: var(--ink); font: 13px system-ui, -apple-system, "Segoe UI", sans-serif; }
svg .faint { fill: var(--faint); }
svg .grid { stroke: var(--rule); stroke-width: 1; }
svg .axis { stroke: var(--faint); stroke-width: 1; fill: none; }
footer { margin-top: 3rem; color: var(--faint); font-size: .85rem; }
)";

/// Length of the UTF-8 sequence at the start of `s`; 0 where there is none (RFC 3629).
std::size_t sequence_length(std::string_view s) {
  const auto byte = [&](std::size_t i) { return i < s.size() ? std::uint8_t(s[i]) : 0u; };
  const auto follows = [&](std::size_t i) { return (byte(i) & 0xC0u) == 0x80; };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first <= 0xDF) return follows(1) ? 2 : 0;
  if (first >= 0xE0 && first <= 0xEF) {
    const bool overlong = first == 0xE0 && byte(1) < 0xA0;
    const bool surrogate = first == 0xED && byte(1) > 0x9F;
    return follows(1) && follows(2) && !overlong && !surrogate ? 3 : 0;
  }
  if (first >= 0xF0 && first <= 0xF4) {
    const bool overlong = first == 0xF0 && byte(1) < 0x90;
    const bool beyond = first == 0xF4 && byte(1) > 0x8F;
    return follows(1) && follows(2) && follows(3) && !overlong && !beyond ? 4 : 0;
  }
  return 0;
}

std::string base64(std::span<const std::byte> bytes) {
  constexpr const char* kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (k < count ? std::uint32_t(bytes[i + k]) : 0);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= count ? kDigits[group >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

/// As the beginning of a sentence.
std::string capital(std::string text) {
  if (!text.empty()) text[0] = char(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

/// A command that lines break only between words of, not at the hyphens of options.
std::string whole_words(const std::string& command) {
  std::istringstream words(command);
  std::string out;
  for (std::string word; words >> word;) {
    out += fmt::format("{}<span class=\"word\">{}</span>", out.empty() ? "" : " ", escape(word));
  }
  return out;
}

std::string row(const std::vector<std::string>& cells, const char* cell, bool marked) {
  std::string out = marked ? "<tr class=\"marked\">" : "<tr>";
  for (const std::string& c : cells) out += fmt::format("<{0}>{1}</{0}>", cell, escape(c));
  return out + "</tr>\n";
}

/// The blocks of a document as elements of the body.
class Printer {
 public:
  void operator()(const report::Heading& h) { put("<h2>{}</h2>\n", escape(h.text)); }
  void operator()(const report::Text& t) { put("<p>{}</p>\n", escape(capital(t.text))); }
  void operator()(const report::Verdict& v) {
    using report::Mood;
    const char* const kind = v.mood == Mood::good ? " good" : v.mood == Mood::bad ? " bad" : "";
    const char* const sign = v.mood == Mood::good  ? "&#10003; "
                             : v.mood == Mood::bad ? "&#10007; "
                                                   : "";
    const std::string text = escape(capital(v.text)) + (v.command.empty() ? "" : ":  ");
    put("<p class=\"verdict{}\">{}{}{}</p>\n", kind, sign, text, whole_words(v.command));
  }
  void operator()(const report::Table& t) {
    std::string caption = t.caption;
    if (!t.marked.empty() && !t.marks.empty()) caption += " Rows that stand out: " + t.marks + '.';
    out_ += "<div class=\"wide\"><table>";
    if (!caption.empty()) put("<caption>{}</caption>", escape(capital(caption)));
    put("<thead>{}</thead><tbody>\n", row(t.header, "th", false));
    for (std::size_t i = 0; i < t.rows.size(); ++i) {
      const bool marked = std::find(t.marked.begin(), t.marked.end(), i) != t.marked.end();
      out_ += row(t.rows[i], "td", marked);
    }
    out_ += "</tbody></table></div>\n";
  }
  void operator()(const report::Figures& f) {
    const bool several = f.figures.size() > 1;
    if (several) out_ += "<div class=\"figures\">\n";
    for (const report::Figure& figure : f.figures) {
      put("<figure>{}<figcaption>{}</figcaption></figure>\n", figure.markup,
          escape(figure.caption));
    }
    if (several) out_ += "</div>\n";
  }
  void operator()(const report::Details& d) {
    put("<details><summary>{}</summary><pre>{}</pre></details>\n", escape(d.summary),
        escape(d.text));
  }
  [[nodiscard]] std::string result() { return std::move(out_); }

 private:
  template <class... Parts>
  void put(fmt::format_string<const Parts&...> format, const Parts&... parts) {
    fmt::format_to(std::back_inserter(out_), format, parts...);
  }

  std::string out_;
};

}  // namespace

std::string escape(std::string_view text) {
  constexpr const char* kReplacement = "\xEF\xBF\xBD";
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = sequence_length(text);
    const char c = text.front();
    const bool control = std::uint8_t(c) < 0x20 && c != '\n' && c != '\t';
    if (length == 0 || control || c == '\x7F') {
      out += kReplacement;
    } else if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '"') {
      out += "&quot;";
    } else if (c == '\'') {
      out += "&#39;";
    } else {
      out += text.substr(0, length);
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

std::string image(std::span<const std::byte> png, std::string_view description, bool crisp) {
  return fmt::format("<img{} alt=\"{}\" src=\"data:image/png;base64,{}\">",
                     crisp ? " class=\"crisp\"" : "", escape(description), base64(png));
}

std::string to_page(const report::Document& document) {
  Printer print;
  if (!document.lead.empty()) print(report::Text{document.lead + '.'});
  for (const report::Block& b : document.blocks) {
    if (b.shown != report::Shown::on_terminal) std::visit(print, b.content);
  }
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{0}</title>\n<style>{1}</style>\n</head>\n<body>\n<h1>{0}</h1>\n{2}"
      "<footer>pvol-stats {3}</footer>\n</body>\n</html>\n",
      escape(document.title), kStyle, print.result(), PVOL_VERSION);
}

void write_page(const std::filesystem::path& file, const report::Document& document) {
  formats::write_text_atomically(file, to_page(document));
}

}  // namespace pvol::html
