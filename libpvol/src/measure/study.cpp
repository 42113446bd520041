#include "pvol/measure/study.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "pvol/error.h"

namespace pvol::measure {
namespace {

/// op(a[i], b[i]) for what both have.
template <class Op>
std::vector<double> by_round(const std::vector<double>& a, const std::vector<double>& b, Op op) {
  std::vector<double> values;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) values.push_back(op(a[i], b[i]));
  return values;
}

/// Those of a setting's values whose rounds the other one has as well.
std::vector<double> in_rounds_of(const Measured& other, const Measured& m,
                                 const std::vector<double>& values) {
  std::vector<double> common;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::ranges::binary_search(other.round, m.round[i])) common.push_back(values[i]);
  }
  return common;
}

Work work_of(const Measured& m) {
  if (m.counted == 0) return {};
  const Counts& k = m.counts;
  const double n = double(m.counted);
  return {double(k.path.lookups + k.shadow.lookups) / n,
          double(k.path.bounds_tests + k.shadow.bounds_tests) / n,
          double(k.path.segments + k.shadow.segments) / n};
}

/// The ratio where the first varies, and 1 where nothing does.
void relate(Row& row, const Row& base) {
  const Measured &m = row.measured, &b = base.measured;
  const auto ratio = [&](const std::vector<double>& of_m, const std::vector<double>& of_b) {
    return estimate_ratio(in_rounds_of(b, m, of_m), in_rounds_of(m, b, of_b));
  };
  const auto cost = [](const Measured& of) {
    return by_round(of.seconds, of.variance, std::multiplies<>());
  };
  row.time = ratio(m.seconds, b.seconds);
  row.variance = ratio(m.variance, b.variance);
  row.cost = ratio(cost(m), cost(b));
  if (!m.instructions.empty() && !b.instructions.empty()) {
    row.instructions = ratio(m.instructions, b.instructions);
  }
  row.work = work_of(m);
  row.sample_variance = sample_variance(m.film);
}

/// In units of the reference's mean luminance. Time and variance are the first's times the ratios
/// measured in turn, so that a busy spell of the machine favours none.
Setting setting_of(const Row& row, const Row& base, double mean) {
  Setting s;
  s.seconds = median(base.measured.seconds) * row.time.value;
  s.set_up = median(row.measured.set_up_seconds);
  s.variance = base.sample_variance / (mean * mean) * row.variance.value;
  s.offset = row.offset() * row.offset();
  const double cost = row.time.value * row.variance.value;
  if (&row != &base && cost > 0) s.doubt = std::max(1.0, row.cost.high / cost);
  return s;
}

/// What a film's own noise adds to a mean squared error against it.
double noise_in(const Film& film) {
  double noise = 0;
  for (const PixelSums& p : film.pixels) noise += noise_of(p) / double(film.pixels.size());
  return noise;
}

/// n x (MSE - what the reference's own noise adds), over the reference's mean.
double rmse_of_one_sample(const FilmComparison& c, const Film& film, double noise) {
  const double n = film.pixels.front().samples;
  return std::sqrt(std::max(0.0, n * (c.luminance.mse - noise))) / std::abs(c.luminance.mean_b);
}

/// The best of each factor, the factor that gains most first: indices of settings.
std::vector<std::size_t> best_of_factors(const std::vector<Variant>& singles,
                                         const std::vector<VariantResult>& results, bool biased,
                                         double most_offset) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < singles.size(); ++i) {
    const VariantResult& r = results[i];
    if (r.measured && singles[i].biased == biased && r.proven_gain < 1 && r.offset <= most_offset) {
      order.push_back(i);
    }
  }
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return results[a].gain < results[b].gain; });
  std::vector<std::size_t> best;
  for (const std::size_t i : order) {
    const bool taken = std::any_of(best.begin(), best.end(), [&](std::size_t b) {
      return singles[b].factor == singles[i].factor;
    });
    if (!taken) best.push_back(i);
  }
  return best;
}

}  // namespace

double Row::offset() const {
  if (!variant.biased && !detected()) return 0;
  const ChannelComparison& c = bias.luminance;
  const double spread = c.systematic_half_width, mean = std::abs(c.mean_b);
  const double squared = c.systematic_mse + (std::isfinite(spread) ? spread : 0);
  // The mean's own bias is part of the systematic error, and known better.
  return mean > 0 ? std::max(std::sqrt(std::max(0.0, squared)), std::abs(c.bias)) / mean : 0;
}

