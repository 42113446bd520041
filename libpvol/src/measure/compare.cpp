// Comparison of films (THEORY.md, T9.1).
#include "pvol/measure/compare.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "pvol/error.h"
#include "pvol/measure/student.h"

namespace pvol::measure {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kLuminance = 3;    // after R, G, B
constexpr int kLeastEdge = 8;            // of a rectangle, in pixels
constexpr double kLeastSamples = 4096;   // in a rectangle, of either film
constexpr std::size_t kLeastBlocks = 4;  // for a variance between blocks
constexpr double kRounding = 0x1p-24;    // of a number stored as a float, relative
using Four = std::array<double, 4>;      // by channel: R, G, B, luminance

/// The four channels of a pixel's mean in one film.
struct PixelMean {
  Four value{}, variance{};
  double samples = 0, dof = 0;  // of the variance
};

PixelMean measure(const PixelSums& p) {
  PixelMean m;
  const Vec3d value = mean(p), variance = variance_of_mean(p);
  const double deviation = luminance_deviation(p);
  m.value = {value.x, value.y, value.z, luminance(value)};
  m.variance = {variance.x, variance.y, variance.z, deviation * deviation};
  m.samples = double(p.samples);
  m.dof = p.samples > 1 ? double(p.samples) - 1 : 0;
  return m;
}

/// A sum of independent differences of two means.
/// Based on: Welch. The Generalization of `Student's' Problem when Several Different Population
/// Variances are Involved. Biometrika 34, 1947, for the degrees of freedom of a sum of variances.
struct Difference {
  double value = 0, variance = 0;
  double spread = 0;    // sum of variance^2 / degrees of freedom
  double rounding = 0;  // what of the value may be due to the rounding of pixels

  void add(const PixelMean& a, const PixelMean& b, std::size_t channel) {
    const double va = a.variance[channel], vb = b.variance[channel];
    value += a.value[channel] - b.value[channel];
    variance += va + vb;
    if (va > 0) spread += va * va / a.dof;
    if (vb > 0) spread += vb * vb / b.dof;
    rounding += kRounding * (std::abs(a.value[channel]) + std::abs(b.value[channel]));
  }
  Difference& operator+=(const Difference& d) {
    value += d.value, variance += d.variance, spread += d.spread, rounding += d.rounding;
    return *this;
  }
  [[nodiscard]] double excess() const { return std::max(0.0, std::abs(value) - rounding); }
  [[nodiscard]] double deviation() const { return std::sqrt(variance); }
  [[nodiscard]] double dof() const { return variance * variance / spread; }
  [[nodiscard]] double p_value() const {
    if (excess() == 0) return 1;
    return variance > 0 ? student_p_value(excess() / deviation(), dof()) : 0;
  }
  [[nodiscard]] double half_width(double confidence) const {
    return variance > 0 ? student_quantile(confidence, dof()) * deviation() : 0;
  }
};

/// The variance of a sum of means in one film by its own samples, and what those of the other film
/// say it is if they follow the same law. Each with sum of variance^2 / degrees of freedom.
struct TwoVariances {
  double own = 0, own_spread = 0, other = 0, other_spread = 0;

  void add(const PixelMean& of, const PixelMean& by, std::size_t channel) {
    if (!(of.samples > 0)) return;  // of a picture that was interrupted
    const double v = of.variance[channel], w = by.variance[channel] * (by.samples / of.samples);
    own += v, other += w;
    if (v > 0) own_spread += v * v / of.dof;
    if (w > 0) other_spread += w * w / by.dof;
  }
  TwoVariances& operator+=(const TwoVariances& t) {
    own += t.own, own_spread += t.own_spread;
    other += t.other, other_spread += t.other_spread;
    return *this;
  }
  [[nodiscard]] double larger() const { return std::max(own, other); }
  [[nodiscard]] double spread_of_larger() const { return own < other ? other_spread : own_spread; }
};

/// A difference that is tested with the larger of two variances for either film: a film that has
/// missed rare bright samples is too dark and believes itself too exact.
struct CautiousDifference {
  Difference own;
  TwoVariances a, b;

