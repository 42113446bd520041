// The one exception that pvol throws for bad input.
#pragma once

#include <stdexcept>

namespace pvol {

/// Bad input: a damaged file, a value out of range, a request that cannot be met. `what()` is one
/// sentence or two for the person at the terminal: where it happened, what was found, what was
/// expected, and what to do about it. Programming errors are asserts instead.
struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace pvol
