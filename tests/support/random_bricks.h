// Bricks of random samples.
#pragma once

#include "pvol/field/brick_field.h"
#include "support/fields.h"
#include "support/flights.h"

namespace pvol::test {

/// A field of bricks by `value(rng)`, the first of them zero as in every field.
template <class Value>
BrickField random_bricks(int bricks, std::uint64_t stream, const Value& value) {
  BrickField f;
  f.samples.assign(kFieldSamples, 0.0f);
  Rng rng(kSeed, stream, 0);
  for (int i = 0; i < bricks * kFieldSamples; ++i) f.samples.push_back(value(rng));
  return f;
}

}  // namespace pvol::test
