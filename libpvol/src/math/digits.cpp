#include "math/digits.h"

#include <cstdio>

namespace pvol::detail {

std::string digits(double v, int count) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", count, v);
  return text;
}

}  // namespace pvol::detail