  void add(const PixelMean& in_a, const PixelMean& in_b, std::size_t channel) {
    own.add(in_a, in_b, channel);
    a.add(in_a, in_b, channel);
    b.add(in_b, in_a, channel);
  }
  CautiousDifference& operator+=(const CautiousDifference& d) {
    own += d.own, a += d.a, b += d.b;
    return *this;
  }
  [[nodiscard]] Difference cautious() const {
    Difference d = own;
    d.variance = a.larger() + b.larger();
    d.spread = a.spread_of_larger() + b.spread_of_larger();
    return d;
  }
};

/// A pixel's difference in luminance with the variance of one law for the samples of both films,
/// where that is larger: few samples may agree by chance (THEORY.md, T9.1).
void pool(const PixelMean& a, const PixelMean& b, Difference& d) {
  if (!(a.dof > 0 && b.dof > 0)) return;
  const auto squares = [](const PixelMean& m) {
    return m.dof * m.samples * m.variance[kLuminance];
  };
  const double dof = a.dof + b.dof;
  const double pooled = (squares(a) + squares(b)) / dof * (1 / a.samples + 1 / b.samples);
  if (pooled > d.variance) d.variance = pooled, d.spread = pooled * pooled / dof;
}

void require(bool ok, const std::string& message) {
  if (!ok) throw Error(message);
}

std::string rectangle(const Film& f) {
  return std::to_string(f.crop_width) + " x " + std::to_string(f.crop_height) + " pixels at (" +
         std::to_string(f.x) + ", " + std::to_string(f.y) + ") of " + std::to_string(f.width) +
         " x " + std::to_string(f.height);
}

void check_pixels(const Film& f, const char* name) {
  for (std::size_t i = 0; i < f.pixels.size(); ++i) {
    const PixelSums& p = f.pixels[i];
    if (is_finite(p.sum) && is_finite(p.sum_squares)) continue;
    const auto width = std::size_t(f.crop_width);
    throw Error(std::string("the ") + name + " picture: pixel (" +
                std::to_string(f.x + int(i % width)) + ", " + std::to_string(f.y + int(i / width)) +
                ") is not finite; render it again");
  }
}

void check(const Film& a, const Film& b, const CompareOptions& o) {
  require(a.width == b.width && a.height == b.height && a.x == b.x && a.y == b.y &&
              a.crop_width == b.crop_width && a.crop_height == b.crop_height,
          "the pictures show different rectangles: " + rectangle(a) + ", and " + rectangle(b) +
              "; render both with the same size and crop");
  require(a.color_space == b.color_space,
          std::string("the pictures are in different colour spaces, ") + name(a.color_space) +
              " and " + name(b.color_space) + "; expected the same");
  require(!a.pixels.empty(), "the pictures have no pixels; expected at least one");
  check_pixels(a, "first");
  check_pixels(b, "second");
  require(o.confidence >= 0 && o.confidence < 1,
          "the confidence is out of range; expected a number in [0, 1)");
  require(o.level > 0 && o.level < 1,
          "the level of the test is out of range; expected a number between 0 and 1");
}

double samples_per_pixel(const Film& f) {
  double total = 0;
  for (const PixelSums& p : f.pixels) total += double(p.samples);
  return total / double(f.pixels.size());
}

/// Tests the means of a rectangle, of its halves or quarters, and so on.
class Regions {
 public:
  Regions(const Film& a, const Film& b)
      : a_(a),
        b_(b),
        least_pixels_(kLeastSamples / std::min(samples_per_pixel(a), samples_per_pixel(b))) {
    (void)test(0, 0, a.crop_width, a.crop_height);
  }

  [[nodiscard]] std::uint64_t tests() const { return tests_; }
  [[nodiscard]] const RegionDifference& worst() const { return worst_; }

 private:
  using Sums = std::array<CautiousDifference, 3>;

  [[nodiscard]] Sums test(int x, int y, int width, int height) {
    Sums sums;
    if (can_split(width, height)) {
      // Both edges, or the longer one where the other has reached its least.
      const int across = width >= 2 * kLeastEdge ? 2 : 1, down = height >= 2 * kLeastEdge ? 2 : 1;
      for (int j = 0; j < down; ++j) {
        for (int i = 0; i < across; ++i) {
          const int x0 = x + width * i / across, x1 = x + width * (i + 1) / across;
          const int y0 = y + height * j / down, y1 = y + height * (j + 1) / down;
          const Sums part = test(x0, y0, x1 - x0, y1 - y0);
          for (std::size_t c = 0; c < 3; ++c) sums[c] += part[c];
        }
      }
    } else {
      for (int j = y; j < y + height; ++j) {
        for (int i = x; i < x + width; ++i) {
          const PixelMean a = measure(a_.at(i, j)), b = measure(b_.at(i, j));
          for (std::size_t c = 0; c < 3; ++c) sums[c].add(a, b, c);
        }
      }
    }
    for (std::size_t c = 0; c < 3; ++c) note(sums[c].cautious(), int(c), x, y, width, height);
    return sums;
  }

