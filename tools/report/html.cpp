#include "report/html.h"

#include <algorithm>
#include <cstdint>
#include <fstream>

#include "pvol/error.h"
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

void add_row(std::string& out, const std::vector<std::string>& cells, const char* cell,
             bool marked) {
  out += marked ? "<tr class=\"marked\">" : "<tr>";
  for (const std::string& c : cells) {
    out += std::string("<") + cell + ">" + escape(c) + "</" + cell + ">";
  }
  out += "</tr>\n";
}

std::string to_text(const Figure& f) {
  return "<figure>" + f.markup + "<figcaption>" + escape(f.caption) + "</figcaption></figure>\n";
}

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

void add_heading(Page& page, std::string_view text) {
  page.body += "<h2>" + escape(text) + "</h2>\n";
}

void add_paragraph(Page& page, std::string_view text) {
  page.body += "<p>" + escape(text) + "</p>\n";
}

void add_verdict(Page& page, std::string_view text, Mood mood) {
  const char* const kind = mood == Mood::good ? " good" : mood == Mood::bad ? " bad" : "";
  const char* const sign = mood == Mood::good ? "&#10003; " : mood == Mood::bad ? "&#10007; " : "";
  page.body += std::string("<p class=\"verdict") + kind + "\">" + sign + escape(text) + "</p>\n";
}

void add_table(Page& page, const Table& table) {
  std::string& out = page.body;
  out += "<div class=\"wide\"><table>";
  if (!table.caption.empty()) out += "<caption>" + escape(table.caption) + "</caption>";
  out += "<thead>";
  add_row(out, table.header, "th", false);
  out += "</thead><tbody>\n";
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const bool marked =
        std::find(table.marked.begin(), table.marked.end(), i) != table.marked.end();
    add_row(out, table.rows[i], "td", marked);
  }
  out += "</tbody></table></div>\n";
}

void add_figure(Page& page, const Figure& figure) { page.body += to_text(figure); }

void add_figures(Page& page, std::span<const Figure> figures) {
  page.body += "<div class=\"figures\">\n";
  for (const Figure& f : figures) page.body += to_text(f);
  page.body += "</div>\n";
}

std::string image(std::span<const std::byte> png, std::string_view description, bool crisp) {
  return std::string("<img") + (crisp ? " class=\"crisp\"" : "") + " alt=\"" + escape(description) +
         "\" src=\"data:image/png;base64," + base64(png) + "\">";
}

void add_details(Page& page, std::string_view summary, std::string_view text) {
  page.body += "<details><summary>" + escape(summary) + "</summary><pre>" + escape(text) +
               "</pre></details>\n";
}

std::string to_text(const Page& page) {
  const std::string title = escape(page.title);
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         title + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<h1>" + title +
         "</h1>\n" + page.body + "<footer>pvol-stats " PVOL_VERSION "</footer>\n</body>\n</html>\n";
}

void write_page(const std::filesystem::path& file, const Page& page) {
  const std::string text = to_text(page);
  formats::write_atomically(file, [&](const std::filesystem::path& aside) {
    std::ofstream out(aside, std::ios::binary);
    out.write(text.data(), std::streamsize(text.size()));
    out.close();
    if (!out) throw Error(file.string() + ": writing failed; is the disk full?");
  });
}

}  // namespace pvol::html
