// make_fuzz_corpus FOLDER: writes the binary files of the corpus anew.
#include "make_corpus/make_corpus.h"

#include <exception>
#include <iostream>

int main(int count, char** arguments) try {
  if (count != 2) throw std::runtime_error("usage: make_fuzz_corpus tests/fuzz/corpus");
  const std::filesystem::path folder = arguments[1];
  for (const char* kind : {"exr", "nvdb", "pvol", "vdb"}) {
    std::filesystem::create_directories(folder / kind);
  }
  pvol::fuzz::make_exr_corpus(folder / "exr");
  pvol::fuzz::make_nvdb_corpus(folder / "nvdb");
  pvol::fuzz::make_pvol_corpus(folder / "pvol");
  pvol::fuzz::make_vdb_corpus(folder / "vdb");
  return 0;
} catch (const std::exception& e) {
  std::cerr << e.what() << '\n';
  return 1;
}
