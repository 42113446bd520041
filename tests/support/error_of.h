// What a call throws, in words.
#pragma once

#include <string>

#include "pvol/error.h"

namespace pvol::test {

/// The message of the Error that the call throws; "" where it throws none.
[[nodiscard]] std::string error_of(const auto& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

}  // namespace pvol::test
