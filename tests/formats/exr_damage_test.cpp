// Small EXR files that announce more than memory holds. Damage to pixels is in image_test.cpp.
#include <ImfChannelList.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>

#include <cstring>

#include "pvol/error.h"
#include "pvol/formats/image.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace pvol::formats {
namespace exr_damage_test {

namespace fs = std::filesystem;

std::string refusal(const fs::path& file) {
  try {
    static_cast<void>(read_sky(file));
    return {};
  } catch (const Error& e) {
    return e.what();
  }
}

Imf::Header header_of(int width, int height, int channels = 3) {
  Imf::Header header(width, height);
  for (const char* name : {"R", "G", "B"}) header.channels().insert(name, Imf::Channel(Imf::HALF));
  for (int i = 3; i < channels; ++i) {
    header.channels().insert(std::to_string(i), Imf::Channel(Imf::FLOAT));
  }
  return header;
}

/// What is said about a file with this header and without pixels.
std::string refusal(const Imf::Header& header) {
  const TemporaryFolder folder;
  const fs::path file = folder.file("a.exr");
  if (header.hasTileDescription()) {
    const Imf::TiledOutputFile out(file.c_str(), header);
  } else {
    const Imf::OutputFile out(file.c_str(), header);
  }
  return refusal(file);
}

TEST(ExrDamage, AttributesAreInTheFileAndOfTheSizeOfTheirType) {
  const TemporaryFolder folder;
  const Film film{1, 1, 0, 0, 1, 1, {PixelSums{}}};
  write_exr(folder.file("a.exr"), film, {});
  const std::string whole = read_bytes(folder.file("a.exr"));
  EXPECT_EQ(refusal(folder.file("a.exr")), "");
  const std::string attribute("pixelAspectRatio\0float\0", 23);
  const std::size_t at = whole.find(attribute) + attribute.size();
  for (const std::uint32_t size : {0u, 5u, 0x61616161u, 0xffffffffu}) {
    std::string bytes = whole;
    std::memcpy(bytes.data() + at, &size, sizeof size);
    write_bytes(folder.file("b.exr"), bytes);
    const std::string message = refusal(folder.file("b.exr"));
    EXPECT_TRUE(says(message, "exr.byte_attribute_pixelaspectratio"));
  }
}

TEST(ExrDamage, BlocksOfGigabytesAreRefused) {
  Imf::Header header = header_of(40000, 300, 100);
  header.compression() = Imf::DWAB_COMPRESSION;
  const std::string message = refusal(header);
  EXPECT_TRUE(says(message, "exr.blocks_rows_bytes"));
}

TEST(ExrDamage, MoreBlocksThanAFileHoldsAreRefused) {
  const TemporaryFolder folder;
  Imf::Header header = header_of(16, 16);
  header.setTileDescription(Imf::TileDescription(1, 1));
  { const Imf::TiledOutputFile out(folder.file("a.exr").c_str(), header); }
  std::string bytes = read_bytes(folder.file("a.exr"));
  const std::string window("dataWindow\0box2i\0\x10\0\0\0", 21);
  const std::int32_t corners[] = {0, 0, 16383, 16383};
  std::memcpy(bytes.data() + bytes.find(window) + window.size(), corners, sizeof corners);
  write_bytes(folder.file("a.exr"), bytes);
  const std::string message = refusal(folder.file("a.exr"));
  EXPECT_TRUE(says(message, "exr.incomplete_bytes_not_hold"));
}

/// Another data window, three times as wide.
std::string widened(std::string bytes) {
  const std::string window("dataWindow\0box2i\0\x10\0\0\0", 21);
  char* corners = bytes.data() + bytes.find(window) + window.size();
  std::int32_t right = 0;
  std::memcpy(&right, corners + 8, sizeof right);
  right = 3 * right + 2;
  std::memcpy(corners + 8, &right, sizeof right);
  return bytes;
}

TEST(ExrDamage, PixelsThatDoNotFillThePictureAreRefused) {
  const TemporaryFolder folder;
  const Film film{4, 3, 0, 0, 4, 3, std::vector<PixelSums>(12)};
  write_exr(folder.file("a.exr"), film, {});
  EXPECT_EQ(refusal(folder.file("a.exr")), "");
  write_bytes(folder.file("b.exr"), widened(read_bytes(folder.file("a.exr"))));
  // They were what happened to be in memory.
  const std::string message = refusal(folder.file("b.exr"));
  EXPECT_TRUE(says(message, "exr.block_0_pixels_not_fill"));

  // A block of no bytes, which the table's first entry leads to.
  std::string none = read_bytes(folder.file("a.exr"));
  std::uint64_t block = 0;
  const std::string last("screenWindowWidth\0float\0\4\0\0\0\0\0\x80?\0", 33);
  std::memcpy(&block, none.data() + none.find(last) + last.size(), sizeof block);
  std::memset(none.data() + block + 4, 0, 4);
  write_bytes(folder.file("b.exr"), none);
  EXPECT_TRUE(says(refusal(folder.file("b.exr")), "exr.block_0_pixels"));

  // Without a word about its compression a file is zipped.
  std::string bytes = widened(read_bytes(folder.file("a.exr")));
  bytes[bytes.find("compression")] = 'C';
  write_bytes(folder.file("b.exr"), bytes);
  EXPECT_EQ(refusal(folder.file("b.exr")), message);
}

/// A picture of 40 x 40 pixels with something in each.
void write_half(const fs::path& file, Imf::Compression compression, bool tiled) {
  constexpr int kEdge = 40;
  std::vector<half> values(kEdge * kEdge);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = half(float(i % 97 / 8));
  Imf::Header header = header_of(kEdge, kEdge);
  header.compression() = compression;
  Imf::FrameBuffer pixels;
  for (const char* name : {"R", "G", "B"}) {
    pixels.insert(name, Imf::Slice::Make(Imf::HALF, values.data(), header.dataWindow()));
  }
  if (tiled) {
    header.setTileDescription(Imf::TileDescription(16, 16));
    Imf::TiledOutputFile out(file.c_str(), header);
    out.setFrameBuffer(pixels);
    out.writeTiles(0, out.numXTiles() - 1, 0, out.numYTiles() - 1);
  } else {
    Imf::OutputFile out(file.c_str(), header);
    out.setFrameBuffer(pixels);
    out.writePixels(kEdge);
  }
}

/// The entries of the table of blocks, which begins where they lead behind its own end.
std::vector<std::uint64_t> table_of(const std::string& bytes, std::size_t blocks) {
  std::vector<std::uint64_t> offsets(blocks);
  for (std::size_t at = 0; at + 8 * blocks <= bytes.size(); ++at) {
    std::memcpy(offsets.data(), bytes.data() + at, 8 * blocks);
    if (offsets.front() == at + 8 * blocks) return offsets;
  }
  return {};
}

/// A block as it is stored, from its size on.
std::string stored_block(const std::string& bytes, std::uint64_t at) {
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + at, sizeof size);
  return bytes.substr(at, sizeof size + size);
}

