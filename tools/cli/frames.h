// Numbers of frames, and names of files that have one in them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace pvol::cli {

/// As many as a list may name.
inline constexpr std::size_t kMostFrames = 100'000;

/// Frames as people write them: "17", "1-240", every tenth "1-240x10", from a negative one "-5-10",
/// or several of these with commas. They stay in this order, each once, so that "1-240x10,1-240"
/// begins with every tenth. Throws UsageError, "found ..., expected ...".
[[nodiscard]] std::vector<int> parse_frames(const std::string& text);

/// Whether a file's name has a place for the number of a frame: the last run of '#', or "%04d",
/// "%d", or Houdini's "$F4" or "$F", where one of those comes later. Names of folders have none.
[[nodiscard]] bool has_pattern(const std::filesystem::path& file);

/// The name with the number in that place, which has as many characters as there are '#', or more
/// for a longer number: "####" makes 0017, -005 and 12345, as printf does of "%04d". A name without
/// a pattern stays as it is.
[[nodiscard]] std::filesystem::path file_of_frame(const std::filesystem::path& file, int frame);

/// The same name with a pattern in place of a number of three digits or more at its end, or of one
/// that pads with blanks, else before its ending: "a.0017.exr" -> "a.####.exr", "a.%4d.exr" ->
/// "a.%04d.exr", "cloud.exr" -> "cloud.####.exr".
[[nodiscard]] std::filesystem::path with_pattern(const std::filesystem::path& file);

}  // namespace pvol::cli
