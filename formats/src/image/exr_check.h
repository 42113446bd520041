// What pictures in EXR files have in common, whatever they are read for.
#pragma once

#include <ImfHeader.h>

#include <filesystem>
#include <map>
#include <string>

#include "image/exr_header.h"
#include "pvol/render/film.h"

namespace pvol::formats::detail {

/// To be called before OpenEXR opens the file. Throws Error where its headers are damaged, its
/// pixels have several samples each, or a part is too large: of more than 2^28 pixels or with an
/// edge above 2^16; of more than 2^24 pixels that take more than a thousand times the file; of more
/// blocks than the file has room for; or of blocks that take more than 256 MiB and more than a
/// thousand times the file, so that a small file takes little memory; or where a block's pixels do
/// not belong to the header. Parts that a film is read from count together. Returns their number.
std::size_t check_exr_file(const std::filesystem::path& file);

/// The same of a deep picture's only part, as far as it can be told without its blocks.
void check_deep_part(const std::filesystem::path& file, ExrPart part, std::uint64_t file_bytes);

/// A film with the windows and the colour space of a file, and without pixels. Throws Error where
/// they make no sense.
[[nodiscard]] Film film_of(const Imf::Header& header);

/// All attributes of type string.
[[nodiscard]] std::map<std::string, std::string> string_attributes(const Imf::Header& header);

/// Throws Error for what cannot be used as a picture, before any pixel is read: without R, G and B,
/// or with channels of fewer samples.
void check_picture(const Imf::Header& header);

/// Throws Error unless all pixels are there.
void check_complete(bool complete);

}  // namespace pvol::formats::detail
