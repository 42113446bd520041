#include "pvol/render/deep.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>

#include "pvol/error.h"

namespace pvol {
namespace {

/// Makes room before a place for one more, of `most` that a pixel can have.
template <class Bin>
Bin& insert(std::vector<Bin>& bins, typename std::vector<Bin>::iterator at, const Bin& bin,
            int most) {
  const auto before = at - bins.begin();
  if (bins.size() == bins.capacity()) {
    bins.reserve(std::min(std::size_t(most), 2 * bins.size() + 1));
  }
  return *bins.insert(bins.begin() + before, bin);
}

/// The bin of this number.
DeepBin& bin_at(std::vector<DeepBin>& bins, std::uint32_t number, int most) {
  const auto at = std::ranges::lower_bound(bins, number, {}, &DeepBin::number);
  if (at != bins.end() && at->number == number) return *at;
  return insert(bins, at, DeepBin{{}, 0, number}, most);
}

/// The interval of a depth above 0: its exponent and the first ten bits of its fraction.
std::int64_t interval_of(double depth) {
  constexpr int kBits = std::numeric_limits<double>::digits - 1 - 10;
  return std::bit_cast<std::int64_t>(depth) >> kBits;
}

/// What has this number; where there is no room for it, the nearest in depth.
DeepSurface& surface_at(std::vector<DeepSurface>& all, std::int64_t number, int most) {
  auto at = std::ranges::lower_bound(all, number, {}, &DeepSurface::number);
  if (at != all.end() && at->number == number) return *at;
  if (all.size() < std::size_t(most)) {
    DeepSurface one;
    one.number = number;
    return insert(all, at, one, most);
  }
  if (at == all.end()) return all.back();
  if (at == all.begin()) return all.front();
  const auto before = std::prev(at);
  return number - before->number < at->number - number ? *before : *at;
}

/// Adds the sums of one to those of another.
void add_sums(DeepSurface& to, const DeepSurface& from) {
  to.sum += from.sum;
  to.alpha += from.alpha;
  to.depth += from.depth;
  to.count += from.count;
}

/// What samples add to colour, by channel, and to alpha, in sums over them.
using Sums = std::array<double, 4>;
Sums sums_of(const Vec3d& sum, double alpha) { return {sum.x, sum.y, sum.z, alpha}; }
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

/// What samples met first between two depths, or where these are equal at a surface.
struct Part {
  double front, back;
  Sums sums;
};

/// Surfaces. Whatever noise says, each covers no less than nothing and no more than all that met
/// it. Where some would cover less, as those of shadow catchers may, the others cover as much less:
/// together what they do in the picture, if that is not below 0.
std::vector<Part> parts_of(const std::vector<DeepSurface>& surfaces) {
  double sum = 0, above = 0;
  for (const DeepSurface& s : surfaces) sum += s.alpha, above += std::max(s.alpha, 0.0);
  const double share = above > 0 ? std::clamp(sum / above, 0.0, 1.0) : 0;
  std::vector<Part> parts;
  for (const DeepSurface& s : surfaces) {
    const double depth = s.depth / s.count;
    const double alpha = std::clamp(share * s.alpha, 0.0, double(s.count));
    parts.push_back({depth, depth, sums_of(s.sum, alpha)});
  }
  return parts;
}

/// What an even bin, where `arrived` samples arrive, has before a depth inside.
Part part_before(const Part& bin, double depth, double arrived) {
  const double alpha = bin.sums[3] / arrived;
  const double share = alpha < 1 ? Even(bin.front, bin.back, alpha).share(depth)
                                 : (depth - bin.front) / (bin.back - bin.front);
  Part before{bin.front, depth, bin.sums};
  for (double& s : before.sums) s *= share;
  return before;
}

/// All that a pixel met, in order of depth. A surface that nothing lies behind has all of its bin
/// before it; others divide theirs.
std::vector<Part> parts_of(const DeepFilm& film, std::size_t pixel, double samples) {
  std::vector<Part> bins, all;
  for (const DeepBin& b : film.pixels[pixel]) {
    bins.push_back({film.edge(b.number), film.edge(b.number + 1), sums_of(b.sum, b.count)});
  }
  if (film.surfaces.empty()) return bins;
  const std::vector<Part> surfaces = parts_of(film.surfaces[pixel]);
  const auto put = [&](const Part& part) {
    if (part.sums != Sums{}) all.push_back(part);
    samples -= part.sums[3];
  };
  std::size_t next = 0;
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    const double depth = surfaces[k].front;
    for (; next < bins.size() && bins[next].front < depth; ++next) {
      Part& bin = bins[next];
      if (bin.back > depth && (next + 1 < bins.size() || k + 1 < surfaces.size())) {
        const Part before = part_before(bin, depth, samples);
        put(before);
        bin.front = depth;
        for (std::size_t c = 0; c < bin.sums.size(); ++c) bin.sums[c] -= before.sums[c];
        break;
      }
      bin.back = std::min(bin.back, depth);
      put(bin);
    }
    put(surfaces[k]);
  }
  for (; next < bins.size(); ++next) put(bins[next]);
  return all;
}

/// Makes samples of the parts of a pixel.
class Merger {
 public:
  Merger(const DeepFilm& film, std::size_t pixel, std::uint32_t samples, double error)
      : parts_(parts_of(film, pixel, samples)), samples_(samples) {
    for (const Part& p : parts_) add(allowed_, p.sums);
    for (double& a : allowed_) a = error * std::abs(a);
  }

