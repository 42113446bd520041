// The part of an EXR that keeps a film's exact sums.
#pragma once

#include <ImfHeader.h>
#include <ImfOutputPart.h>

#include "image/sum_planes.h"
#include "pvol/formats/film_record.h"

namespace pvol::formats::detail {

/// Names of parts: of sums, of a picture all in one, and of the first of one in several.
inline constexpr const char* kSumsPart = "sums";
inline constexpr const char* kPicturePart = "picture";
inline constexpr const char* kColourPart = "rgba";

/// Its header: the film's windows, a channel for each plane, and the record as text.
[[nodiscard]] Imf::Header make_sums_header(const Film& film, const FilmRecord& record);

/// Writes the planes of all pixels.
void write_sums(Imf::OutputPart& out, const Film& film, const FilmRecord& record);

/// What such a header says: the record, and a film without pixels but with windows, first sample,
/// layers and, where it has needs, theirs without shares.
struct SumsHeader {
  FilmRecord record;
  Film window;
  PlaneChoice choice;
};

/// Throws Error where the header is damaged, or of a later version.
[[nodiscard]] SumsHeader read_sums_header(const Imf::Header& header);

}  // namespace pvol::formats::detail
