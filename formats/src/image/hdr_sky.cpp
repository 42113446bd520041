// Sky pictures in from Radiance's .hdr: red, green and blue of 8 bits with a common exponent, plain
// or by either of its run-length codes, as Ward, "Real Pixels" (Graphics Gems II, 1991), and the
// file formats of Radiance have them.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>
#include <utility>

#include "file/byte_source.h"
#include "image/sky_readers.h"
#include "pvol/error.h"
#include "pvol/formats/image.h"

namespace pvol::formats {
namespace {

using detail::ByteSource;
using Rgbe = std::array<std::uint8_t, 4>;

constexpr std::size_t kLongestLine = 4096, kLongestHeader = 1 << 20;

/// The file's bytes in turn; errors tell the place.
class HdrBytes {
 public:
  explicit HdrBytes(const std::filesystem::path& file) : source_(file) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(fmt::format("byte {}: {}", place_, what));
  }
  [[nodiscard]] std::uint64_t left() const { return source_.size() - place_; }
  std::uint8_t next() {
    if (left() == 0) fail("the file ends within its pixels; expected more: copy or save it again");
    return std::uint8_t(*source_.at(place_++, 1));
  }
  Rgbe next_pixel() {
    Rgbe p;
    for (std::uint8_t& v : p) v = next();
    return p;
  }
  void go_back(std::uint64_t bytes) { place_ -= bytes; }

  /// Up to the end of the line, which is taken, too.
  std::string line() {
    std::string text;
    for (;;) {
      if (left() == 0)
        fail("the file ends within its header; expected more: copy or save it again");
      const char c = char(next());
      if (c == '\n') break;
      text += c;
      if (text.size() > kLongestLine || place_ > kLongestHeader) {
        fail("the header is too long; expected one of a Radiance picture (.hdr)");
      }
    }
    if (!text.empty() && text.back() == '\r') text.pop_back();
    return text;
  }

 private:
  ByteSource source_;
  std::uint64_t place_ = 0;
};

std::vector<double> numbers(std::string_view text) {
  std::vector<double> all;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end) {
    if (*at == ' ' || *at == '\t') {
      ++at;
      continue;
    }
    double v = 0;
    const auto read = std::from_chars(at, end, v);
    if (read.ec != std::errc{}) return {};
    all.push_back(v), at = read.ptr;
  }
  return all;
}

/// What the header says of colours: by what values are to be multiplied, and their primaries.
class Colors {
 public:
  void read(const std::string& line, const HdrBytes& in) {
    const auto equals = line.find('=');
    if (equals == std::string::npos || line.starts_with('#')) return;
    const std::string_view key = std::string_view(line).substr(0, equals);
    const std::string_view value = std::string_view(line).substr(equals + 1);
    if (key == "FORMAT" && value.find("32-bit_rle_rgbe") == std::string_view::npos) {
      in.fail(fmt::format("the format is \"{}\"; expected 32-bit_rle_rgbe: convert it to .exr",
                          printable(value)));
    }
    if (key == "EXPOSURE") divide(key, value, 1, in);
    if (key == "COLORCORR") divide(key, value, 3, in);
    if (key == "PRIMARIES") read_primaries(value, in);
  }
  [[nodiscard]] Vec3d factor() const { return factor_; }
  [[nodiscard]] const Primaries& primaries() const { return primaries_; }

