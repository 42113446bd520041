// Damaged and hostile .pvol files: each is refused with an Error, whether its sums are right or
// not.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "pvol/error.h"
#include "pvol/formats/pvol_file.h"
#include "support/effort.h"
#include "support/forgeries.h"
#include "support/messages.h"
#include "support/pvol_bytes.h"
#include "support/pvol_content.h"

namespace pvol::formats {
namespace pvol_forgery_test {

using test::error_of;
using test::expect_equal_samples;
using test::PvolBytes;
using test::some_file;
using test::tiny_file;
using test::with_codes;
using test::with_micro_bounds;

using PvolForgeryTest = test::PvolFileTest;

TEST_F(PvolForgeryTest, EveryTruncationIsRefused) {
  for (const PvolFile& content : {tiny_file(), some_file(3, false)}) {
    std::vector<std::byte> bytes = written(content);
    while (!bytes.empty()) {
      bytes.pop_back();
      ASSERT_THROW((void)read_pvol(bytes, "a"), Error) << bytes.size();
    }
  }
}

TEST_F(PvolForgeryTest, AppendedBytesAreRefused) {
  std::vector<std::byte> bytes = written(tiny_file());
  bytes.push_back(std::byte{0});
  EXPECT_THROW((void)read_pvol(bytes, "a"), Error);
}

TEST_F(PvolForgeryTest, EveryFlippedBitIsRefused) {
  const std::vector<std::byte> good = written(tiny_file());
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    std::vector<std::byte> bad = good;
    bad[bit / 8] ^= std::byte(1 << bit % 8);
    ASSERT_THROW((void)read_pvol(bad, "a"), Error) << "byte " << bit / 8 << " bit " << bit % 8;
  }
}

/// Of every chunk that a file can have, by its sum: decoders need not notice.
TEST_F(PvolForgeryTest, OneWrongByteInAnyChunkIsNamed) {
  const PvolFile plain = with_micro_bounds(some_file(3, false));
  const PvolFile coded = with_micro_bounds(with_codes(some_file(3, false), {Precision::fp16}));
  for (const PvolFile& content : {plain, coded}) {
    for (const Compression compression : {Compression::zstd, Compression::none}) {
      const std::vector<std::byte> good = written(content, compression);
      const PvolBytes parts(good);
      EXPECT_EQ(parts.chunks.size(), 5u);
      for (const PvolBytes::Chunk& c : parts.chunks) {
        const std::string id(c.entry.id.begin(), c.entry.id.end());
        for (const std::uint64_t at :
             {std::uint64_t(0), c.entry.stored_bytes / 2, c.entry.stored_bytes - 1}) {
          std::vector<std::byte> bad = good;
          bad[c.entry.offset + at] ^= std::byte{16};
          const std::string error = error_of([&] { (void)read_pvol(bad, "a"); });
          EXPECT_NE(error.find("chunk " + id), std::string::npos) << id << ": " << error;
          EXPECT_TRUE(says(error, "pvol_file.checksum_not_match"));
        }
      }
    }
  }
}

TEST_F(PvolForgeryTest, DamageInTransitIsRefused) {
  const std::vector<std::byte> good = written(tiny_file());
  std::vector<std::byte> seven_bits = good, unix_text, dos_text;
  for (std::byte& b : seven_bits) b &= std::byte{0x7f};
  for (std::size_t i = 0; i < good.size(); ++i) {
    const bool crlf =
        i + 1 < good.size() && good[i] == std::byte{'\r'} && good[i + 1] == std::byte{'\n'};
    if (!crlf) unix_text.push_back(good[i]);
    if (good[i] == std::byte{'\n'}) dos_text.push_back(std::byte{'\r'});
    dos_text.push_back(good[i]);
  }
  for (const auto& bad : {seven_bits, unix_text, dos_text}) {
    EXPECT_TRUE(
        says(error_of([&] { (void)read_pvol(bad, "a"); }), "pvol_file.not_begin_signature"));
  }
}

struct Forgery {
  const char* key;  // of the message
  test::Damage damage;
};

/// All of a file that is not compressed.
std::vector<Forgery> forgeries() {
  using test::f32, test::f64, test::meta, test::u32;
  constexpr std::size_t kMeta = 0, kBounds = 1, kShell = 2, kDensity = 3;
  constexpr std::size_t kNodes = 56;  // BNDS: where the masks begin
  return {
      {"pvol_file.format_version_needs",
       [](PvolBytes& f) { f.header.version = f.header.reader_version = detail::kVersion + 1; }},
      {"pvol_file.format_version_readers", [](PvolBytes& f) { f.header.version = 0; }},
      {"pvol_file.format_version_readers", [](PvolBytes& f) { f.header.reader_version = 2; }},
      {"pvol_file.header_chunks_not_fit", [](PvolBytes& f) { f.forged_count = 0xffffffff; }},
      {"pvol_file.meta_occurs_times", [](PvolBytes& f) { f.chunks.erase(f.chunks.begin()); }},
      {"pvol_file.meta_occurs_times_damaged",
       [](PvolBytes& f) { f.chunks.push_back(f.chunks[0]); }},
      {"pvol_file.bnds_occurs_times", [](PvolBytes& f) { f.chunks.resize(1); }},
      {"pvol_file.denx_unknown_version",
       [](PvolBytes& f) {
         f.chunks[kDensity].entry.id = {'D', 'E', 'N', 'X'};
       }},
      {"pvol_file.unprintable_name_unknown",
       [](PvolBytes& f) {
         f.chunks[kDensity].entry.id = {'\x01', 0, 0, 0};
       }},
      {"pvol_file.offset_expected_damaged", [](PvolBytes& f) { f.chunks[1].forged_offset = 192; }},
      {"pvol_file.offset_expected_damaged",
       [](PvolBytes& f) { f.chunks[1].forged_offset = ~std::uint64_t(0) - 63; }},
      {"pvol_file.bytes_extend_past",
       [](PvolBytes& f) { f.chunks[3].forged_stored = ~std::uint64_t(0); }},
      {"pvol_file.offset_expected_damaged",
       [](PvolBytes& f) { f.chunks[1].forged_stored = 1 << 10; }},
      {"pvol_file.chunks_end", [](PvolBytes& f) { f.chunks[3].forged_stored = 4; }},
      {"pvol_file.padding_before_not_zero", [](PvolBytes& f) { f.padding = std::byte{1}; }},
      {"pvol_file.bnds_codec", [](PvolBytes& f) { f.chunks[1].entry.codec = detail::Codec(3); }},
      {"pvol_file.bnds_stored_bytes", [](PvolBytes& f) { f.chunks[1].entry.raw_bytes += 1; }},
      {"pvol_file.bnds_compressed_data",
       [](PvolBytes& f) { f.chunks[1].entry.codec = detail::Codec::zstd; }},
      {"pvol_file.ends_early_bytes", [](PvolBytes& f) { f.set(kBounds, {}); }},
      {"pvol_file.ends_early_bytes", [](PvolBytes& f) { f.set(kDensity, {}); }},
      {"pvol_file.meta_not_json", [](PvolBytes& f) { f.set(kMeta, {}); }},
      {"pvol_file.meta_not_json", meta("\"unit\":", "\"unit\"")},
      {"pvol_file.meta_not_json", meta("dichte", "\xff\xff\xff\xff\xff\xff")},
      {"pvol_file.meta_not_json", meta("3000000000.0", "3e99999")},
      {"pvol_file.meta_key_unit", meta("\"unit\"", "\"Unit\"")},
      {"pvol_file.meta_unit", meta("\"unit\":\"m\"", "\"unit\":12")},
      {"pvol_file.meta_index_to_world_minus", meta("0.1", "0.0")},
      {"pvol_file.meta_index_to_world_minus", meta("[0.1,", "[")},
      {"pvol_file.meta_index_to_world_minus", meta("[0.1,", "[null,")},
      {"pvol_file.meta_interpolation_nearest", meta("trilinear", "tricubic")},
      {"pvol_file.meta_interpolation_nearest", meta("\"trilinear\"]", "\"trilinear\",\"cubic\"]")},
      {"pvol_file.meta_source_xxh3_64", meta("0123456789abcdef", "0123456789abcdeF")},
      {"pvol_file.meta_source_xxh3_64", meta("0123456789abcdef", "123456789abcdef")},
      {"pvol_file.meta_source_bytes", meta("18446744073709551615", "-1")},
      {"pvol_file.meta_source", meta("\"source\":{", "\"source\":[],\"x\":{")},
      {"pvol_file.meta_options_depth", meta("\"auto\"", "[[]]")},
      {"pvol_file.meta_json_more_levels",
       meta("\"m\"", std::string(33, '[') + std::string(33, ']'))},
      {"pvol_file.meta_json_more_levels",  // printing it overflowed the stack
       meta("\"m\"", std::string(400000, '[') + std::string(400000, ']'))},
      {"pvol_file.meta_unit_kkkkkk", meta("\"m\"", "[\"" + std::string(900, 'k') + "\"]")},
      {"pvol_file.meta_unit_kkkkkk", meta("\"m\"", "[\"" + std::string(900, 'k') + "\"]")},
      {"pvol_file.meta_bytes", [](PvolBytes& f) { f.set(kMeta, std::vector<std::byte>(2 << 20)); }},
      {"pvol_file.bnds_origin_no_multiple", u32(kBounds, 0, 3)},
      {"pvol_file.bnds_support_minus", u32(kBounds, 12, 0x80000000)},
      {"pvol_file.bnds_support_not_end", u32(kBounds, 12, 16)},
      {"pvol_file.bnds_scale", f32(kBounds, 36, -1)},
      {"pvol_file.bnds_scale", f32(kBounds, 36, std::nanf(""))},
      {"pvol_file.bnds_masks_lead_elsewhere", u32(kBounds, 40, 0)},
      {"pvol_file.bnds_masks_lead_too_far", u32(kBounds, 40, 1)},
      {"pvol_file.bnds_levels", u32(kBounds, 40, 23)},
      {"pvol_file.bnds_levels", u32(kBounds, 40, 0xffffffff)},
      {"pvol_file.bnds_10639_raw_bytes", u32(kBounds, 44, 0xffffffff)},
      {"pvol_file.bnds_raw_bytes", u32(kBounds, 48, 0)},
      {"pvol_file.bnds_10639_raw", u32(kBounds, 52, 0xffffffff)},
      {"pvol_file.bnds_node_no_children",
       [](PvolBytes& f) { f.put(kBounds, kNodes, std::uint64_t(0)); }},
      {"pvol_file.bnds_masks_lead_too_far",
       [](PvolBytes& f) { f.put(kBounds, kNodes, ~std::uint64_t(0)); }},
      {"pvol_file.bnds_node_empty",
       [](PvolBytes& f) { f.put(kBounds, f.stops(), ~std::uint64_t(0)); }},
      {"pvol_file.bnds_node_group",
       [](PvolBytes& f) { f.put(kBounds, f.groups(), std::uint8_t(1)); }},
      {"pvol_file.bnds_terminal_bound",
       [](PvolBytes& f) { f.put(kBounds, f.lows(), std::uint16_t(0xffff)); }},
      {"pvol_file.bnds_bounds_not_order",
       [](PvolBytes& f) { f.put(kBounds, f.highs(), std::uint16_t(0)); }},
      {"pvol_file.shel_occurs_times", [](PvolBytes& f) { f.chunks.push_back(f.chunks[kShell]); }},
      {"pvol_file.shel_shell_unknown", u32(kShell, 0, 2)},
      {"pvol_file.shel_perturbations_not_fit", u32(kShell, 4, 1)},
      {"pvol_file.shel_perturbations_not_fit", u32(kShell, 4, 0xffffffff)},
      {"pvol_file.shel_perturbations_not_fit",
       [](PvolBytes& f) { f.set(kShell, std::vector<std::byte>(90)); }},
      {"pvol_file.ends_early_bytes", [](PvolBytes& f) { f.set(kShell, {}); }},
      {"pvol_file.shel_strength_hard", u32(kShell, 0, 0)},
      {"pvol_file.shel_certificate_bound", f64(kShell, 8, 0)},
      {"pvol_file.shel_certificate_bound", f64(kShell, 8, std::nan(""))},
      {"pvol_file.shel_ratio_not_finite", f32(kShell, 40, std::nanf(""))},
      {"pvol_file.shel_coefficient_not_finite", f32(kShell, 48, std::nanf(""))},
      {"pvol_file.shel_coefficient_not_finite", f32(kShell, 88 + 40, HUGE_VALF)},
      {"pvol_file.dens_24768_raw", u32(kDensity, 0, 0xffffffff)},
      {"pvol_file.dens_raw_bytes", u32(kDensity, 4, 0xffffffff)},
      {"pvol_file.dens_tile_out_order", [](PvolBytes& f) { f.swap(kDensity, 8, 28, 20); }},
      {"pvol_file.dens_tile_not_aligned", u32(kDensity, 8, 0x7fffffff)},
      {"pvol_file.dens_tile_edge", u32(kDensity, 20, 0)},
      {"pvol_file.dens_tile_edge", u32(kDensity, 20, 0x80000000)},
      {"pvol_file.dens_tile_value", f32(kDensity, 24, -1)},
      {"pvol_file.dens_tile_value", f32(kDensity, 24, std::nanf(""))},
      {"pvol_file.dens_tile_value", f32(kDensity, 24, 0)},
      {"pvol_file.dens_brick_not_aligned", u32(kDensity, 48, 1)},
      {"pvol_file.dens_brick_outside", u32(kDensity, 48, 0x80000000)},
      {"pvol_file.dens_brick_out_order", [](PvolBytes& f) { f.swap(kDensity, 48, 60, 12); }},
      {"pvol_file.dens_brick_out_order", [](PvolBytes& f) { f.copy(kDensity, 48, 60, 12); }},
      {"pvol_file.dens_brick_inside", [](PvolBytes& f) { f.copy(kDensity, 8, 48, 12); }},
      {"pvol_file.brick_sample_negative",
       [](PvolBytes& f) { f.put(kDensity, f.size(kDensity) - 4, -1e-30f); }},
      {"pvol_file.brick_sample_negative",
       [](PvolBytes& f) { f.put(kDensity, f.size(kDensity) - 4, std::nanf("")); }},
  };
}

TEST_F(PvolForgeryTest, ForgedFilesAreRefusedThoughTheirSumsMatch) {
  const PvolBytes good(written(some_file(), Compression::none));
  ASSERT_NO_THROW((void)read_pvol(good.bytes(), "a"));
  for (const Forgery& forgery : forgeries()) {
    PvolBytes bad = good;
    forgery.damage(bad);
    test::expect_refused(bad, forgery.key);
  }
}

TEST_F(PvolForgeryTest, ZstdBombsAreRefusedBeforeTheyTakeMemory) {
  const PvolBytes good(written(some_file(), Compression::none));
  const auto error = [&](std::size_t chunk, detail::Codec codec, std::vector<std::byte> stored,
                         std::uint64_t raw) {
    PvolBytes bad = good;
    bad.chunks[chunk].entry.codec = codec;
    bad.chunks[chunk].stored = std::move(stored);
    bad.chunks[chunk].entry.raw_bytes = raw;
    return error_of([&] { (void)read_pvol(bad.bytes(), "a"); });
  };
  const std::vector<std::byte> zeros(detail::kFrameBytes);
  std::vector<std::byte> frames = test::zstd(zeros);
  const auto one = frames;
  for (int i = 1; i < 8; ++i) frames.insert(frames.end(), one.begin(), one.end());
  const std::uint64_t megabyte = detail::kFrameBytes;
  using detail::Codec;
  EXPECT_TRUE(says(error(3, Codec::zstd, frames, std::uint64_t(1) << 60),
                   "pvol_file.dens_compressed_data"));
  EXPECT_TRUE(says(error(3, Codec::zstd, frames, 7 * megabyte), "pvol_file.dens_bytes_after"));
  EXPECT_TRUE(says(error(3, Codec::zstd, frames, 8 * megabyte - 4), "pvol_file.dens_zstd_frame"));
  EXPECT_TRUE(says(error(3, Codec::zstd, frames, 8 * megabyte), "pvol_file.dens_8388608_raw"));
  EXPECT_TRUE(says(error(1, Codec::zstd, frames, 8 * megabyte), "pvol_file.bnds_8388608_raw"));
  EXPECT_TRUE(says(error(0, Codec::zstd, frames, 8 * megabyte), "pvol_file.meta_8388608_bytes"));
  EXPECT_NE(error(3, Codec::shuffled_zstd, test::zstd(detail::Bytes(zeros).first(1023)), 1023)
                .find("words"),
            std::string::npos);
  // One frame that says it holds more than a frame may.
  EXPECT_TRUE(says(error(3, Codec::zstd, test::zstd(std::vector<std::byte>(4 << 20)), 4 << 20),
                   "pvol_file.dens_zstd_frame_raw"));
  // A frame whose content is not what its header says.
  std::vector<std::byte> wrong = test::zstd(written(tiny_file()));
  wrong[wrong.size() / 2] ^= std::byte{0xff};
  EXPECT_FALSE(error(0, Codec::zstd, wrong, written(tiny_file()).size()).empty());
}

TEST_F(PvolForgeryTest, UnknownAncillaryChunksAreSkipped) {
  PvolBytes file(written(some_file()));
  PvolBytes::Chunk extra;
  extra.entry.id = {'s', 'H', 'E', 'L'};
  extra.entry.codec = detail::Codec(77);
  extra.stored.resize(1000);
  file.chunks.insert(file.chunks.begin() + 1, extra);
  file.chunks.push_back(extra);
  const PvolFile back = read_pvol(file.bytes(), "a");
  EXPECT_EQ(back.pyramid, some_file().pyramid);
  expect_equal_samples(*back.density, *some_file().density);
}

TEST_F(PvolForgeryTest, TheFirstLetterSaysWhetherAnUnknownChunkMayBeSkipped) {
  for (const char first : {'a', 'z', 'A', 'Z', '`', '{'}) {
    PvolBytes file(written(tiny_file()));
    PvolBytes::Chunk extra;
    extra.entry.id = {first, 'N', 'E', 'W'};
    file.chunks.push_back(extra);
    if ('a' <= first && first <= 'z') {
      EXPECT_NO_THROW((void)read_pvol(file.bytes(), "a")) << first;
    } else {
      test::expect_refused(file, "pvol_file.unknown_version_skipped");
    }
  }
}

TEST_F(PvolForgeryTest, NewerFilesThatThisReaderUnderstandsAreRead) {
  PvolBytes file(written(some_file()));
  file.header.version = 9;
  EXPECT_EQ(read_pvol(file.bytes(), "a").pyramid, some_file().pyramid);
}

/// One input of a fuzzer: any bytes give a valid file's content or an Error.
void fuzz_pvol(const std::uint8_t* data, std::size_t size) {
  try {
    const PvolFile file = read_pvol(std::as_bytes(std::span(data, size)), "fuzz");
    ASSERT_EQ(validate(file.pyramid), std::nullopt);
  } catch (const Error&) {
  }
}

TEST_F(PvolForgeryTest, RandomDamageWithRightSumsNeverCrashes) {
  std::mt19937_64 random(11);
  for (const Compression compression : {Compression::none, Compression::zstd}) {
    const PvolBytes good(written(some_file(4, false), compression));
    for (int i = 0; i < proof::samples(20000); ++i) {
      PvolBytes bad = good;
      for (std::uint64_t n = 1 + random() % 3; n > 0; --n) {
        PvolBytes::Chunk& chunk = bad.chunks[random() % bad.chunks.size()];
        const std::size_t at = random() % std::min<std::size_t>(chunk.stored.size(), 400);
        switch (random() % 5) {
          case 0:
            chunk.stored[at] ^= std::byte(1 << random() % 8);
            break;
          case 1:
            chunk.stored[at] = std::byte(random() % 2 ? 0xff : 0x00);
            break;
          case 2:
            chunk.stored.resize(random() % 2 ? at + 1 : chunk.stored.size() + 8);
            break;
          case 3:
            chunk.entry.raw_bytes = random() >> random() % 64;
            break;
          default:
            chunk.stored[at] = std::byte(random());
            break;
        }
        if (chunk.entry.codec == detail::Codec::raw && random() % 4) {
          chunk.entry.raw_bytes = chunk.stored.size();
        }
      }
      const std::vector<std::byte> bytes = bad.bytes();
      fuzz_pvol(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    }
  }
}

}  // namespace pvol_forgery_test
}  // namespace pvol::formats
