// What headers of pictures say of them, and how pictures are laid out.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/filter_picture.h"
#include "cli/json.h"
#include "pvol/formats/image.h"
#include "pvol/math/value.h"
#include "pvol/render/options.h"

namespace pvol::cli {

/// A value of an option, for reports and as headers have it.
[[nodiscard]] Json to_json(const Value& value);
[[nodiscard]] std::string attribute_text(const Value& value);

/// What a header says under a name; empty where it says nothing.
[[nodiscard]] std::string attribute(const std::map<std::string, std::string>& all,
                                    const std::string& name);

/// The first line in which two scenes of headers differ, in each of them, but for those that begin
/// with one of some keys; empty where none does.
[[nodiscard]] std::array<std::string, 2> first_difference(
    const std::string& a, const std::string& b, const std::vector<std::string_view>& keys);

/// "samples 16:32", or nothing where all are rendered.
[[nodiscard]] std::string part_text(const RenderOptions& o);

/// "1200 of 4000": samples of those wanted, where that number is not 0.
[[nodiscard]] std::string progress_text(std::uint64_t samples, std::uint64_t wanted);

/// "noise 2.1 % (1.3 % of the mean)", by `pixel_noise` and `relative_noise`.
[[nodiscard]] std::string noise_text(const Film& film);

/// Adds what follows from a film's samples: how many there are, and its noise; of a filtered
/// picture its error.
void describe_film(const Film& film, std::uint64_t samples, std::uint64_t wanted,
                   const std::optional<FilteredPicture>& filtered,
                   std::map<std::string, std::string>& attributes);

/// What the filter says of its picture.
void describe_error(const FilteredPicture& filtered,
                    std::map<std::string, std::string>& attributes);

/// Says "on" in headers of parts that make a picture to be filtered, when they are a whole.
inline constexpr const char* kWishForFilter = "pvol:denoise_whole";

/// Whether a part's header has that wish, or its picture was filtered by itself.
[[nodiscard]] bool wants_filter(const std::map<std::string, std::string>& attributes);

/// Says in a header that came from a part whether the whole is filtered.
void describe_filter(bool filtered, std::map<std::string, std::string>& attributes);

/// How a picture is written that a scene says.
struct PictureLayout {
  bool filtered = false;  ///< it has the layers of a filtered picture
  bool multipart = false;
  formats::PixelType pixels = formats::PixelType::single;
  formats::ExrCompression compression = formats::ExrCompression::zip;
};
[[nodiscard]] formats::ExrOptions exr_options(const PictureLayout& layout, const Scene& scene);

}  // namespace pvol::cli
