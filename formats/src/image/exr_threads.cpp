#include "image/exr_threads.h"

#include <ImfThreading.h>

#include <algorithm>
#include <thread>

#include "image/exr_zip.h"
#include "pvol/formats/image.h"

namespace pvol::formats {
namespace detail {

int rows_at_once(int height, std::size_t row_bytes) {
  constexpr std::size_t kMostBytes = std::size_t{32} << 20, kBlocksOfEach = 2;
  const auto threads = std::size_t(std::max(1, Imf::globalThreadCount()));
  const std::size_t fitting = kMostBytes / (row_bytes * kZipRows);
  const std::size_t blocks = std::clamp<std::size_t>(fitting, 1, kBlocksOfEach * threads);
  return std::min(height, kZipRows * int(blocks));
}

}  // namespace detail

void use_exr_threads(int threads) {
  Imf::setGlobalThreadCount(threads > 0 ? threads : int(std::thread::hardware_concurrency()));
}

}  // namespace pvol::formats
