#include "pbrt/pbrt_color.h"

#include <fmt/format.h>

#include <cmath>

#include "file/mesh_read.h"
#include "pvol/volume/blackbody.h"

namespace pvol::formats::detail {
namespace {

/// The observer's y, within 1 %: Wyman, Sloan, Shirley. Simple analytic approximations to the CIE
/// XYZ color matching functions. JCGT 2013.
double luminosity(double nm) {
  const auto lobe = [&](double size, double centre, double below, double above) {
    const double t = (nm - centre) / (nm < centre ? below : above);
    return size * std::exp(-0.5 * t * t);
  };
  return lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1);
}

/// Pairs of wavelength and value, linear between them, as means over thirds.
Rgb from_wavelengths(const PbrtParameter& p) {
  const std::vector<double>& n = p.numbers;
  bool ascends = n.size() >= 2 && n.size() % 2 == 0;
  for (std::size_t i = 2; i + 1 < n.size(); i += 2) ascends = ascends && n[i] > n[i - 2];
  if (!ascends) {
    fail_at(p.where, fmt::format("{} numbers in \"{}\"", n.size(), shown(p.name)),
            "pairs of a wavelength in nm, ascending, and a value");
  }
  std::size_t at = 0;
  const auto value = [&](double nm) {
    while (at + 2 < n.size() && n[at + 2] <= nm) at += 2;
    if (nm < n[0] || at + 2 >= n.size()) return nm < n[0] ? n[1] : n[at + 1];
    const double share = (nm - n[at]) / (n[at + 2] - n[at]);
    return n[at + 1] + share * (n[at + 3] - n[at + 1]);
  };
  constexpr int kSteps = 100;
  Vec3d blue_to_red;
  for (int third = 0; third < 3; ++third) {
    for (int i = 0; i < kSteps; ++i) {
      blue_to_red[third] += value(400 + 100 * third + (i + 0.5) * 100 / kSteps) / kSteps;
    }
  }
  return Rgb(Vec3d(blue_to_red.z, blue_to_red.y, blue_to_red.x));
}

Rgb at_least_0(const PbrtParameter& p, Rgb color) {
  if (min_component(color) >= 0 && is_finite(color)) return color;
  fail_at(p.where, fmt::format("\"{}\" of {}, {}, {}", shown(p.name), color.x, color.y, color.z),
          "numbers of at least 0");
}

}  // namespace

std::optional<Rgb> color_of(const PbrtThing& thing, std::string_view name, PbrtSpectrum what,
                            PbrtNotes& notes) {
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
  bool even = true;
  for (std::size_t i = 3; i < n.size(); i += 2) even = even && n[i] == n[1];
  if (!even)
    notes.add(
        p->where,
        called + " is given by wavelength: it becomes RGB by means over thirds of the spectrum");
  const Rgb color = at_least_0(*p, from_wavelengths(*p));
  const double y = double(luminance(color));
  return what == PbrtSpectrum::reflectance || !(y > 0) ? color : Rgb(Vec3d(color) / y);
}

Rgb peak_normalised_blackbody(double kelvin) {
  constexpr double kSecond = 1.438776877e7;    // second radiation constant, nm K
  constexpr double kPeak = 4.965114231744276;  // of x^5 / (e^x - 1): Wien's law
  const double at_peak = std::pow(kPeak, 5) / std::expm1(kPeak);
  double sum = 0;
  for (int nm = 360; nm < 830; nm += 2) {
    const double x = kSecond / (nm * kelvin);
    sum += 2 * luminosity(nm) * std::pow(x, 5) / std::expm1(x) / at_peak;
  }
  return Rgb(Vec3d(blackbody_color(float(kelvin))) * sum);
}

}  // namespace pvol::formats::detail
