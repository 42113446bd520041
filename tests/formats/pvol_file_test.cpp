#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <random>
#include <sstream>

#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/pvol_file.h"
#include "support/effort.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/pvol_bytes.h"
#include "support/pvol_content.h"
#include "support/random_pyramid.h"

namespace pvol::formats {
namespace pvol_file_test {

namespace fs = std::filesystem;
using test::error_of;
using test::expect_equal_samples;
using test::PvolBytes;
using test::PvolFileTest;
using test::some_file;
using test::some_metadata;
using test::tiny_file;

void expect_equal(const Metadata& a, const Metadata& b) {
  EXPECT_EQ(a.grid_name, b.grid_name);
  EXPECT_EQ(std::memcmp(&a.index_to_world, &b.index_to_world, sizeof(Affine)), 0);
  EXPECT_EQ(a.source.file, b.source.file);
  EXPECT_EQ(a.source.grid, b.source.grid);
  EXPECT_EQ(a.source.bytes, b.source.bytes);
  EXPECT_EQ(a.source.hash, b.source.hash);
  EXPECT_EQ(a.unit, b.unit);
  EXPECT_EQ(a.options, b.options);
  EXPECT_EQ(a.written_by, b.written_by);
}

TEST_F(PvolFileTest, RoundTripKeepsEverything) {
  for (const Compression compression : {Compression::none, Compression::zstd}) {
    const PvolFile content = some_file();
    const PvolSizes sizes = write_pvol(path("a.pvol"), content, compression);
    EXPECT_EQ(sizes.total, fs::file_size(path("a.pvol")));
    const PvolFile back = read_pvol(path("a.pvol"));
    expect_equal(back.metadata, content.metadata);
    EXPECT_EQ(back.pyramid, content.pyramid);
    EXPECT_EQ(back.shell, content.shell);
    ASSERT_TRUE(back.density);
    EXPECT_EQ(back.density->name, content.metadata.grid_name);
    EXPECT_EQ(back.density->index_to_world, content.metadata.index_to_world);
    expect_equal_samples(*back.density, *content.density);
    EXPECT_EQ(back.density->tiles.size(), 2u);  // the one of zeros is left out
  }
}

TEST_F(PvolFileTest, WithoutAGridACloudIsEmptyAndKnowsItsFile) {
  const Cloud cloud = load_cloud("smoke.vdb", {.grid = kNoGrid});
  EXPECT_EQ(cloud.report.type, "none");
  EXPECT_EQ(cloud.metadata.source.file, "smoke.vdb");
}

/// Samples that are exact and not compressed are used where they lie: they are there though the
/// name is gone, and when the memory of their pages was given back.
TEST_F(PvolFileTest, PlainSamplesStayInTheMappedFile) {
  const PvolFile content = some_file();
  for (const Compression compression : {Compression::none, Compression::zstd}) {
    write_pvol(path("a.pvol"), content, compression);
    const PvolFile whole = read_pvol(path("a.pvol")), grid = read_pvol_grid(path("a.pvol"), "");
    EXPECT_EQ(whole.forget_pages != nullptr, compression == Compression::none);
    fs::remove(path("a.pvol"));
    for (const PvolFile& back : {whole, grid}) {
      if (back.forget_pages) back.forget_pages();
      expect_equal_samples(*back.density, *content.density);
    }
  }
  // Bytes of the caller's are copied.
  write_pvol(path("a.pvol"), content, Compression::none);
  std::ostringstream text;
  text << std::ifstream(path("a.pvol"), std::ios::binary).rdbuf();
  std::string bytes = text.str();
  const PvolFile copied = read_pvol(std::as_bytes(std::span(bytes)), "a");
  std::fill(bytes.begin(), bytes.end(), '\0');
  EXPECT_EQ(copied.forget_pages, nullptr);
  expect_equal_samples(*copied.density, *content.density);
}

TEST_F(PvolFileTest, DensityOfManyFramesRoundTrips) {
  const PvolFile content = some_file(1500, false);
  write_pvol(path("a.pvol"), content);
  expect_equal_samples(*read_pvol(path("a.pvol")).density, *content.density);
  EXPECT_LT(measure_pvol(path("a.pvol")).density, 1500 * sizeof(float) * kBrickSamples);
}

/// Of the frames that are decoded beside each other one cannot be.
TEST_F(PvolFileTest, OneDamagedFrameOfManyIsRefused) {
  PvolBytes file(written(some_file(1500, false), Compression::zstd));
  const auto density = std::find_if(file.chunks.begin(), file.chunks.end(),
                                    [](auto& c) { return c.entry.id == detail::kDensity; });
  ASSERT_NE(density, file.chunks.end());
  std::vector<std::byte>& stored = density->stored;
  // Of the second frame's first block, which follows 4 bytes of magic, a descriptor, one of the
  // window and 4 of the size (RFC 8878, 3.1.1), the bytes that tell how the rest is to be read.
  const std::size_t second = ZSTD_findFrameCompressedSize(stored.data(), stored.size());
  ASSERT_EQ(stored[second + 4] & std::byte{0xe3}, std::byte{0x80});
  std::fill_n(stored.begin() + std::ptrdiff_t(second) + 13, 8, std::byte{0xff});
  const std::string error = error_of([&] { (void)read_pvol(file.bytes(), "a"); });
  EXPECT_NE(error.find("DENS"), std::string::npos) << error;
  EXPECT_NE(error.find("the compressed data"), std::string::npos) << error;
}

/// Where the support begins within the first block, that lies in the corner of the root.
TEST_F(PvolFileTest, ABlockInTheCornerOfTheRootRoundTrips) {
  auto values = std::make_shared<std::vector<float>>(std::size_t(kBrickSamples));
  values->back() = 0.75f;
  VoxelGrid g;
  g.bricks.push_back({{0, 8, -8}, values->data()});
  g.owner = values;
  const Pyramid p = build_pyramid(g);
  ASSERT_EQ(p.origin, Vec3l(0, 8, -8));
  PvolFile content{{}, p, g, std::nullopt};
  test::expect_equal_samples(*read_pvol(written(content), "a").density, g);
}

TEST_F(PvolFileTest, PyramidsOfEveryDepthRoundTrip) {
  std::size_t turn = 0;
  for (std::size_t levels = 1; levels <= 22; ++levels) {
    ++turn;
    for (const int uniform : {0, 1, 20}) {
      ++turn;
      for (const float scale : {1e-44f, 0.3f, 3e38f}) {
        if (!proof::has_turn(turn++, 3)) continue;
        const test::PyramidSpec spec{levels, 30, uniform, scale, Vec3l(-1048576, 8, 0)};
        PvolFile content{some_metadata(), test::random_pyramid(spec, levels), {}, {}};
        const auto bytes = written(content);
        ASSERT_EQ(read_pvol(bytes, "a").pyramid, content.pyramid) << levels << " " << uniform;
      }
    }
  }
}

TEST_F(PvolFileTest, UniformRootsOfEverySizeRoundTrip) {
  for (std::size_t levels = 1; levels <= 22; ++levels) {
    Pyramid p;
    p.scale = 2;
    p.levels.resize(levels);
    p.levels.back() = {{0, 2, 2}};
    p.support_hi = Vec3l(std::int64_t(4) << levels);
    ASSERT_EQ(read_pvol(written({{}, p, {}, {}}), "a").pyramid, p) << levels;
  }
}

TEST_F(PvolFileTest, EmptyCloudRoundTrips) {
  const PvolFile empty{{}, {}, VoxelGrid{}, {}};
  const PvolFile back = read_pvol(written(empty), "a");
  EXPECT_TRUE(back.pyramid.empty());
  ASSERT_TRUE(back.density);
  EXPECT_TRUE(back.density->bricks.empty());
}

/// A file with two more grids, one of them in few bits.
PvolFile with_fields() {
  PvolFile file = test::compact_file();
  PvolFile flames = test::compact_file(), temperature = test::compact_file();
  flames.metadata.grid_name = "flames";
  flames.metadata.index_to_world = scaling(Vec3d(0.25));
  temperature = test::with_codes(test::compact_file(), {Precision::fpn, 0.1});
  temperature.metadata.grid_name = "temperature";
  file.fields = {flames, temperature};
  return file;
}

TEST_F(PvolFileTest, FieldsRoundTripAndAreReadAlone) {
  const PvolFile file = with_fields();
  const PvolSizes sizes = write_pvol(path("a.pvol"), file);
  EXPECT_GT(sizes.fields, 0u);
  const PvolFile all = read_pvol(path("a.pvol"));
  ASSERT_EQ(all.fields.size(), 2u);
  EXPECT_EQ(all.fields[0].metadata.grid_name, "flames");
  EXPECT_EQ(all.fields[0].metadata.index_to_world, scaling(Vec3d(0.25)));
  EXPECT_EQ(all.fields[0].pyramid, file.fields[0].pyramid);
  EXPECT_EQ(all.fields[1].metadata.quantisation.precision, Precision::fpn);
  for (const char* name : {"flames", "temperature"}) {
    const PvolFile one = read_pvol_grid(path("a.pvol"), name);
    EXPECT_EQ(one.metadata.grid_name, name);
    EXPECT_TRUE(one.fields.empty());
    EXPECT_EQ(one.density->name, name);
  }
  const PvolFile density = read_pvol_grid(path("a.pvol"), "");
  EXPECT_EQ(density.metadata.grid_name, file.metadata.grid_name);
  EXPECT_EQ(density.pyramid, file.pyramid);
  const auto names = list_pvol(path("a.pvol"));
  ASSERT_EQ(names.size(), 3u);
  EXPECT_EQ(names[2].name, "temperature");
  EXPECT_FALSE(names[2].empty);
  EXPECT_TRUE(says(test::error_of([&] { (void)read_pvol_grid(path("a.pvol"), "heat"); }),
                   "pvol_file.flames_temperature_not_heat"));
}

TEST_F(PvolFileTest, FilesWithFieldsSuitOldReaders) {
  const PvolBytes bytes(written(with_fields()));
  EXPECT_EQ(bytes.header.version, 3u);
  EXPECT_EQ(bytes.header.reader_version, 1u) << "which skip what begins in lower case";
}

TEST_F(PvolFileTest, FieldsThatCannotBeAreRefused) {
  PvolFile twice = with_fields();
  twice.fields[1].metadata.grid_name = "flames";
  EXPECT_NE(test::error_of([&] { write_pvol(path("a.pvol"), twice); }).find("'flames'"),
            std::string::npos);
  PvolFile nested = with_fields();
  nested.fields[0].fields = {nested.fields[1]};
  EXPECT_TRUE(says(test::error_of([&] { write_pvol(path("a.pvol"), nested); }),
                   "pvol_file.field_fields_itself"));
  // Forged: a field within a field, two of one name, one that is damaged within.
  const auto refusal = [&](const PvolBytes& bytes) {
    return test::error_of([&] { (void)read_pvol(bytes.bytes(), "a.pvol"); });
  };
  const auto is_field = [](const auto& c) { return c.entry.id == detail::kField; };
  const PvolBytes good(written(with_fields(), Compression::none));
  EXPECT_EQ(refusal(good), "");
  PvolBytes same = good;
  auto first = std::find_if(same.chunks.begin(), same.chunks.end(), is_field);
  *(first + 1) = *first;
  EXPECT_TRUE(says(refusal(same), "pvol_file.field_byte_second"));
  PvolBytes deep = good;
  first = std::find_if(deep.chunks.begin(), deep.chunks.end(), is_field);
  first->stored = good.bytes();
  first->entry.raw_bytes = first->stored.size();
  EXPECT_TRUE(says(refusal(deep), "pvol_file.field_byte_field"));
  PvolBytes damaged = good;
  first = std::find_if(damaged.chunks.begin(), damaged.chunks.end(), is_field);
  first->stored[first->stored.size() / 2] ^= std::byte{1};
  EXPECT_NE(refusal(damaged).find("checksum"), std::string::npos);
  EXPECT_TRUE(says(refusal(damaged), "pvol_file.field_byte_chunk"));
}

TEST_F(PvolFileTest, SizesAreThoseOfTheParts) {
  const PvolSizes a = write_pvol(path("a.pvol"), some_file());
  const PvolSizes b = measure_pvol(path("a.pvol"));
  EXPECT_EQ(a.header, 40u + 4 * 40u);
  EXPECT_EQ(a.header, b.header);
  EXPECT_EQ(a.metadata, b.metadata);
  EXPECT_EQ(a.bounds, b.bounds);
  EXPECT_EQ(a.shell, 48u + 40 + 2 * 44);
  EXPECT_EQ(a.shell, b.shell);
  EXPECT_EQ(a.density, b.density);
  EXPECT_EQ(a.total, b.total);
  const std::uint64_t parts = a.header + a.metadata + a.bounds + a.shell + a.density;
  EXPECT_LE(parts, a.total);
  EXPECT_GT(parts + 4 * 64, a.total);
}

TEST_F(PvolFileTest, TheSameContentGivesTheSameBytes) {
  PvolFile a = some_file();
  PvolFile b = some_file();
  std::reverse(b.density->bricks.begin(), b.density->bricks.end());
  std::reverse(b.density->tiles.begin(), b.density->tiles.end());
  std::vector<float> minus_zeros(b.density->bricks[0].values,
                                 b.density->bricks[0].values + kBrickSamples);
  for (float& v : minus_zeros) v = v == 0 ? -0.0f : v;
  b.density->bricks[0].values = minus_zeros.data();
  EXPECT_EQ(written(a), written(b));
}

TEST_F(PvolFileTest, HashIsXxh3OfTheWholeFile) {
  test::save(path("empty"), {});
  EXPECT_EQ(hash_file(path("empty")).hash, 0x2d06800538d394c2u);  // the empty string's
  const std::vector<std::byte> bytes(3'000'001, std::byte{7});
  test::save(path("large"), bytes);
  EXPECT_EQ(hash_file(path("large")).bytes, bytes.size());
  EXPECT_EQ(hash_file(path("large")).hash, test::xxh3(bytes));
  EXPECT_NE(error_of([&] { (void)hash_file(path("absent")); }).find("absent"), std::string::npos);
  EXPECT_TRUE(
      says(error_of([&] { (void)hash_file(folder_); }), "pvol_file.hashisxxh3ofthewholefile_not"));
}

TEST_F(PvolFileTest, TheHeadTellsWhatAFileHolds) {
  const auto head_of = [&](const std::vector<std::byte>& file) {
    test::save(path("b.pvol"), file);
    return read_pvol_head(path("b.pvol"));
  };
  const std::vector<std::byte> bytes = written(some_file(), Compression::none);
  const std::string head = head_of(bytes);
  const PvolBytes good(bytes);
  EXPECT_EQ(head.size(), 40 + 40 * good.chunks.size());
  for (std::size_t chunk = 0; chunk < good.chunks.size(); ++chunk) {
    PvolBytes other = good;
    other.chunks[chunk].stored.back() ^= std::byte{1};
    EXPECT_NE(head_of(other.bytes()), head) << "chunk " << chunk;
  }
  std::vector<std::byte> damaged = bytes;
  damaged[60] ^= std::byte{1};
  EXPECT_NE(error_of([&] { (void)head_of(damaged); }).find("checksum"), std::string::npos);
}

const char* const kGoldenTinyFile =
    "\n8950564c0d0a1a0a010000000100000005020000000000000200000000000000"
    "\n3acb1ce902634e344d4554410000000080000000000000000401000000000000"
    "\n040100000000000092084998e8e4c41e424e445300000000c001000000000000"
    "\n45000000000000004500000000000000a9e97f1fdd2140960000000000000000"
    "\n7b2267726964223a2264656e73697479222c22696e6465785f746f5f776f726c"
    "\n64223a5b5b312e302c302e302c302e302c302e305d2c5b302e302c312e302c30"
    "\n2e302c302e305d2c5b302e302c302e302c312e302c302e305d5d2c22696e7465"
    "\n72706f6c6174696f6e223a5b226e656172657374222c227472696c696e656172"
    "\n225d2c226f7074696f6e73223a7b7d2c22736f75726365223a7b226279746573"
    "\n223a313233342c2266696c65223a22612e766462222c2267726964223a226465"
    "\n6e73697479222c22787868335f3634223a226665646362613938373635343332"
    "\n3130227d2c22756e6974223a22222c227772697474656e5f6279223a22746573"
    "\n74227d0a00000000000000000000000000000000000000000000000000000000"
    "\n0000000000000000000000000000000000000000000000000000000000000000"
    "\n0000000008000000f8ffffff060000000e000000feffffff0800000010000000"
    "\n000000000000403f010000000000000001000000010000000100000000000000"
    "\n000000f800";

// Any change of these bytes is a change of the format, which needs a new version number.
TEST_F(PvolFileTest, GoldenBytes) {
  const std::vector<std::byte> bytes = written(tiny_file(), Compression::none);
  EXPECT_EQ(test::hex(bytes), kGoldenTinyFile);
  expect_equal(read_pvol(bytes, "a").metadata, tiny_file().metadata);
}

TEST_F(PvolFileTest, WrongContentIsNotWritten) {
  const auto error = [&](const std::function<void(PvolFile&)>& damage) {
    PvolFile content = some_file();
    damage(content);
    const std::string message = error_of([&] { write_pvol(path("a.pvol"), content); });
    EXPECT_TRUE(files().empty());
    return message;
  };
  EXPECT_NE(error([](PvolFile& f) { f.metadata.index_to_world.m[0] = {}; }).find("inverse"),
            std::string::npos);
  EXPECT_NE(error([](PvolFile& f) { f.metadata.unit = std::string(1, '\xff'); }).find("UTF-8"),
            std::string::npos);
  EXPECT_NE(error([](PvolFile& f) { f.metadata.unit.resize(2 << 20, 'm'); }).find("1048576"),
            std::string::npos);
  EXPECT_NE(error([](PvolFile& f) { f.pyramid.levels[0].pop_back(); }).find("bounds"),
            std::string::npos);
  EXPECT_NE(error([](PvolFile& f) { f.shell->certificate.bound = 0; }).find("certificate"),
            std::string::npos);
  for (const char* what : {"lo", "hi"}) {
    const auto move = [&](PvolFile& f) { ++(what[0] == 'l' ? f.shell->lo : f.shell->hi).x; };
    EXPECT_TRUE(says(error(move), "pvol_file.shell_write_belongs")) << what;
  }
  EXPECT_NE(error([](PvolFile& f) { f.density->bricks[0].origin.x = 1; }).find("aligned"),
            std::string::npos);
  EXPECT_TRUE(says(error([](PvolFile& f) { f.density->bricks.push_back(f.density->bricks[0]); }),
                   "pvol_file.bricks_out_of_order"));
}

TEST_F(PvolFileTest, FailureMidwayLeavesTheOldFile) {
  write_pvol(path("a.pvol"), tiny_file());
  const auto old = test::load(path("a.pvol"));

  PvolFile bad = some_file();
  std::vector<float> samples(kBrickSamples, 1.0f);
  samples.back() = std::nanf("");
  bad.density->bricks.front().values = samples.data();
  EXPECT_THROW(write_pvol(path("a.pvol"), bad), Error);

  // A full disk, as far as a test can have one.
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit small{4096, limit.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string error = error_of([&] { write_pvol(path("a.pvol"), some_file(100)); });
  setrlimit(RLIMIT_FSIZE, &limit);
  EXPECT_NE(error.find("space"), std::string::npos) << error;

  EXPECT_EQ(test::load(path("a.pvol")), old);
  EXPECT_EQ(files(), std::vector<std::string>{"a.pvol"});
}

TEST_F(PvolFileTest, OutputsThatCannotBeFilesAreRefused) {
  EXPECT_THROW(write_pvol(path("absent/a.pvol"), tiny_file()), Error);
  EXPECT_THROW(write_pvol(folder_, tiny_file()), Error);
  EXPECT_THROW(write_pvol("/dev/null", tiny_file()), Error);
  EXPECT_FALSE(fs::is_regular_file("/dev/null"));
  EXPECT_THROW((void)read_pvol(path("absent.pvol")), Error);
  EXPECT_THROW((void)read_pvol(folder_), Error);
  EXPECT_THROW((void)read_pvol("/dev/null"), Error);
}

TEST_F(PvolFileTest, LinksAreFollowed) {
  write_pvol(path("a.pvol"), tiny_file());
  fs::create_symlink("a.pvol", path("link.pvol"));
  write_pvol(path("link.pvol"), some_file());
  EXPECT_TRUE(fs::is_symlink(path("link.pvol")));
  EXPECT_EQ(read_pvol(path("a.pvol")).pyramid, some_file().pyramid);
}

/// As to a scratch disk.
TEST_F(PvolFileTest, ALinkToNothingYetIsFollowed) {
  fs::create_directory(path("scratch"));
  fs::create_symlink("scratch/a.pvol", path("inner.pvol"));
  fs::create_symlink("inner.pvol", path("link.pvol"));
  write_pvol(path("link.pvol"), tiny_file());
  EXPECT_TRUE(fs::is_symlink(path("link.pvol")));
  EXPECT_EQ(read_pvol(path("scratch/a.pvol")).pyramid, tiny_file().pyramid);
  fs::create_symlink("loop.pvol", path("loop.pvol"));
  EXPECT_THROW(write_pvol(path("loop.pvol"), tiny_file()), Error);
}

TEST_F(PvolFileTest, TheLongestNamesAreWritten) {
  const std::string name = std::string(250, 'n') + ".pvol";
  for (int i = 0; i < 2; ++i) write_pvol(path(name), tiny_file());
  EXPECT_EQ(files().size(), 1u);
  EXPECT_EQ(read_pvol(path(name)).pyramid, tiny_file().pyramid);
}

TEST_F(PvolFileTest, AtomicWriterPassesOnWhatTheCallerThrows) {
  const auto fail = [](const fs::path& aside) {
    std::ofstream(aside) << "half";
    throw std::logic_error("mine");
  };
  EXPECT_THROW(write_atomically(path("a"), fail), std::logic_error);
  EXPECT_TRUE(files().empty());
  EXPECT_THROW(write_atomically(path("a"), [](const fs::path& aside) { fs::remove(aside); }),
               Error);
  EXPECT_TRUE(files().empty());
}

TEST_F(PvolFileTest, AReplacedFileKeepsItsModeAndItsGroup) {
  const auto write = [&] {
    write_atomically(path("a"), [](const fs::path& aside) { std::ofstream(aside) << "whole"; });
  };
  const auto info = [&] {
    struct stat found = {};
    EXPECT_EQ(stat(path("a").c_str(), &found), 0);
    return found;
  };
  write();
  const mode_t mask = umask(0);
  umask(mask);
  EXPECT_EQ(info().st_mode & 0777, 0666 & ~mask) << "of a new file";
  ASSERT_EQ(chmod(path("a").c_str(), 0640), 0);
  const bool may_give = chown(path("a").c_str(), uid_t(-1), 12345) == 0;  // as root
  write();
  EXPECT_EQ(info().st_mode & 0777, 0640u);
  if (may_give) {
    EXPECT_EQ(info().st_gid, 12345u);
  }
}

/// As by a thread that ends the process meanwhile.
TEST_F(PvolFileTest, AbandonedWritesLeaveNothing) {
  std::ofstream(path("a")) << "old";
  const auto abandoned = [&](const fs::path& aside) {
    write_atomically(path("b"), [](const fs::path& other) { std::ofstream(other) << "whole"; });
    std::ofstream(aside) << "half";
    abandon_writes();
    EXPECT_FALSE(fs::exists(aside));
  };
  EXPECT_THROW(write_atomically(path("a"), abandoned), Error);
  EXPECT_EQ(files().size(), 2u);
  EXPECT_EQ(fs::file_size(path("a")), 3u);
  EXPECT_EQ(fs::file_size(path("b")), 5u);
}

/// What a killed writer left is removed; what only looks like it stays.
TEST_F(PvolFileTest, OnlyLitterIsRemoved) {
  const std::vector<std::string> own{"a.tmp-backup", "a.tmp-1-2-3", "a.tmp-", "a.tmp-1-",
                                     "ab.tmp-1-2"};
  for (const std::string& name : own) std::ofstream(path(name)) << "mine";
  fs::create_directory(path("a.tmp-4-5"));
  std::ofstream(path("a.tmp-999999-7")) << "litter";
  write_atomically(path("a"), [](const fs::path& aside) { std::ofstream(aside) << "whole"; });
  for (const std::string& name : own) EXPECT_TRUE(fs::exists(path(name))) << name;
  EXPECT_TRUE(fs::exists(path("a.tmp-4-5")));
  EXPECT_FALSE(fs::exists(path("a.tmp-999999-7")));
}

bool has_children(const Pyramid& p, std::size_t level, std::uint64_t code) {
  if (level == 0) return false;
  return std::any_of(p.levels[level - 1].begin(), p.levels[level - 1].end(),
                     [&](const PyramidNode& n) { return n.code >> 3 == code; });
}

// What tests/formats/read_pvol.py prints of the parts of a file, from pvol's own reader.

std::string number(const char* format, double v) {
  char s[40];
  std::snprintf(s, sizeof s, format, v);
  return s;
}

std::string single(float v) { return number(" %.9g", double(v)); }

template <class T>
std::string at(const Vec3<T>& v) {
  std::ostringstream s;
  s.precision(9);
  s << ' ' << v.x << ' ' << v.y << ' ' << v.z;
  return s.str();
}

std::string text(const Quadric& q) {
  return at(Vec3f(q.square)) + at(Vec3f(q.mixed)) + at(Vec3f(q.linear)) + single(float(q.constant));
}

void print_chunks(std::ostream& out, const PvolBytes& bytes) {
  out << "version " << bytes.header.version << '\n';
  for (const PvolBytes::Chunk& c : bytes.chunks) {
    out << "chunk " << std::string(c.entry.id.begin(), c.entry.id.end()) << ' '
        << std::uint32_t(c.entry.codec) << ' ' << c.entry.offset << ' ' << c.entry.stored_bytes
        << ' ' << c.entry.raw_bytes << '\n';
  }
}

void print_metadata(std::ostream& out, const Metadata& m) {
  out << "grid " << m.grid_name << '\n';
  for (int r = 0; r < 3; ++r) {
    const Vec3d row = m.index_to_world.m[std::size_t(r)];
    out << "map";
    for (const double v : {row.x, row.y, row.z, m.index_to_world.t[r]}) {
      out << ' ' << number("%.17g", v);
    }
    out << '\n';
  }
  char hash[17];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(m.source.hash));
  out << "source " << m.source.file << ' ' << m.source.grid << ' ' << m.source.bytes << ' ' << hash
      << '\n';
}

void print_bounds(std::ostream& out, const Pyramid& p) {
  out << "origin" << at(p.origin) << "\nsupport" << at(p.support_lo) << at(p.support_hi)
      << "\nscale" << single(p.scale) << "\nlevels " << p.levels.size() << '\n';
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    for (const PyramidNode& n : p.levels[level]) {
      if (has_children(p, level, n.code)) continue;
      const Vec3l cell = p.origin + Vec3l(morton_decode(n.code)) * (std::int64_t(8) << level);
      out << "terminal " << level << at(cell) << single(n.lo) << single(n.hi) << '\n';
    }
  }
}

void print_micro_bounds(std::ostream& out, const Pyramid& p, const MicroBounds& micro) {
  for (std::size_t i = 0; i < p.levels[0].size(); ++i) {
    const auto [base, step] = micro.scales[i];
    out << "micro" << at(p.origin + Vec3l(morton_decode(p.levels[0][i].code)) * kLeafEdge);
    for (std::size_t c = 64 * i; c < 64 * (i + 1); ++c) {
      out << single(base + float(micro.codes[c].lo) * step)
          << single(base + float(micro.codes[c].hi) * step);
    }
    out << '\n';
  }
}

void print_shell(std::ostream& out, const Shell& shell) {
  const Certificate& c = shell.certificate;
  const ShellTightness& t = shell.tightness;
  out << "shell " << (shell.kind == ShellKind::soft ? "soft" : "hard") << number(" %.17g", c.bound)
      << ' ' << c.boxes << ' ' << c.depth << single(float(t.volume_ratio))
      << single(float(t.hit_ratio)) << single(float(t.box_volume_ratio))
      << single(float(t.box_hit_ratio)) << "\nbase" << text(shell.form.base) << '\n';
  for (const Perturbation& r : shell.form.perturbations) {
    out << "perturbation" << text(r.form.base) << single(float(r.strength)) << '\n';
  }
}

void print_density(std::ostream& out, const VoxelGrid& grid) {
  for (const Tile& t : grid.tiles) {
    out << "tile" << at(t.origin) << ' ' << t.edge << single(t.value) << '\n';
  }
  for (const Brick& b : grid.bricks) {
    out << "brick" << at(b.origin);
    for (int i = 0; i < kBrickSamples; ++i) out << single(b.values[i]);
    out << '\n';
  }
}

/// Bytes of a whole file, or of one within it.
void print(std::ostringstream& out, const PvolFile& p, const PvolBytes& bytes) {
  print_chunks(out, bytes);
  print_metadata(out, p.metadata);
  print_bounds(out, p.pyramid);
  if (p.micro) print_micro_bounds(out, p.pyramid, p.micro->by_leaf);
  if (p.shell) print_shell(out, *p.shell);
  if (p.metadata.quantisation.precision != Precision::fp32) {
    out << "precision " << name(p.metadata.quantisation.precision) << '\n';
  }
  print_density(out, *p.density);
  std::size_t field = 0;
  for (const auto& chunk : bytes.chunks) {
    if (chunk.entry.id != detail::kField) continue;
    out << "field\n";
    print(out, p.fields[field++], PvolBytes(chunk.stored));
  }
}

std::string print(const fs::path& file) {
  std::ostringstream out;
  print(out, read_pvol(file), PvolBytes(test::load(file)));
  return out.str();
}

TEST_F(PvolFileTest, AnIndependentReaderSeesTheSame) {
  const bool zstd = std::system("zstd --version > /dev/null 2>&1") == 0;
  const std::string command = PVOL_PYTHON " \"" PVOL_READ_PVOL "\" \"" + path("a.pvol").string() +
                              "\" > \"" + path("print").string() + "\" 2>&1";
  std::vector<PvolFile> contents{some_file(), test::with_micro_bounds(test::compact_file())};
  for (const Precision p : {Precision::fp16, Precision::fp8, Precision::fpn}) {
    contents.push_back(test::with_micro_bounds(test::with_codes(test::compact_file(), {p, 0.1})));
  }
  contents.push_back(with_fields());
  for (const PvolFile& content : contents) {
    for (const Compression compression : {Compression::none, Compression::zstd}) {
      if (compression == Compression::zstd && !zstd) continue;
      if (compression == Compression::none && zstd && content.codes) continue;  // takes a second
      write_pvol(path("a.pvol"), content, compression);
      ASSERT_EQ(std::system(command.c_str()), 0);
      const auto bytes = test::load(path("print"));
      EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
                print(path("a.pvol")));
    }
  }

  // It finds micro-bounds that do not hold, too.
  PvolFile wrong = test::with_micro_bounds(test::compact_file());
  auto& codes = wrong.micro->by_leaf.codes;
  ++std::find_if(codes.begin(), codes.end(), [](auto c) { return c.lo < c.hi; })->lo;
  write_pvol(path("a.pvol"), wrong, Compression::none);
  EXPECT_NE(std::system(command.c_str()), 0);
  const auto bytes = test::load(path("print"));
  EXPECT_TRUE(says(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
                   "pvol_file.micro_bounds_minus"));
}

}  // namespace pvol_file_test
}  // namespace pvol::formats
