#include "pvol/measure/filtered.h"

#include <cmath>

#include "pvol/error.h"
#include "pvol/measure/compare.h"
#include "pvol/measure/student.h"
#include "pvol/measure/trade.h"

namespace pvol::measure {
namespace {

Interval interval_of(const std::vector<double>& values) {
  const double n = double(values.size());
  double sum = 0, squares = 0;
  for (const double v : values) sum += v;
  const double mean = sum / n;
  for (const double v : values) squares += (v - mean) * (v - mean);
  const double error = n > 1 ? std::sqrt(squares / (n * (n - 1))) : 0;
  const double t = student_quantile(0.95, n - 1);
  return {mean, n > 1 ? error * t : t};
}

/// Mean over pixels of the squared difference, channels weighted as in luminance, less what the
/// reference's noise adds.
template <class Colour>
double squared_error(const Film& reference, const Colour& colour) {
  double sum = 0;
  for (std::size_t i = 0; i < reference.pixels.size(); ++i) {
    const PixelSums& p = reference.pixels[i];
    const Vec3d d = colour(i) - mean(p);
    sum += luminance(d * d) - noise_of(p);
  }
  return sum / double(reference.pixels.size());
}

/// A film whose samples are the filtered pictures.
Film film_of(std::span<const FilterTrial> trials) {
  Film film = trials.front().film;
  film.layers.clear(), film.counts.clear();
  film.remainders = {};
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    PixelSums p;
    for (const FilterTrial& t : trials) {
      const Vec3d c = t.filtered.colour[i];
      p.sum += c, p.sum_squares += c * c, ++p.samples;
    }
    film.pixels[i] = p;
  }
  return film;
}

/// 0 of a negative estimate; NaN of one that is not known.
double root(double square) { return square < 0 ? 0 : std::sqrt(square); }

}  // namespace

FilterFigures judge_filter(const Film& reference, std::span<const FilterTrial> trials) {
  const double light = mean_luminance(reference);
  if (!(light > 0))
    throw Error("the reference is black, so relative errors are not defined; add light");
  FilterFigures f;
  f.trials = int(trials.size());
  const double n = double(trials.size()), pixels = double(reference.pixels.size());
  std::vector<double> squares, shifts;
  double noisy = 0, estimated = 0;
  for (const FilterTrial& t : trials) {
    if (t.film.pixels.size() != reference.pixels.size()) {
      throw Error("the films have different sizes; expected the same size and crop");
    }
    const auto clean = [&](std::size_t i) { return t.filtered.colour[i]; };
    noisy += squared_error(reference, [&](std::size_t i) { return mean(t.film.pixels[i]); }) / n;
    squares.push_back(squared_error(reference, clean) / (light * light));
    double shift = 0;
    for (std::size_t i = 0; i < t.film.pixels.size(); ++i) {
      shift += luminance(clean(i) - mean(t.film.pixels[i]));
      f.samples += t.film.pixels[i].samples;
    }
    shifts.push_back(shift / (pixels * light));
    estimated += t.filtered.relative_error * t.filtered.relative_error / n;
    f.plain_seconds += t.plain_seconds / n;
    f.render_seconds += t.render_seconds / n, f.filter_seconds += t.filter_seconds / n;
  }
  f.samples /= n * pixels;
  const Interval square = interval_of(squares);
  f.noisy = root(noisy) / light;
  f.filtered = root(square.value), f.filtered_square_half_width = square.half_width;
  f.estimated = std::sqrt(estimated);
  f.bias = interval_of(shifts);
  const ChannelComparison c = compare(film_of(trials), reference).luminance;
  f.systematic = root(c.systematic_mse) / light;
  f.systematic_square_half_width = c.systematic_half_width / (light * light);
  return f;
}

FilterAdvice advise_plain(std::span<const FilterFigures> figures, double error) {
  const FilterFigures& most = figures.back();
  const double times = most.noisy / error;
  return {times * times * most.samples, times * times * most.plain_seconds};
}

std::optional<FilterAdvice> advise_filtered(std::span<const FilterFigures> figures, double error) {
  if (figures.front().filtered <= error) {
    return FilterAdvice{figures.front().samples, figures.front().seconds()};
  }
  for (std::size_t i = 1; i < figures.size(); ++i) {
    const FilterFigures &a = figures[i - 1], &b = figures[i];
    if (b.filtered > error) continue;
    const double share = std::log(a.filtered / error) / std::log(a.filtered / b.filtered);
    const auto between = [share](double from, double to) {
      return from * std::pow(to / from, share);
    };
    return FilterAdvice{between(a.samples, b.samples), between(a.seconds(), b.seconds())};
  }
  return std::nullopt;
}

}  // namespace pvol::measure