  std::vector<DeepSample> run() {
    std::vector<DeepSample> all;
    for (std::size_t i = 0; i < parts_.size();) {
      std::size_t end = i + 1;
      Sums sums = parts_[i].sums;
      for (; end < parts_.size(); ++end) {
        Sums more = sums;
        add(more, parts_[end].sums);
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
  std::vector<Part> parts_;
  double samples_;
  Sums allowed_{};     // change of the sums
  double before_ = 0;  // samples that ended before the parts under way

  [[nodiscard]] double front(std::size_t i) const { return parts_[i].front; }
  [[nodiscard]] double back(std::size_t i) const { return parts_[i].back; }

  [[nodiscard]] DeepSample sample_of(std::size_t begin, std::size_t end, const Sums& sums) const {
    const double arrived = samples_ - before_;
    DeepSample s{front(begin), back(end - 1), Vec3d(sums[0], sums[1], sums[2]) / arrived,
                 std::min(sums[3] / arrived, 1.0)};  // rounding may leave less to arrive
    if (s.alpha == 1) s.z = s.z_back = 0.5 * (s.z + s.z_back);
    return s;
  }

  /// Whether the bins may be one sample, of these sums.
  [[nodiscard]] bool may_merge(std::size_t begin, std::size_t end, const Sums& sums) const {
    const double arrived = samples_ - before_;
    if (!(sums[3] < arrived)) return false;  // covers all: nothing even would
    const Even merged(front(begin), back(end - 1), sums[3] / arrived);
    Sums inside{};  // of the parts before this one
    double count = 0;
    for (std::size_t i = begin; i < end; ++i) {
      if (!(front(i) < back(i))) return false;  // thinner than double tells apart
      const Sums& own = parts_[i].sums;
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

void DeepFilm::add_surface(std::size_t pixel, double depth, Vec3d radiance, double alpha) {
  const std::int64_t number = interval_of(depth);
  add_sums(surface_at(surfaces[pixel], number, bins), {radiance, alpha, depth, 1, number});
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
double most_deep_bytes(double pixels, int bins, double samples, bool surfaces) {
  const auto of = [&](std::size_t list, std::size_t one) {
    return double(list) + double(one) * std::min(double(bins), 2 * samples);
  };
  return pixels * (of(sizeof(std::vector<DeepBin>), sizeof(DeepBin)) +
                   (surfaces ? of(sizeof(std::vector<DeepSurface>), sizeof(DeepSurface)) : 0));
}

void add_samples(DeepFilm& to, const DeepFilm& from) {
  if (to.pixels.size() != from.pixels.size() || to.surfaces.size() != from.surfaces.size() ||
      to.bins != from.bins || to.front != from.front || to.back != from.back) {
    throw Error("the deep films have different sizes or bins; expected the same to add them");
  }
  for (std::size_t i = 0; i < to.pixels.size(); ++i) {
    for (const DeepBin& b : from.pixels[i]) {
      DeepBin& bin = bin_at(to.pixels[i], b.number, to.bins);
      bin.sum += b.sum;
      bin.count += b.count;
    }
  }
  for (std::size_t i = 0; i < to.surfaces.size(); ++i) {
    for (const DeepSurface& s : from.surfaces[i]) {
      add_sums(surface_at(to.surfaces[i], s.number, to.bins), s);
    }
  }
}

}  // namespace pvol
