// A target with faults, by which replay.cpp proves that it reports faults.
#include <string>
#include <vector>

#include "fuzz.h"

/// Where memory goes that nobody uses: compilers may else leave it out.
volatile std::size_t capacity;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(data, data + size);
  pvol::fuzz::accepts([&] {
    if (text == "refused\n") throw pvol::Error("as it should be");
    if (text == "fault\n") throw std::out_of_range("planted");
    if (text == "too large\n") {
      std::vector<char> much;
      much.reserve(600'000'000);
      capacity = much.capacity() + reinterpret_cast<std::uintptr_t>(much.data());
    }
  });
  return 0;
}
