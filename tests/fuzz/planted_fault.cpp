// A target with faults, by which replay.cpp proves that it reports faults.
#include <string>
#include <vector>

#include "fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(data, data + size);
  pvol::fuzz::accepts([&] {
    if (text == "refused\n") throw pvol::Error("as it should be");
    if (text == "fault\n") throw std::out_of_range("planted");
    if (text == "too large\n") std::vector<char>(0).reserve(600'000'000);
  });
  return 0;
}
