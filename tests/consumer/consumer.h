// The consumer's own calls, each in a source that includes what it needs of pvol.
#pragma once

#include "pvol/embed.h"

/// Whether a ray gets through the cloud, by a tracker of the consumer's own.
bool passes(const pvol::Volume& cloud, const pvol::Ray& ray, pvol::Rng& rng);

/// How often a path turns in the cloud, where it scatters evenly in all directions.
int count_turns(const pvol::Volume& cloud, const pvol::Ray& ray, pvol::Rng& rng);

/// The mean radiance of a small picture of the cloud, under a sky of radiance 1 where nothing is
/// absorbed: 1.
double mean_of_picture(const pvol::Volume& cloud);
