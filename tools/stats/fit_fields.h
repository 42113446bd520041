// What a .pvol file holds besides the density: grids of numbers, colours and velocities.
#pragma once

#include <string>

#include "stats/fit_report.h"

namespace pvol::cli {

/// Of a grid of the input, whose bounds were made for an interpolation.
[[nodiscard]] formats::Metadata describe_source(const FitOptions& o,
                                                const formats::LoadedGrid& loaded, LookUp look_up);

/// Whether samples are kept as codes.
[[nodiscard]] bool is_quantised(const FitOptions& o);

/// Turns the samples into codes and from there on takes what these stand for as the density.
void quantise_density(const FitOptions& o, formats::LoadedGrid& loaded, formats::PvolFile& file);

/// Adds the grids that --fields asks for to the file, but the one that is taken as the density.
/// Throws what reading them throws.
void add_fields(const FitOptions& o, const std::string& taken, Fit& f);

}  // namespace pvol::cli
