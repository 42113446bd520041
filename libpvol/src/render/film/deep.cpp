#include "pvol/render/deep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pvol/error.h"

namespace pvol {
namespace {

/// The bin of this number, of `most` that a pixel can have.
DeepBin& bin_at(std::vector<DeepBin>& bins, std::uint32_t number, int most) {
  auto at = std::ranges::lower_bound(bins, number, {}, &DeepBin::number);
  if (at != bins.end() && at->number == number) return *at;
  if (bins.size() == bins.capacity()) {
    const auto before = at - bins.begin();
    bins.reserve(std::min(std::size_t(most), 2 * bins.size() + 1));
    at = bins.begin() + before;
  }
  return *bins.insert(at, DeepBin{{}, 0, number});
}

/// What samples add to colour, by channel, and to alpha, in sums over them.
using Sums = std::array<double, 4>;
Sums sums_of(const DeepBin& b) { return {b.sum.x, b.sum.y, b.sum.z, double(b.count)}; }
void add(Sums& to, const Sums& from) {
  for (std::size_t c = 0; c < to.size(); ++c) to[c] += from[c];
}

/// An even medium between two depths that covers a share of what is behind it.
class Even {
 public:
  /// `alpha` is above 0 and below 1.
  Even(double front, double back, double alpha)
      : front_(front), alpha_(alpha), rate_(-std::log1p(-alpha) / (back - front)) {}

  /// The share of its alpha, and of its colour, that lies before a depth inside.
  [[nodiscard]] double share(double z) const { return -std::expm1(-rate_ * (z - front_)) / alpha_; }
  /// How that grows with depth.
  [[nodiscard]] double slope(double z) const {
    return rate_ * std::exp(-rate_ * (z - front_)) / alpha_;
  }
  [[nodiscard]] double rate() const { return rate_; }

 private:
  double front_, alpha_, rate_;
};

/// Makes samples of the bins of a pixel.
class Merger {
 public:
  Merger(const DeepFilm& film, std::size_t pixel, std::uint32_t samples, double error)
      : film_(film), bins_(film.pixels[pixel]), samples_(samples) {
    for (const DeepBin& b : bins_) add(allowed_, sums_of(b));
    for (double& a : allowed_) a = error * std::abs(a);
  }

  std::vector<DeepSample> run() {
    std::vector<DeepSample> all;
    for (std::size_t i = 0; i < bins_.size();) {
      std::size_t end = i + 1;
      Sums sums = sums_of(bins_[i]);
      for (; end < bins_.size(); ++end) {
        Sums more = sums;
        add(more, sums_of(bins_[end]));
        if (!may_merge(i, end + 1, more)) break;
        sums = more;
      }
      all.push_back(sample_of(i, end, sums));
      before_ += sums[3];
      i = end;
    }
    return all;
  }

 private:
  const DeepFilm& film_;
  const std::vector<DeepBin>& bins_;
  double samples_;
  Sums allowed_{};     // change of the sums
  double before_ = 0;  // samples that collided before the bins under way

  [[nodiscard]] double front(std::size_t i) const { return film_.edge(bins_[i].number); }
  [[nodiscard]] double back(std::size_t i) const { return film_.edge(bins_[i].number + 1); }

  [[nodiscard]] DeepSample sample_of(std::size_t begin, std::size_t end, const Sums& sums) const {
    const double arrived = samples_ - before_;
    DeepSample s{front(begin), back(end - 1), Vec3d(sums[0], sums[1], sums[2]) / arrived,
                 sums[3] / arrived};
    if (s.alpha == 1) s.z = s.z_back = 0.5 * (s.z + s.z_back);
    return s;
  }

  /// Whether the bins may be one sample, of these sums.
  [[nodiscard]] bool may_merge(std::size_t begin, std::size_t end, const Sums& sums) const {
    const double arrived = samples_ - before_;
    if (!(sums[3] < arrived)) return false;  // covers all: nothing even would
    const Even merged(front(begin), back(end - 1), sums[3] / arrived);
    Sums inside{};  // of the bins before this one
    double count = 0;
    for (std::size_t i = begin; i < end; ++i) {
      if (!(front(i) < back(i))) return false;  // thinner than double tells apart
      const Sums own = sums_of(bins_[i]);
      const Even bin(front(i), back(i), own[3] / (arrived - count));
      for (std::size_t c = 0; c < sums.size(); ++c) {
        // In gaps nothing is added, so that the change is greatest at a gap's ends.
        if (change(merged, sums[c], bin, own[c], inside[c], i) > allowed_[c]) return false;
      }
      add(inside, own);
      count += own[3];
    }
    return true;
  }

  /// The greatest change of a sum within a bin: at its ends, or where both grow equally.
  [[nodiscard]] double change(const Even& merged, double all, const Even& bin, double own,
                              double before, std::size_t i) const {
    const double z0 = front(i), z1 = back(i);
    const double at_front = before - all * merged.share(z0);
    const double at_back = before + own - all * merged.share(z1);
    double most = std::max(std::abs(at_front), std::abs(at_back));
    const double ratio = own * bin.slope(z0) / (all * merged.slope(z0));
    const double z = z0 + std::log(ratio) / (bin.rate() - merged.rate());  // nan: nowhere
    if (z > z0 && z < z1) {
      most = std::max(most, std::abs(before + own * bin.share(z) - all * merged.share(z)));
    }
    return most;
  }
};

}  // namespace

void DeepFilm::add(std::size_t pixel, double depth, Vec3d radiance) {
  const double place = (depth - front) / (back - front) * bins;
  const double last = bins - 1;
  DeepBin& bin = bin_at(pixels[pixel], std::uint32_t(place > 0 ? std::min(place, last) : 0), bins);
  bin.sum += radiance;
  ++bin.count;
}

std::vector<DeepSample> deep_samples(const DeepFilm& film, std::size_t pixel, std::uint32_t samples,
                                     double error) {
  return Merger(film, pixel, samples, error).run();
}

DeepValue seen_before(std::span<const DeepSample> samples, double depth) {
  DeepValue all;
  for (const DeepSample& s : samples) {
    if (s.z >= depth) break;
    const double open = 1 - all.alpha;
    const bool whole = s.z_back <= depth;
    // Of a medium that covers all, the front does.
    const double share = whole || s.alpha >= 1 ? 1
                         : s.alpha > 0         ? Even(s.z, s.z_back, s.alpha).share(depth)
                                               : (depth - s.z) / (s.z_back - s.z);
    all.colour += s.colour * (open * share);
    all.alpha += s.alpha * (open * share);
  }
  return all;
}

DeepValue flatten(std::span<const DeepSample> samples) {
  return seen_before(samples, std::numeric_limits<double>::infinity());
}

// Room for bins is doubled as they come.
double most_deep_bytes(double pixels, int bins, double samples) {
  return pixels *
         (sizeof(std::vector<DeepBin>) + sizeof(DeepBin) * std::min(double(bins), 2 * samples));
}

void add_samples(DeepFilm& to, const DeepFilm& from) {
  if (to.pixels.size() != from.pixels.size() || to.bins != from.bins || to.front != from.front ||
      to.back != from.back) {
    throw Error("the deep films have different sizes or bins; expected the same to add them");
  }
  for (std::size_t i = 0; i < to.pixels.size(); ++i) {
    for (const DeepBin& b : from.pixels[i]) {
      DeepBin& bin = bin_at(to.pixels[i], b.number, to.bins);
      bin.sum += b.sum;
      bin.count += b.count;
    }
  }
}

}  // namespace pvol
