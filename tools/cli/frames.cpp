#include "cli/frames.h"

#include <fmt/format.h>

#include <optional>
#include <regex>
#include <sstream>
#include <unordered_set>

#include "cli/cli.h"

namespace pvol::cli {
namespace {

struct Range {
  int first = 0, last = 0, step = 1;
};

Range parse_range(const std::string& text) {
  // Digits are limited so that no arithmetic with frames overflows.
  static const std::regex form("(-?[0-9]{1,7})(?:-(-?[0-9]{1,7})(?:x([0-9]{1,7}))?)?");
  std::smatch part;
  if (!std::regex_match(text, part, form)) {
    throw UsageError(
        fmt::format("found '{}', expected a frame such as 17, a range such as 1-240, 1-240x10 or "
                    "-5-10, or several of them separated by commas; numbers have at most 7 digits",
                    text));
  }
  Range r;
  r.first = r.last = std::stoi(part[1]);
  if (part[2].matched) r.last = std::stoi(part[2]);
  if (part[3].matched) r.step = std::stoi(part[3]);
  if (r.first > r.last) {
    throw UsageError(fmt::format("found '{}', expected an ascending range, such as {}-{}", text,
                                 r.last, r.first));
  }
  if (r.step == 0) {
    throw UsageError(fmt::format("found '{}', expected a step of 1 or more, such as {}-{}x2", text,
                                 r.first, r.last));
  }
  return r;
}

/// A place for a number in a text.
struct Pattern {
  std::size_t begin = 0, size = 0;
  int width = 1;
};

std::optional<Pattern> find_pattern(const std::string& name) {
  std::optional<Pattern> last;
  if (const std::size_t end = name.find_last_of('#'); end != name.npos) {
    const std::size_t begin = name.find_last_not_of('#', end) + 1;  // npos + 1 is 0
    last = Pattern{begin, end + 1 - begin, int(end + 1 - begin)};
  }
  static const std::regex form("%(?:0([1-9][0-9]?))?d|\\$F([1-9])?(?![A-Za-z0-9])");
  for (std::sregex_iterator m(name.begin(), name.end(), form), end; m != end; ++m) {
    const std::size_t begin = std::size_t(m->position());
    if (last && begin < last->begin) continue;
    const auto& digits = (*m)[1].matched ? (*m)[1] : (*m)[2];
    last = Pattern{begin, std::size_t(m->length()), digits.matched ? std::stoi(digits) : 1};
  }
  return last;
}

}  // namespace

std::vector<int> parse_frames(const std::string& text) {
  std::vector<int> frames;
  std::unordered_set<int> seen;
  // The comma more makes an empty last part a part.
  std::istringstream parts(text + ',');
  for (std::string part; std::getline(parts, part, ',');) {
    const Range r = parse_range(part);
    for (int frame = r.first; frame <= r.last; frame += r.step) {
      if (seen.insert(frame).second) frames.push_back(frame);
      if (frames.size() <= kMostFrames) continue;
      throw UsageError(
          fmt::format("found '{}', expected at most {} frames; divide them into several runs", text,
                      kMostFrames));
    }
  }
  return frames;
}

bool has_pattern(const std::filesystem::path& file) {
  return find_pattern(file.filename().string()).has_value();
}

std::filesystem::path file_of_frame(const std::filesystem::path& file, int frame) {
  std::string name = file.filename().string();
  const std::optional<Pattern> pattern = find_pattern(name);
  if (!pattern) return file;
  name.replace(pattern->begin, pattern->size, fmt::format("{:0{}}", frame, pattern->width));
  return std::filesystem::path(file).replace_filename(name);
}

std::filesystem::path with_pattern(const std::filesystem::path& file) {
  constexpr std::size_t kFewestDigits = 3;
  std::string name = file.stem().string();
  static const std::regex padded_with_blanks("%([1-9][0-9]?d)");
  const std::size_t begin = name.find_last_not_of("0123456789") + 1, digits = name.size() - begin;
  if (std::regex_search(name, padded_with_blanks)) {
    name = std::regex_replace(name, padded_with_blanks, "%0$1");
  } else if (begin > 0 && digits >= kFewestDigits &&
             std::string_view("._-").find(name[begin - 1]) != std::string_view::npos) {
    name.replace(begin, digits, digits, '#');
  } else {
    name += ".####";
  }
  return std::filesystem::path(file).replace_filename(name + file.extension().string());
}

}  // namespace pvol::cli