/// What a block of so many bytes less is stored as.
std::string shortened(std::string block, std::uint32_t less) {
  const std::uint32_t size = std::uint32_t(block.size() - sizeof size) - less;
  std::memcpy(block.data(), &size, sizeof size);
  return block;
}

/// Of each packing that OpenEXR fills up with what is in memory.
TEST(ExrDamage, NoBlockIsShorterThanItsHeaderSays) {
  const TemporaryFolder folder;
  const fs::path whole = folder.file("a.exr"), bad = folder.file("b.exr");
  const std::pair<Imf::Compression, std::size_t> cases[] = {
      {Imf::NO_COMPRESSION, 40}, {Imf::RLE_COMPRESSION, 40}, {Imf::ZIP_COMPRESSION, 3}};
  for (const auto& [compression, blocks] : cases) {
    for (const bool tiled : {false, true}) {
      write_half(whole, compression, tiled);
      ASSERT_EQ(refusal(whole), "") << compression << ' ' << tiled;
      const std::string bytes = read_bytes(whole);
      const std::vector<std::uint64_t> offsets = table_of(bytes, tiled ? 9 : blocks);
      ASSERT_FALSE(offsets.empty());
      const auto block_at = [&](std::size_t i) { return offsets[i] + (tiled ? 16 : 4); };
      const std::size_t middle = offsets.size() / 2;
      // The last block is smaller: zipped, it comes whole in the middle one's place.
      const std::string block = compression == Imf::ZIP_COMPRESSION
                                    ? stored_block(bytes, block_at(offsets.size() - 1))
                                    : shortened(stored_block(bytes, block_at(middle)), 2);
      ASSERT_LE(block.size(), stored_block(bytes, block_at(middle)).size());
      write_bytes(bad, std::string(bytes).replace(block_at(middle), block.size(), block));
      const std::string message = refusal(bad);
      EXPECT_TRUE(says(message, "exr.block_pixels_not_fill")) << compression << ' ' << tiled;
      EXPECT_NE(message.find("block " + std::to_string(middle) + ' '), message.npos) << message;
    }
  }
}

std::string film_refusal(const fs::path& file) {
  try {
    static_cast<void>(read_film(file));
    return {};
  } catch (const Error& e) {
    return e.what();
  }
}

