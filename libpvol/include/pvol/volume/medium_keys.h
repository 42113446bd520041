// What users set of a medium: the rows of its components and of every phase function.
#pragma once

#include "pvol/math/keys.h"
#include "pvol/volume/medium.h"

namespace pvol {

/// Of radiance, emission, irradiance and intensity: sums of their squares over all samples stay far
/// inside double, and they themselves inside float.
inline constexpr Range kRadianceRange = Range::closed(0, 1e30);

template <std::same_as<HenyeyGreenstein> H>
[[nodiscard]] constexpr auto keys(const H&) {
  return std::to_array<Key<H>>({
      {{.key = "g",
        .metavar = "G",
        .limits = number(Range::closed(-kLargestMeanCosine, kLargestMeanCosine)),
        .help = "Mean cosine of the scattering angle (Henyey-Greenstein): above 0 scatters "
                "forward, 0 evenly"},
       [](const H& hg) { return to_value(hg.mean_cosine); },
       [](H& hg, const Value& v) { hg = H(*v.number()); }},
  });
}

template <std::same_as<TwoLobes> P>
[[nodiscard]] constexpr auto keys(const P&) {
  constexpr Limits kCosine = number(Range::closed(-kLargestMeanCosine, kLargestMeanCosine));
  return std::to_array<Key<P>>({
      {{.key = "g_forward",
        .metavar = "G",
        .limits = kCosine,
        .help = "Mean cosine of the first of two Henyey-Greenstein lobes, instead of g"},
       [](const P& p) { return to_value(p.forward.mean_cosine); },
       [](P& p, const Value& v) { p.forward = HenyeyGreenstein(*v.number()); }},
      {{.key = "g_backward",
        .metavar = "G",
        .limits = kCosine,
        .help = "Mean cosine of the second lobe"},
       [](const P& p) { return to_value(p.backward.mean_cosine); },
       [](P& p, const Value& v) { p.backward = HenyeyGreenstein(*v.number()); }},
      key<&P::share>({.key = "forward_share",
                      .metavar = "X",
                      .limits = number(Range::closed(0, 1)),
                      .help = "Weight of the first lobe"}),
  });
}

/// What was expected of a value but true.
[[nodiscard]] const char* expect_true(const Value& value);

template <std::same_as<Rayleigh> P>
[[nodiscard]] constexpr auto keys(const P&) {
  return std::to_array<Key<P>>({
      {{.key = "rayleigh",
        .limits = flag().also(expect_true),
        .help = "Replaces g: whether particles are much smaller than the wavelength, as those of "
                "air are (Rayleigh)",
        .otherwise = "none"},
       [](const P&) { return to_value(true); },
       [](P&, const Value&) {}},
  });
}

template <std::same_as<Draine> P>
[[nodiscard]] constexpr auto keys(const P&) {
  return std::to_array<Key<P>>({
      {{.key = "draine_g",
        .metavar = "G",
        .limits = number(Range::closed(-kLargestMeanCosine, kLargestMeanCosine)),
        .help = "Replaces g: Draine's phase function, with this g in its Henyey-Greenstein factor"},
       [](const P& p) { return to_value(p.lobe.mean_cosine); },
       [](P& p, const Value& v) { p = P(*v.number(), p.alpha); }},
      {{.key = "draine_alpha",
        .metavar = "X",
        .limits = number(Range::closed(0, kLargestAlpha)),
        .help =
            "Weight of the squared cosine: 0 is Henyey-Greenstein, 1 with draine_g = 0 Rayleigh"},
       [](const P& p) { return to_value(p.alpha); },
       [](P& p, const Value& v) { p = P(p.lobe.mean_cosine, *v.number()); }},
  });
}

template <std::same_as<Droplets> P>
[[nodiscard]] constexpr auto keys(const P&) {
  return std::to_array<Key<P>>({
      {{.key = "droplet_diameter",
        .metavar = "X",
        .limits = number({.lo = 0, .hi = kLargestDroplet, .lo_open = true}),
        .help = "Replaces g: phase function of water droplets of this diameter in micrometres; fog "
                "has 1 to 20, clouds 10 to 30"},
       [](const P& p) { return to_value(p.diameter); },
       [](P& p, const Value& v) { p = P(*v.number()); }},
  });
}

/// Of points [angle, value].
[[nodiscard]] Value to_value(const PhaseTable& table);
[[nodiscard]] std::vector<PhaseTable::Point> phase_points(const Value& rows);
[[nodiscard]] const char* expect_phase_points(const Value& rows);

template <std::same_as<PhaseTable> P>
[[nodiscard]] constexpr auto keys(const P&) {
  return std::to_array<Key<P>>({
      {{.key = "phase_table",
        .metavar = "TABLE",
        .limits = number().times(2).in_rows().also(expect_phase_points),
        .help =
            "Replaces g: points [angle in degrees, value] from 0 to 180, between which the value "
            "is linear in the cosine, in any unit; or a text file with one point per line",
        .otherwise = "none"},
       [](const P& p) { return to_value(p); },
       [](P& p, const Value& v) { p = P(phase_points(v)); }},
  });
}

template <std::same_as<Component> C>
[[nodiscard]] constexpr auto keys(const C&) {
  return std::to_array<Key<C>>({
      key<&C::share>({.key = "share",
                      .metavar = "X",
                      .limits = number(Range::closed(0, 1)),
                      .help = "Share of the extinction; the medium itself has the rest",
                      .required = true}),
      key<&C::albedo>({.key = "albedo",
                       .metavar = "RGB",
                       .limits = number(Range::closed(0, 1)).or_three(),
                       .help = "Ratio of scattering to extinction"}),
      keys_of_kind<&C::phase>(),
      key<&C::emission>({.key = "emission",
                         .metavar = "RGB",
                         .limits = number(kRadianceRange).or_three(),
                         .help = "Radiance that the absorbing part of the medium emits"}),
  });
}

/// Three of which none is 1 leave the extinction to another number.
[[nodiscard]] const char* expect_a_one(const Value& value);

template <std::same_as<Medium> T>
[[nodiscard]] constexpr auto keys(const T&) {
  return std::to_array<Key<T>>({
      key<&T::extinction>({.key = "extinction",
                           .metavar = "X",
                           .limits = number(Range::at_least(0)),
                           .help = "Extinction per world unit and unit of density",
                           .otherwise = "chosen for the cloud, and printed"}),
      key<&T::extinction_color>(
          {.key = "extinction_color",
           .metavar = "RGB",
           .limits = number(Range::closed(0, 1)).or_three().also(expect_a_one),
           .help = "Extinction by channel, relative to the largest, which is 1; rendering takes "
                   "about three times as long as in grey"}),
  });
}

}  // namespace pvol