  [[nodiscard]] bool can_split(int width, int height) const {
    if (width < 2 * kLeastEdge && height < 2 * kLeastEdge) return false;
    const int parts = (width >= 2 * kLeastEdge ? 2 : 1) * (height >= 2 * kLeastEdge ? 2 : 1);
    return double(width) * double(height) >= parts * least_pixels_;
  }

  void note(const Difference& d, int channel, int x, int y, int width, int height) {
    if (d.variance == 0 && d.excess() == 0) return;  // nothing that could differ
    ++tests_;
    const double p = d.p_value(), pixels = double(width) * double(height);
    if (tests_ > 1 && !(p < worst_.p_value)) return;
    worst_ = {a_.x + x, a_.y + y, width, height, channel, d.value / pixels, d.deviation() / pixels,
              p};
  }

  const Film &a_, &b_;
  double least_pixels_;
  std::uint64_t tests_ = 0;
  RegionDifference worst_;
};

/// Squared differences less what variances explain, summed over blocks: independent numbers of
/// expectation 0 where the films' expectations are equal, whatever the law of the samples.
class SystematicSquares {
 public:
  SystematicSquares(int width, int height)
      : across_(std::size_t((width + kLeastEdge - 1) / kLeastEdge)),
        blocks_(across_ * std::size_t((height + kLeastEdge - 1) / kLeastEdge)) {}

  void add(int x, int y, double systematic) {
    blocks_[std::size_t(y / kLeastEdge) * across_ + std::size_t(x / kLeastEdge)] += systematic;
  }

  /// The standard error of their total, from the spread between blocks.
  [[nodiscard]] double deviation() const {
    const double n = double(blocks_.size());
    double total = 0, squares = 0;
    for (const double b : blocks_) total += b;
    for (const double b : blocks_) squares += (b - total / n) * (b - total / n);
    return std::sqrt(n / (n - 1) * squares);
  }
  [[nodiscard]] bool usable() const { return blocks_.size() >= kLeastBlocks; }
  [[nodiscard]] double half_width(double confidence) const {
    if (!usable()) return kUnknown;
    return student_quantile(confidence, double(blocks_.size() - 1)) * deviation();
  }
  /// One-sided: systematic differences only add to squares.
  [[nodiscard]] double p_value() const {
    double total = 0;
    for (const double b : blocks_) total += b;
    if (!usable() || !(total > 0)) return 1;
    return 0.5 * student_p_value(total / deviation(), double(blocks_.size() - 1));
  }

 private:
  std::size_t across_;
  std::vector<double> blocks_;
};

/// A squared difference in a pixel, and what the variances explain of it.
struct Square {
  double found = 0, explained = 0;
  double systematic = 0;  // the rest, without what rounding explains
};

Square square_of(const Difference& d) {
  return {d.value * d.value, d.variance, d.excess() * d.excess() - d.variance};
}

/// Those of the channels, weighted as in luminance.
Square weigh(const Square& r, const Square& g, const Square& b) {
  return {luminance(Vec3d(r.found, g.found, b.found)),
          luminance(Vec3d(r.explained, g.explained, b.explained)),
          luminance(Vec3d(r.systematic, g.systematic, b.systematic))};
}

/// Sums over all pixels of one channel, or of all.
struct ChannelSums {
  double a = 0, b = 0, squares = 0, explained = 0;
  Difference difference;
  SystematicSquares systematic;

  void add(int x, int y, const Square& s) {
    squares += s.found, explained += s.explained;
    systematic.add(x, y, s.systematic);
  }