 private:
  static std::string printable(std::string_view text) {
    std::string clean(text.substr(0, 60));
    std::ranges::replace_if(
        clean, [](char c) { return c < ' ' || c > '~'; }, '?');
    return clean;
  }
  /// What was multiplied into the values comes out again; such lines add up.
  void divide(std::string_view key, std::string_view value, std::size_t count, const HdrBytes& in) {
    const std::vector<double> v = numbers(value);
    const auto good = [](double x) { return x >= 1e-30 && x <= 1e30; };
    if (v.size() != count || !std::ranges::all_of(v, good)) {
      in.fail(fmt::format("{} is \"{}\"; expected {} in [1e-30, 1e30]", key, printable(value),
                          count == 1 ? "a number" : "three numbers"));
    }
    for (int c = 0; c < 3; ++c) factor_[c] /= v[count == 1 ? 0 : std::size_t(c)];
  }
  /// Those of Rec.709 keep white as it is, which may be of equal energy, as in Radiance.
  void read_primaries(std::string_view value, const HdrBytes& in) {
    const std::vector<double> v = numbers(value);
    if (v.size() != 8) {
      in.fail(
          fmt::format("PRIMARIES is \"{}\"; expected eight numbers, x and y of red, green, "
                      "blue and white",
                      printable(value)));
    }
    const Primaries p{{v[0], v[1]}, {v[2], v[3]}, {v[4], v[5]}, {v[6], v[7]}};
    const auto near = [](Chromaticity a, Chromaticity b) {
      return std::abs(a.x - b.x) < 0.015 && std::abs(a.y - b.y) < 0.015;
    };
    const Primaries ours = primaries_of(ColorSpace::rec709);
    const bool same = near(p.red, ours.red) && near(p.green, ours.green) && near(p.blue, ours.blue);
    primaries_ = same ? ours : p;
  }

  Vec3d factor_{1.0};
  Primaries primaries_ = primaries_of(ColorSpace::rec709);
};

/// The order in which pixels come: lines one after the other, each from its begin.
struct HdrLayout {
  bool by_columns = false;  ///< a line is a column
  bool from_right = false, from_bottom = false;
  int width = 0, height = 0;

  [[nodiscard]] int lines() const { return by_columns ? width : height; }
  [[nodiscard]] int length() const { return by_columns ? height : width; }
  [[nodiscard]] std::size_t index(int line, int i) const {
    const int x = by_columns ? line : i, y = by_columns ? i : line;
    return std::size_t(from_bottom ? height - 1 - y : y) * std::size_t(width) +
           std::size_t(from_right ? width - 1 - x : x);
  }
};

/// "-Y 512 +X 1024" and the seven others.
HdrLayout read_layout(const std::string& line, const HdrBytes& in) {
  const auto size = [](std::string_view text) {
    int n = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), n);
    const bool good = read.ec == std::errc{} && read.ptr == text.data() + text.size() &&
                      !text.empty() && text[0] != '-';
    return good ? n : -1;
  };
  std::vector<std::string_view> words;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t begin = std::min(line.find_first_not_of(' ', at), line.size());
    at = std::min(line.find(' ', begin), line.size());
    if (begin < at) words.push_back(std::string_view(line).substr(begin, at - begin));
  }
  const auto axis = [&](std::size_t i, char letter) {
    return words[i].size() == 2 && (words[i][0] == '+' || words[i][0] == '-') &&
           words[i][1] == letter;
  };
  const bool rows = words.size() == 4 && axis(0, 'Y') && axis(2, 'X');
  const bool columns = words.size() == 4 && axis(0, 'X') && axis(2, 'Y');
  if (!rows && !columns) {
    in.fail("the header ends without the picture's size; expected a line such as -Y 512 +X 1024");
  }
  const std::size_t y = rows ? 0 : 2, x = 2 - y;
  HdrLayout l{columns, words[x][0] == '-', words[y][0] == '+', size(words[x + 1]),
              size(words[y + 1])};
  if (l.width < 1 || l.height < 1 || l.width > detail::kLongestSkyEdge ||
      l.height > detail::kLongestSkyEdge ||
      std::size_t(l.width) * std::size_t(l.height) > detail::kMostSkyPixels) {
    in.fail(
        fmt::format("the picture has {} x {} pixels; expected 1 to {} along an edge and at "
                    "most {} in all",
                    words[x + 1], words[y + 1], detail::kLongestSkyEdge, detail::kMostSkyPixels));
  }
  return l;
}

/// Each channel by runs and pieces of its own.
void read_by_channels(HdrBytes& in, std::vector<Rgbe>& line) {
  for (std::size_t channel = 0; channel < 4; ++channel) {
    for (std::size_t i = 0; i < line.size();) {
      const std::uint8_t code = in.next();
      const bool run = code > 128;
      const std::size_t count = run ? code - 128 : code;
      if (count == 0 || count > line.size() - i) {
        in.fail(fmt::format(
            "found a run of {} values, expected 1 to {}, the rest of the line: the file is damaged",
            count, line.size() - i));
      }
      const std::uint8_t value = run ? in.next() : 0;
      for (const std::size_t end = i + count; i != end; ++i) {
        line[i][channel] = run ? value : in.next();
      }
    }
  }
}

