// Parts of pictures, as pvol-convert merge joins them: a damaged one is refused and leaves nothing,
// or alone it makes a picture that can be read.
#include <iostream>

#include "cli/merge.h"
#include "fuzz.h"
#include "pvol/formats/film_file.h"

namespace {

using namespace pvol::fuzz;

/// What merging reports goes nowhere.
class Silence {
 public:
  Silence() : to_(std::cout.rdbuf(nullptr)), also_(std::cerr.rdbuf(nullptr)) {}
  ~Silence() { std::cout.rdbuf(to_), std::cerr.rdbuf(also_); }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  std::streambuf *to_, *also_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Silence silence;
  const std::filesystem::path part = scratch_file("part.exr", {data, size});
  const std::filesystem::path whole = part.parent_path() / "whole.exr";
  std::filesystem::remove(whole);
  pvol::cli::MergeGiven given;
  given.common.quiet = true;
  given.parts = {part};
  given.output.exr = whole;
  given.output.no_png = true;
  given.partial = true;
  if (!accepts([&] { (void)pvol::cli::merge(given); })) {
    require(!std::filesystem::exists(whole), "a refused part leaves a picture");
    return 0;
  }
  (void)pvol::formats::read_film_file(whole);
  return 0;
}
