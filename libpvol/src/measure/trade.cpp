#include "pvol/measure/trade.h"

#include <algorithm>
#include <cmath>

#include "pvol/error.h"
#include "pvol/measure/compare.h"

namespace pvol::measure {
namespace {

/// Probability that fewer than k of n fair coins show heads: that the k-th smallest of n values
/// lies above the median.
double few_heads(std::size_t n, std::size_t k) {
  double sum = 0;
  for (std::size_t i = 0; i < k; ++i) {
    sum += std::exp(std::lgamma(double(n) + 1) - std::lgamma(double(i) + 1) -
                    std::lgamma(double(n - i) + 1) - double(n) * std::log(2.0));
  }
  return sum;
}

double error_after(const Setting& s, double samples) {
  return std::sqrt(s.offset + s.variance * s.doubt / samples);
}

Advice describe(std::span<const Setting> settings, std::size_t i, double pixels, double samples) {
  Advice a = forecast(settings[i], pixels, samples);
  a.setting = i;
  return a;
}

}  // namespace

Estimate estimate_median(std::vector<double> values, double coverage) {
  if (values.empty()) throw Error("the median of no values is not defined; expected at least one");
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  Estimate e;
  e.value = n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
  // The k-th smallest and the k-th largest miss the median with probability 2 few_heads(n, k).
  std::size_t k = 1;
  while (2 * (k + 1) <= n && 1 - 2 * few_heads(n, k + 1) >= coverage) ++k;
  e.low = values[k - 1], e.high = values[n - k];
  e.coverage = std::max(0.0, 1 - 2 * few_heads(n, k));
  return e;
}

Estimate estimate_ratio(std::span<const double> a, std::span<const double> b, double coverage) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    // 0 / 0: neither of the two costs anything, or varies.
    ratios.push_back(a[i] == b[i] ? 1 : a[i] / b[i]);
  }
  return estimate_median(std::move(ratios), coverage);
}

Estimate inverse(const Estimate& e) { return {1 / e.value, 1 / e.high, 1 / e.low, e.coverage}; }

double median(const std::vector<double>& values) {
  return values.empty() ? 0 : estimate_median(values).value;
}

double sidak_level(double family, std::size_t comparisons) {
  return comparisons == 0 ? family : -std::expm1(std::log1p(-family) / double(comparisons));
}

double mean_luminance(const Film& film) {
  double sum = 0;
  for (const PixelSums& p : film.pixels) sum += luminance(mean(p));
  return film.pixels.empty() ? 0 : sum / double(film.pixels.size());
}

double sample_variance(const Film& film) {
  double sum = 0;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    sum += luminance_variance(film, i) * film.pixels[i].samples;
  }
  return film.pixels.empty() ? 0 : sum / double(film.pixels.size());
}

std::vector<std::size_t> pareto_front(std::span<const Costs> settings) {
  const auto beats = [](const Costs& a, const Costs& b) {
    bool never_more = true, once_less = false;
    for (std::size_t i = 0; i < a.size(); ++i) {
      never_more = never_more && a[i] <= b[i];
      once_less = once_less || a[i] < b[i];
    }
    return never_more && once_less;
  };
  std::vector<std::size_t> front;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const bool beaten = std::any_of(settings.begin(), settings.end(),
                                    [&](const Costs& other) { return beats(other, settings[i]); });
    if (!beaten) front.push_back(i);
  }
  return front;
}

Advice forecast(const Setting& s, double pixels, double samples) {
  return {0, samples, s.set_up + samples * pixels * s.seconds,
          std::sqrt(s.offset + s.variance / samples)};
}

std::optional<Advice> advise_for_error(std::span<const Setting> settings, double pixels,
                                       double error) {
  const auto samples_for = [&](const Setting& s, double doubt) {
    return std::max(1.0, std::ceil(s.variance * doubt / (error * error - s.offset)));
  };
  std::optional<std::size_t> best;
  double least = 0;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const Setting& s = settings[i];
    if (!(s.offset < error * error)) continue;
    const double seconds = s.set_up + samples_for(s, s.doubt) * pixels * s.seconds;
    if (!best || seconds < least) best = i, least = seconds;
  }
  if (!best) return std::nullopt;
  return describe(settings, *best, pixels, samples_for(settings[*best], 1));
}

std::optional<Advice> advise_for_time(std::span<const Setting> settings, double pixels,
                                      double seconds) {
  const auto samples_in = [&](const Setting& s) {
    return std::floor((seconds - s.set_up) / (pixels * s.seconds));
  };
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const double samples = samples_in(settings[i]);
    if (samples < 1) continue;
    if (!best || error_after(settings[i], samples) <
                     error_after(settings[*best], samples_in(settings[*best]))) {
      best = i;
    }
  }
  if (!best) return std::nullopt;
  return describe(settings, *best, pixels, samples_in(settings[*best]));
}

}  // namespace pvol::measure