/// Whole pixels, where (1, 1, 1, n) repeats the one before: n times, 256 n the second time in
/// succession, and so on.
void read_by_pixels(HdrBytes& in, std::vector<Rgbe>& line) {
  int shift = 0;
  for (std::size_t i = 0; i < line.size();) {
    const Rgbe p = in.next_pixel();
    if (p[0] != 1 || p[1] != 1 || p[2] != 1) {
      line[i++] = p;
      shift = 0;
      continue;
    }
    const std::uint64_t count = shift > 24 ? ~std::uint64_t{0} : std::uint64_t{p[3]} << shift;
    if (i == 0 || count > line.size() - i) {
      in.fail(
          fmt::format("a repeated pixel exceeds the {} that are left of the line, or follows none "
                      "({} so far): the file is damaged",
                      line.size() - i, i));
    }
    std::fill_n(line.begin() + std::ptrdiff_t(i), count, line[i - 1]);
    i += count;
    shift += 8;
  }
}

void read_line(HdrBytes& in, std::vector<Rgbe>& line) {
  constexpr std::size_t kShortest = 8, kLongest = 0x7fff;  // that have runs for each channel
  if (line.size() >= kShortest && line.size() <= kLongest) {
    const Rgbe mark = in.next_pixel();
    if (mark[0] == 2 && mark[1] == 2 && mark[2] < 128) {
      const std::size_t length = std::size_t(mark[2]) << 8 | mark[3];
      if (length != line.size()) {
        in.fail(fmt::format("a line of {} pixels; expected {}: the file is damaged", length,
                            line.size()));
      }
      return read_by_channels(in, line);
    }
    in.go_back(mark.size());
  }
  read_by_pixels(in, line);
}

/// In the middle of the byte's range would be half more, but then black would not be.
Vec3d radiance(Rgbe p) {
  const double unit = p[3] == 0 ? 0 : std::ldexp(1.0, int(p[3]) - 136);
  return Vec3d(p[0], p[1], p[2]) * unit;
}

detail::StoredSky read_picture(HdrBytes& in) {
  if (in.left() < 2 || in.next() != '#' || in.next() != '?') {
    throw Error("byte 0: not a Radiance picture (.hdr); expected one that begins with #?RADIANCE");
  }
  Colors colors;
  for (std::string line = in.line(); !line.empty(); line = in.line()) colors.read(line, in);
  const HdrLayout layout = read_layout(in.line(), in);
  if (in.left() / 4 < std::uint64_t(layout.lines())) {
    in.fail(
        fmt::format("{} bytes are left for {} lines of pixels; expected at least 4 each: copy "
                    "or save it again",
                    in.left(), layout.lines()));
  }
  // Memory grows with what was decoded: a small damaged file cannot ask for gigabytes.
  std::vector<Rgbe> pixels, line(std::size_t(layout.length()));
  for (int k = 0; k < layout.lines(); ++k) {
    read_line(in, line);
    pixels.insert(pixels.end(), line.begin(), line.end());
  }
  ImageSky sky;
  sky.width = layout.width, sky.height = layout.height;
  std::vector<Rgb> radiances(pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const auto length = std::size_t(layout.length());
    const int at = int(i % length), k = int(i / length);
    const Rgb c(radiance(pixels[i]) * colors.factor());
    if (!is_finite(c)) {
      throw Error(
          fmt::format("pixel {} of line {} is brighter than 3e38 without its exposure; "
                      "expected finite radiance",
                      at, k));
    }
    radiances[layout.index(k, at)] = c;
  }
  sky.pixels = std::move(radiances);
  return {std::move(sky), colors.primaries()};
}

}  // namespace

bool detail::is_hdr(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
  if (ending == ".hdr") return true;
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return false;
  std::ifstream in(file, std::ios::binary);
  return in.get() == '#' && in.get() == '?';
}

detail::StoredSky detail::read_hdr_sky(const std::filesystem::path& file) {
  HdrBytes in(file);
  try {
    return read_picture(in);
  } catch (const Error& e) {
    throw Error(file.string() + ": " + e.what());
  }
}

}  // namespace pvol::formats
