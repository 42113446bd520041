// What EXR files have in common that are written here.
#pragma once

#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfPixelType.h>

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "pvol/render/camera.h"
#include "pvol/render/film.h"

namespace pvol::formats::detail {

/// A header with the film's windows, the chromaticities of its colours and, of a camera,
/// worldToCamera and worldToNDC. Channels and compression are the caller's.
[[nodiscard]] Imf::Header make_header(const Film& film, const std::optional<Camera>& camera);

/// Adds attributes of type string. Throws Error for names of EXR's own.
void add_attributes(const std::map<std::string, std::string>& attributes, Imf::Header& header);

[[nodiscard]] inline std::size_t bytes_of(Imf::PixelType type) { return type == Imf::HALF ? 2 : 4; }

/// Puts a value into `to` as float or half; whether half cannot hold it, and it was clamped.
bool store(double value, Imf::PixelType type, char* to);

/// Calls write(stream) for a file that appears when it is whole. Throws Error, which names the
/// file, for a film without pixels, where writing fails and for what `write` throws.
void write_exr_file(const std::filesystem::path& file, const Film& film,
                    const std::function<void(Imf::OStream&)>& write);

}  // namespace pvol::formats::detail