/// Films are read from every part.
TEST(ExrDamage, NoBlockOfAnyPartIsShorterThanItsHeaderSays) {
  const TemporaryFolder folder;
  const fs::path whole = folder.file("a.exr"), bad = folder.file("b.exr");
  constexpr std::size_t kRows = 3, kParts = 3;
  const Film film{4, 3, 0, 0, 4, 3, std::vector<PixelSums>(12)};
  write_exr(whole, film, {},
            {.aovs = {Aov::variance, Aov::samples},
             .multipart = true,
             .compression = ExrCompression::none});
  ASSERT_EQ(film_refusal(whole), "");
  const std::string bytes = read_bytes(whole);
  const std::vector<std::uint64_t> offsets = table_of(bytes, kParts * kRows);
  ASSERT_FALSE(offsets.empty());
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    const std::uint64_t at = offsets[i] + 8;  // after the numbers of the part and of the row
    const std::string block = shortened(stored_block(bytes, at), 2);
    write_bytes(bad, std::string(bytes).replace(at, block.size(), block));
    const std::string message = film_refusal(bad);
    EXPECT_TRUE(says(message, "exr.block_pixels_not_fill")) << i;
    EXPECT_NE(message.find("block " + std::to_string(i % kRows) + ' '), message.npos) << message;
  }
}

TEST(ExrDamage, EveryTruncationOfPartsIsRefused) {
  const TemporaryFolder folder;
  const Film film{4, 3, 0, 0, 4, 3, std::vector<PixelSums>(12)};
  write_exr(folder.file("a.exr"), film, {}, {.aovs = {Aov::samples}, .multipart = true});
  const std::string bytes = read_bytes(folder.file("a.exr"));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    write_bytes(folder.file("b.exr"), bytes.substr(0, size));
    EXPECT_NE(film_refusal(folder.file("b.exr")), "") << size;
  }
}

/// What one part may announce many may not together.
TEST(ExrDamage, PartsCountTogether) {
  const TemporaryFolder folder;
  const auto write = [&](std::size_t parts) {
    std::vector<Imf::Header> headers(parts, header_of(40000, 300));
    for (std::size_t i = 0; i < parts; ++i) {
      headers[i].setName(std::to_string(i));
      headers[i].setType(Imf::SCANLINEIMAGE);
      headers[i].compression() = Imf::DWAB_COMPRESSION;
    }
    const Imf::MultiPartOutputFile out(folder.file("a.exr").c_str(), headers.data(), int(parts));
  };
  write(4);
  EXPECT_TRUE(says(film_refusal(folder.file("a.exr")), "exr.incomplete_pixels_missing"));
  write(5);
  EXPECT_TRUE(says(film_refusal(folder.file("a.exr")), "exr.blocks_rows_bytes"));
}

TEST(ExrDamage, KilobytesDoNotFillMemory) {
  const TemporaryFolder folder;
  const fs::path file = folder.file("a.exr");
  constexpr int kWidth = 8192, kHeight = 4096;
  const std::vector<half> row(kWidth, half(1.0f));
  Imf::Header header = header_of(kWidth, kHeight);
  header.compression() = Imf::DWAB_COMPRESSION;
  {
    Imf::OutputFile out(file.c_str(), header);
    Imf::FrameBuffer pixels;
    for (const char* name : {"R", "G", "B"}) {
      pixels.insert(
          name, Imf::Slice(Imf::HALF, const_cast<char*>(reinterpret_cast<const char*>(row.data())),
                           sizeof(half), 0));
    }
    out.setFrameBuffer(pixels);
    out.writePixels(kHeight);
  }
  ASSERT_LT(fs::file_size(file), 100'000u);
  const std::string message = refusal(file);
  EXPECT_TRUE(says(message, "exr.x_pixels_bytes"));
}

TEST(ExrDamage, ChannelsOfFewerSamplesAreRefused) {
  Imf::Header header = header_of(4, 4);
  header.channels().insert("Z", Imf::Channel(Imf::HALF, 2, 1));
  const std::string message = refusal(header);
  EXPECT_TRUE(says(message, "exr.fewer_samples_pixels"));
}

TEST(ExrDamage, TilesBeyondEveryPictureAreRefused) {
  Imf::Header header = header_of(16, 16);
  header.setTileDescription(Imf::TileDescription(16, 65537));
  const std::string message = refusal(header);
  EXPECT_TRUE(says(message, "exr.tiles_x_pixels"));
}

TEST(ExrDamage, DeepPixelsAreRefused) {
  const TemporaryFolder folder;
  Imf::Header header = header_of(2, 2);
  header.setType(Imf::DEEPSCANLINE);
  header.compression() = Imf::ZIPS_COMPRESSION;
  { const Imf::DeepScanLineOutputFile out(folder.file("a.exr").c_str(), header); }
  const std::string message = refusal(folder.file("a.exr"));
  EXPECT_TRUE(says(message, "deep.deep_pixels_several"));
}

}  // namespace exr_damage_test
}  // namespace pvol::formats