double Row::proven_cost() const {
  constexpr double kHair = 1e-9;
  if (variant.option.empty()) return 1;
  return cost.low <= 1 && cost.high >= 1 ? 1 + kHair : cost.value;
}

double Row::bytes() const { return double(measured.set_up.bytes()) + double(file_bytes); }

void set_reference(Study& study, Film reference) {
  study.reference = std::move(reference);
  study.reference_mean = mean_luminance(study.reference);
  if (!(study.reference_mean > 0)) {
    throw Error("the picture is black, so there is no error to measure; add light");
  }
  study.reference_samples = study.reference.pixels.front().samples;
}

std::vector<Row> make_rows(const std::vector<Variant>& variants, std::vector<Measured> measured) {
  std::vector<Row> rows(variants.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].variant = variants[i];
    rows[i].measured = std::move(measured[i]);
    if (rows[i].good()) relate(rows[i], rows[0]);
  }
  return rows;
}

void test_biases(Study& study) {
  std::size_t tests = 0;
  for (const Row& row : study.rows) tests += row.good();
  study.level = sidak_level(kFalseAlarms, tests);
  const double noise = noise_in(study.reference);
  for (Row& row : study.rows) {
    if (!row.good()) continue;
    row.bias = compare(row.measured.film, study.reference, {.level = study.level});
    row.rmse_of_one_sample = rmse_of_one_sample(row.bias, row.measured.film, noise);
  }
}

void judge(Study& study) {
  test_biases(study);
  std::vector<std::size_t> good;
  std::vector<Costs> costs;
  std::vector<Setting> settings;
  for (std::size_t i = 0; i < study.rows.size(); ++i) {
    Row& row = study.rows[i];
    if (!row.good()) continue;
    row.setting = setting_of(row, study.rows[0], study.reference_mean);
    good.push_back(i);
    settings.push_back(row.setting);
    // Less than a per cent of the bytes is no reason to choose a setting.
    const double bytes = std::round(100 * row.bytes() / study.rows[0].bytes());
    costs.push_back({row.proven_cost(), row.offset(), bytes});
  }
  for (const std::size_t i : pareto_front(costs)) study.rows[good[i]].on_front = true;
  for (Goal& g : study.goals) {
    g.advice = g.error ? advise_for_error(settings, study.picture_pixels, *g.error)
                       : advise_for_time(settings, study.picture_pixels, *g.seconds);
    if (g.advice) g.advice->setting = good[g.advice->setting];
  }
}

Coverage coverage(const Study& study) {
  Coverage c{study.rows.front().measured.rounds(), 1};
  for (const Row& row : study.rows) {
    if (!row.good()) continue;
    c.probability = std::min(c.probability, row.time.coverage);
    c.rounds = std::min(c.rounds, row.measured.rounds());
  }
  return c;
}

VariantResult result_of(const Row& row) {
  if (!row.good()) return {};
  return {true, row.cost.value, row.cost.high, row.offset()};
}

std::vector<std::vector<std::size_t>> combinations(const std::vector<Variant>& singles,
                                                   const std::vector<VariantResult>& results) {
  constexpr std::size_t kFactors = 3, kBiasedFactors = 2;
  constexpr double kMostOffset = 0.02;
  std::vector<std::size_t> best = best_of_factors(singles, results, false, 0);
  if (best.size() > kFactors) best.resize(kFactors);
  std::vector<std::vector<std::size_t>> list;
  for (std::size_t i = 0; i < best.size(); ++i) {
    for (std::size_t j = i + 1; j < best.size(); ++j) list.push_back({best[i], best[j]});
  }
  if (best.size() == 3) list.push_back(best);

  std::vector<std::size_t> biased = best_of_factors(singles, results, true, kMostOffset);
  if (biased.size() > kBiasedFactors) biased.resize(kBiasedFactors);
  if (biased.size() == 2) list.push_back(biased);
  for (const std::size_t i : biased) {
    if (!best.empty()) list.push_back({i, best[0]});
  }
  return list;
}

BuildRatios compare_building(const BuildTimes& of, const BuildTimes& base) {
  const auto all = [](const BuildTimes& t) { return by_round(t.bounds, t.tree, std::plus<>()); };
  return {estimate_ratio(all(of), all(base)), estimate_ratio(of.tree, base.tree)};
}

}  // namespace pvol::measure
