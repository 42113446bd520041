#include "pbrt/pbrt_color.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "file/mesh_read.h"
#include "pvol/math/observer.h"
#include "pvol/volume/blackbody.h"

namespace pvol::formats::detail {
namespace {

/// A table at the wavelengths of the observer, linear between them.
template <class Table>
auto at_wavelength(const Table& table, double nm) {
  const double at = (nm - kFirstNm) / kStepNm;
  const auto i = std::min(std::size_t(at), table.size() - 2);
  const double u = at - double(i);
  return table[i] * (1 - u) + table[i + 1] * u;
}

/// What the observer sees of f(nm): X, Y and Z, not normalised.
template <class F>
Vec3d seen(const F& f) {
  Vec3d sum;
  const double last = kFirstNm + kStepNm * double(kObserver.size() - 1);
  for (double nm = kFirstNm; nm <= last; ++nm) sum += at_wavelength(kObserver, nm) * f(nm);
  return sum;
}

/// Pairs of wavelength and value, linear between them, and 0 beyond them as pbrt has it.
class Wavelengths {
 public:
  explicit Wavelengths(const PbrtParameter& p) : n_(p.numbers) {
    bool ascends = n_.size() >= 2 && n_.size() % 2 == 0;
    for (std::size_t i = 2; i + 1 < n_.size(); i += 2) ascends = ascends && n_[i] > n_[i - 2];
    if (!ascends) {
      fail_at(p.where, fmt::format("{} numbers in \"{}\"", n_.size(), shown(p.name)),
              "pairs of a wavelength in nm, ascending, and a value");
    }
  }

  [[nodiscard]] double operator()(double nm) const {
    if (nm < n_.front() || nm > n_[n_.size() - 2]) return 0;
    std::size_t at = 0;
    while (at + 2 < n_.size() && n_[at + 2] <= nm) at += 2;
    if (at + 2 >= n_.size()) return n_[at + 1];
    const double share = (nm - n_[at]) / (n_[at + 2] - n_[at]);
    return n_[at + 1] + share * (n_[at + 3] - n_[at + 1]);
  }

  /// Whether all that is visible has one value.
  [[nodiscard]] bool is_even() const {
    if (n_.front() > 400 || n_[n_.size() - 2] < 700) return false;
    for (std::size_t i = 3; i < n_.size(); i += 2) {
      if (n_[i] != n_[1]) return false;
    }
    return true;
  }

 private:
  const std::vector<double>& n_;
};

/// The light's colour, of luminance 1.
Vec3d color_of_light(const Wavelengths& w) {
  const Vec3d xyz = seen(w);
  return xyz.y > 0 ? rec709(xyz / xyz.y) : Vec3d(0.0);
}

/// As in the light of D65, in which what is even is grey.
Vec3d color_of_matter(const Wavelengths& w) {
  const auto light = [](double nm) { return at_wavelength(kD65, nm); };
  const Vec3d white = rec709(seen(light));
  const Vec3d color = rec709(seen([&](double nm) { return w(nm) * light(nm); }));
  return {color.x / white.x, color.y / white.y, color.z / white.z};
}

/// Without what is negative, of luminance 1 or black.
Rgb into_gamut(Vec3d color) {
  const Rgb inside(max(color, Vec3d(0.0)));
  const double y = double(luminance(inside));
  return y > 0 ? Rgb(Vec3d(inside) / y) : inside;
}

Rgb from_wavelengths(const PbrtParameter& p, PbrtSpectrum what, ImportNotes& notes) {
  const Wavelengths w(p);
  for (std::size_t i = 1; i < p.numbers.size(); i += 2) {
    if (!(p.numbers[i] >= 0)) {
      fail_at(p.where, fmt::format("{} in \"{}\"", p.numbers[i], shown(p.name)),
              "values of at least 0");
    }
  }
  const bool is_light = what == PbrtSpectrum::light;
  const Vec3d color = is_light ? color_of_light(w) : color_of_matter(w);
  if (!w.is_even()) {
    const bool outside = min_component(color) < 0;
    notes.add(p.where,
              fmt::format("\"{}\" is given by wavelength: it becomes the RGB that the "
                          "CIE observer sees{}",
                          shown(p.name), outside ? ", brought into the gamut of Rec.709" : ""));
  }
  return is_light ? into_gamut(color) : Rgb(max(color, Vec3d(0.0)));
}

Rgb at_least_0(const PbrtParameter& p, Rgb color) {
  if (min_component(color) >= 0 && is_finite(color)) return color;
  fail_at(p.where, fmt::format("\"{}\" of {}, {}, {}", shown(p.name), color.x, color.y, color.z),
          "numbers of at least 0");
}

}  // namespace

std::optional<Rgb> color_of(const PbrtThing& thing, std::string_view name, PbrtSpectrum what,
                            ImportNotes& notes) {
  const PbrtParameter* p = thing.parameters.find(name);
  if (p == nullptr) return std::nullopt;
  const std::vector<double>& n = p->numbers;
  const std::size_t wanted = p->type == "rgb" ? 3 : 1;
  if (p->strings.empty() && n.size() < wanted) {
    fail_at(p->where, fmt::format("\"{}\" with {} numbers", shown(p->name), n.size()),
            fmt::format("{} or more", wanted));
  }
  const std::string called = fmt::format("\"{}\"", shown(p->name));
  if (p->type == "rgb") return at_least_0(*p, Rgb(Vec3d{n[0], n[1], n[2]}));
  if (p->type == "float") return at_least_0(*p, Rgb(float(n[0])));
  if (p->type == "blackbody") {
    if (what == PbrtSpectrum::light) return blackbody_color(float(n[0]));
    notes.add(p->where, called + " of a medium is a black body: its colour is taken as 1");
    return Rgb(1.0f);
  }
  if (!p->strings.empty()) {
    if (p->strings.front() != "stdillum-D65" || what == PbrtSpectrum::reflectance) {
      notes.add(p->where, fmt::format("{} is the spectrum \"{}\", taken as white", called,
                                      shown(p->strings.front())));
    }
    return Rgb(1.0f);
  }
  return from_wavelengths(*p, what, notes);
}

Rgb peak_normalised_blackbody(double kelvin) {
  constexpr double kSecond = 1.438776877e7;    // second radiation constant, nm K
  constexpr double kPeak = 4.965114231744276;  // of x^5 / (e^x - 1): Wien's law
  const double at_peak = std::pow(kPeak, 5) / std::expm1(kPeak);
  double sum = 0;
  for (std::size_t i = 0; i < kObserver.size(); ++i) {
    const double x = kSecond / ((kFirstNm + kStepNm * double(i)) * kelvin);
    sum += kStepNm * kObserver[i].y * std::pow(x, 5) / std::expm1(x) / at_peak;
  }
  return Rgb(Vec3d(blackbody_color(float(kelvin))) * sum);
}

}  // namespace pvol::formats::detail
