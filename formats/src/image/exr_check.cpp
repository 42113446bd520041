#include "image/exr_check.h"

#include <fmt/format.h>

#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfHeader.h>
#include <ImfStandardAttributes.h>

#include <cmath>
#include <cstdint>

#include "pvol/error.h"

namespace pvol::formats::detail {
namespace {

constexpr std::int64_t kMostPixels = std::int64_t{1} << 28;
constexpr std::int64_t kLargestEdge = std::int64_t{1} << 16;  // longer ones are damaged headers
constexpr float kPrimaryTolerance = 0.002f;  // chromaticities are published with 2 to 4 digits

std::string names_of(const Imf::ChannelList& channels) {
  std::string names;
  for (auto c = channels.begin(); c != channels.end(); ++c) {
    names += (names.empty() ? "" : ", ") + std::string(c.name());
  }
  return names.empty() ? "none" : names;
}

bool close(const Imath::V2f& a, const Imath::V2f& b) {
  return std::abs(a.x - b.x) <= kPrimaryTolerance && std::abs(a.y - b.y) <= kPrimaryTolerance;
}

}  // namespace

void check_picture(const Imf::InputFile& in) {
  for (const char* name : {"R", "G", "B"}) {
    if (!in.header().channels().findChannel(name)) {
      throw Error(std::string("has no channel ") + name + "; expected R, G and B, found " +
                  names_of(in.header().channels()));
    }
  }
  const Imath::Box2i& box = in.header().dataWindow();
  const std::int64_t width = std::int64_t(box.max.x) - box.min.x + 1;
  const std::int64_t height = std::int64_t(box.max.y) - box.min.y + 1;
  if (width < 1 || height < 1 || width > kLargestEdge || height > kLargestEdge ||
      width * height > kMostPixels) {
    throw Error(fmt::format(
        "has {} x {} pixels; expected 1 to 2^16 along each edge and at most 2^28 in all", width,
        height));
  }
  if (Imf::hasChromaticities(in.header())) {
    const Imf::Chromaticities found = Imf::chromaticities(in.header()), rec709;
    if (!close(found.red, rec709.red) || !close(found.green, rec709.green) ||
        !close(found.blue, rec709.blue) || !close(found.white, rec709.white)) {
      throw Error("has primaries other than linear Rec.709; convert it first");
    }
  }
  if (!in.isComplete()) throw Error("is incomplete: pixels are missing; copy or write it again");
}

}  // namespace pvol::formats::detail
