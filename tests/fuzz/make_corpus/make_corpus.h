// The binary files of the corpus: small, and each with something that the others do not have. Each
// function writes into a folder that exists.
#pragma once

#include <filesystem>

namespace pvol::fuzz {

void make_exr_corpus(const std::filesystem::path& folder);
void make_nvdb_corpus(const std::filesystem::path& folder);
void make_pvol_corpus(const std::filesystem::path& folder);
void make_vdb_corpus(const std::filesystem::path& folder);

}  // namespace pvol::fuzz