  ChannelComparison result(double pixels, bool variances_known, double confidence) const {
    ChannelComparison c;
    c.mean_a = a / pixels, c.mean_b = b / pixels;
    c.bias = difference.value / pixels;
    c.mse = squares / pixels;
    c.rmse = std::sqrt(c.mse);
    c.relative_bias = c.mean_b != 0 ? c.bias / c.mean_b : kUnknown;
    c.relative_rmse = c.mean_b != 0 ? c.rmse / std::abs(c.mean_b) : kUnknown;
    const auto known = [&](double v) { return variances_known ? v : kUnknown; };
    c.bias_deviation = known(difference.deviation() / pixels);
    c.bias_half_width = known(difference.half_width(confidence) / pixels);
    c.explained_mse = known(explained / pixels);
    c.systematic_mse = known(c.mse - explained / pixels);
    c.systematic_half_width = known(systematic.half_width(confidence) / pixels);
    return c;
  }
};

/// The most significant deviation and how many are large, among the pixels with variance.
class Extremes {
 public:
  void add(int x, int y, const Difference& d) {
    if (!(d.variance > 0)) return;
    ++pixels_;
    const double sigmas = d.value / d.deviation(), p = d.p_value();
    for (std::size_t i = 0; i < tails_.size(); ++i) {
      tails_[i].sigmas = double(i + 3);
      tails_[i].found += d.excess() / d.deviation() > tails_[i].sigmas;
      tails_[i].expected += student_p_value(tails_[i].sigmas, d.dof());
    }
    if (!largest_ || p < largest_->p_value ||
        (p == largest_->p_value && std::abs(sigmas) > std::abs(largest_->sigmas))) {
      largest_ = {x, y, sigmas, p};
    }
  }
  void put(FilmComparison& result) const {
    result.tails = tails_;
    result.largest = largest_;
    if (largest_) result.largest->p_value = sidak_p_value(largest_->p_value, double(pixels_));
  }

 private:
  double pixels_ = 0;
  std::array<PixelTail, 3> tails_{};
  std::optional<PixelExtreme> largest_;
};

BiasVerdict judge(const Regions& regions, const std::array<double, 3>& pixels_p_values,
                  double level) {
  BiasVerdict v;
  v.regions = regions.tests();
  v.worst = regions.worst();
  v.regions_p_value = v.regions > 0 ? sidak_p_value(v.worst.p_value, double(v.regions)) : 1;
  v.pixels_p_value =
      sidak_p_value(*std::min_element(pixels_p_values.begin(), pixels_p_values.end()), 3);
  v.p_value = sidak_p_value(std::min(v.regions_p_value, v.pixels_p_value), 2);
  v.detected = v.p_value < level;
  return v;
}

}  // namespace

double luminance_deviation(const PixelSums& pixel) {
  const Vec3d v = variance_of_mean(pixel);
  return luminance(Vec3d(std::sqrt(v.x), std::sqrt(v.y), std::sqrt(v.z)));
}

FilmComparison compare(const Film& a, const Film& b, const CompareOptions& options) {
  check(a, b, options);
  FilmComparison r;
  r.options = options;
  r.pixels = a.pixels.size();
  r.variances_known = true;
  const SystematicSquares no_squares(a.crop_width, a.crop_height);
  std::vector<ChannelSums> sums(4, ChannelSums{0, 0, 0, 0, {}, no_squares});
  Extremes extremes;
  for (int y = 0; y < a.crop_height; ++y) {
    for (int x = 0; x < a.crop_width; ++x) {
      const PixelMean in_a = measure(a.at(x, y)), in_b = measure(b.at(x, y));
      r.variances_known = r.variances_known && in_a.dof > 0 && in_b.dof > 0;
      std::array<Square, 3> squares;
      for (std::size_t c = 0; c < sums.size(); ++c) {
        Difference d;
        d.add(in_a, in_b, c);
        sums[c].a += in_a.value[c], sums[c].b += in_b.value[c];
        sums[c].difference += d;
        if (c < kLuminance) {
          sums[c].add(x, y, squares[c] = square_of(d));
        } else {
          pool(in_a, in_b, d);
          extremes.add(a.x + x, a.y + y, d);
        }
      }
      sums[kLuminance].add(x, y, weigh(squares[0], squares[1], squares[2]));
    }
  }
  const auto channel = [&](std::size_t c) {
    return sums[c].result(double(r.pixels), r.variances_known, options.confidence);
  };
  r.channels = {channel(0), channel(1), channel(2)};
  r.luminance = channel(kLuminance);
  if (!r.variances_known) return r;
  extremes.put(r);
  const Regions regions(a, b);
  r.verdict = judge(
      regions,
      {sums[0].systematic.p_value(), sums[1].systematic.p_value(), sums[2].systematic.p_value()},
      options.level);
  return r;
}

}  // namespace pvol::measure
