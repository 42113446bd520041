#include "report/live_page.h"

#include <fmt/format.h>

#include <utility>

#include "pvol/formats/atomic_file.h"
#include "report/html.h"

namespace pvol::report {
namespace {

constexpr std::chrono::seconds kBetweenPictures{1};

/// The name of a file as part of an address: what has a meaning there, as %20 and the like.
std::string address_of(const std::string& name) {
  std::string text;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                       c == '.' || c == '-' || c == '_';
    text += plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  return text;
}

}  // namespace

LivePage::LivePage(std::filesystem::path png)
    : png_(std::move(png)), page_(std::filesystem::path(png_).replace_extension(".html")) {}

LivePage::~LivePage() {
  if (ended_ || number_ == 0) return;
  try {
    write("stopped", false);
  } catch (...) {  // what stopped it is told already
  }
}

void LivePage::show(const std::string& state, const std::function<void()>& write_png) {
  const auto now = std::chrono::steady_clock::now();
  if (number_ > 0 && now - shown_ < kBetweenPictures) return;
  write_png();
  write(state, true);
  shown_ = std::chrono::steady_clock::now();
}

void LivePage::end(const std::string& state) {
  write(state, false);
  ended_ = true;
}

void LivePage::write(const std::string& state, bool reloads) {
  const std::string name = png_.filename().string(), title = html::escape(name);
  const std::string text = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n{}<title>{}</title>\n"
      "<style>body{{margin:0;background:#222;color:#ccc;font:1em sans-serif}}"
      "img{{display:block;max-width:100%;margin:auto}}p{{text-align:center}}</style>\n</head>\n"
      "<body>\n<img src=\"{}?{}\" alt=\"{}\">\n<p>{}</p>\n</body>\n</html>\n",
      reloads ? "<meta http-equiv=\"refresh\" content=\"1\">\n" : "", title, address_of(name),
      ++number_, title, html::escape(state));
  formats::write_text_atomically(page_, text);
}

}  // namespace pvol::report
