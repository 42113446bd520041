#include "file/grid_choice.h"

#include <fmt/format.h>

#include <algorithm>

#include "pvol/error.h"

namespace pvol::formats::detail {

namespace {

constexpr std::size_t kLongestText = 80, kLongestList = 12;

using Indices = std::vector<std::size_t>;

template <class Fits>
Indices which(const std::vector<GridChoice>& grids, Fits fits) {
  Indices found;
  for (std::size_t i = 0; i < grids.size(); ++i) {
    if (fits(grids[i])) found.push_back(i);
  }
  return found;
}

// The grids called `name`: the one with that unique name, else all that share it.
Indices named(const std::vector<GridChoice>& grids, const std::string& name) {
  const Indices unique = which(grids, [&](const GridChoice& g) { return g.name == name; });
  if (!unique.empty()) return unique;
  return which(grids, [&](const GridChoice& g) { return g.base == name; });
}

std::size_t first_of(const std::vector<GridChoice>& grids, const Indices& same,
                     std::vector<std::string>& warnings) {
  const auto usable = std::find_if(same.begin(), same.end(),
                                   [&](std::size_t i) { return grids[i].refusal.empty(); });
  const std::size_t taken = usable == same.end() ? same.front() : *usable;
  if (same.size() > 1) {
    warnings.push_back(fmt::format("{} grids are called '{}'; '{}' is read", same.size(),
                                   printable(grids[taken].base), printable(grids[taken].name)));
  }
  return taken;
}

}  // namespace

std::string printable(const std::string& text) {
  std::size_t length = std::min(text.size(), kLongestText);
  // Cut between characters of UTF-8: bytes 10xxxxxx continue one.
  while (length > 0 && length < text.size() && (text[length] & 0xc0) == 0x80) --length;
  std::string shown = text.substr(0, length);
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return (c >= 0 && c < ' ') || c == 127; }, '?');
  return shown.size() < text.size() ? shown + "..." : shown;
}

std::string list_grids(const std::vector<GridChoice>& grids) {
  std::string text;
  for (std::size_t i = 0; i < grids.size() && i < kLongestList; ++i) {
    text += (i ? ", " : "") + printable(grids[i].name) + " (" + printable(grids[i].type) + ")";
  }
  if (grids.size() > kLongestList) {
    text += fmt::format(" and {} more", grids.size() - kLongestList);
  }
  return text;
}

std::vector<GridEntry> entries_of(const std::vector<GridChoice>& grids) {
  std::vector<GridEntry> all;
  for (const GridChoice& g : grids) all.push_back({g.name, g.type, g.refusal.empty()});
  return all;
}

std::size_t choose_grid(const std::filesystem::path& file, const std::vector<GridChoice>& grids,
                        const std::string& wanted, std::vector<std::string>& warnings) {
  const std::string where = file.string() + ": ";
  const std::string there = "; the file has: " + list_grids(grids);
  if (grids.empty()) throw Error(where + "the file holds no grids");

  const Indices same = named(grids, wanted.empty() ? "density" : wanted);
  if (!same.empty()) {
    const std::size_t taken = first_of(grids, same, warnings);
    if (grids[taken].refusal.empty()) return taken;
    throw Error(where + "grid '" + printable(grids[taken].name) +
                "' cannot be rendered: " + grids[taken].refusal + there);
  }
  if (!wanted.empty()) throw Error(where + "no grid is called '" + printable(wanted) + "'" + there);

  const Indices usable = which(grids, [](const GridChoice& g) { return g.refusal.empty(); });
  if (usable.size() == 1) return usable.front();
  if (usable.size() > 1) {
    throw Error(
        where +
        "no grid is called 'density', and several hold densities; choose one with --grid NAME" +
        there);
  }
  if (grids.size() == 1) {
    throw Error(where + "grid '" + printable(grids[0].name) +
                "' cannot be rendered: " + grids[0].refusal + there);
  }
  throw Error(where + "no grid holds a density" + there);
}

void warn_of_others(const std::vector<GridChoice>& grids, const GridOptions& options,
                    GridReport& report) {
  if (report.largest > 0 || !options.grid.empty() || grids.size() < 2) return;
  report.warnings.push_back("choose another grid with --grid NAME; the file has: " +
                            list_grids(grids));
}

}  // namespace pvol::formats::detail
