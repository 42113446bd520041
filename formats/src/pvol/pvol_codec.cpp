// The raw bytes of chunks from their stored bytes and back: zstd frames of one megabyte, so that
// threads can decode several at once, and neither direction holds more than one for each thread
// besides the data itself.
#include <fmt/format.h>

#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <sstream>

#include "pvol/error.h"
#include "pvol/math/parallel.h"
#include "pvol/pvol_chunks.h"

namespace pvol::formats::detail {
namespace {

// Levels 3 to 9 change the size of shuffled density by -1 % to 4 % of level 1's and take 2 to 8
// times as long. Bounds are few enough for a level that takes trouble: 4 % smaller than at level 1.
constexpr int kDensityLevel = 1;
constexpr int kBoundsLevel = 9;

std::string number(std::uint64_t n) { return fmt::to_string(n); }

/// Word i of `out` is made of byte i of each of the four quarters of `in`.
void unshuffle(Bytes in, std::span<std::byte> out) {
  const std::size_t words = in.size() / 4;
  for (std::size_t i = 0; i < words; ++i) {
    for (std::size_t plane = 0; plane < 4; ++plane) out[4 * i + plane] = in[plane * words + i];
  }
}

void shuffle(Bytes in, std::byte* out) {
  const std::size_t words = in.size() / 4;
  for (std::size_t i = 0; i < words; ++i) {
    for (std::size_t plane = 0; plane < 4; ++plane) out[plane * words + i] = in[4 * i + plane];
  }
}

}  // namespace

void refuse(const std::string& place, const std::string& wrong) {
  throw Error(place + ": " + wrong + ". The file is damaged or not a .pvol file: make it again.");
}

std::uint64_t checksum(Bytes bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

ChunkReader::ChunkReader(const ChunkEntry& entry, Bytes stored, std::string place,
                         std::shared_ptr<const void> owner)
    : entry_(entry), left_(entry.raw_bytes), place_(std::move(place)), owner_(std::move(owner)) {
  switch (entry.codec) {
    case Codec::raw:
      if (stored.size() != entry.raw_bytes) {
        refuse(place_, number(stored.size()) + " stored bytes, but " + number(entry.raw_bytes) +
                           " raw ones, although it is not compressed");
      }
      frame_ = stored;
      return;
    case Codec::zstd:
    case Codec::shuffled_zstd:
      find_frames(stored);
      return;
  }
  refuse(place_, "codec " + number(std::uint64_t(entry.codec)) + "; expected 0, 1 or 2");
}

/// Every frame says how many raw bytes it holds: kFrameBytes, but for the last. Nothing is decoded.
void ChunkReader::find_frames(Bytes rest) {
  std::uint64_t left = left_;
  while (left > 0) {
    const std::uint64_t expected = std::min<std::uint64_t>(left, kFrameBytes);
    const std::size_t size = ZSTD_findFrameCompressedSize(rest.data(), rest.size());
    if (ZSTD_isError(size)) refuse(place_, "the compressed data is not a whole zstd frame");
    const unsigned long long content = ZSTD_getFrameContentSize(rest.data(), rest.size());
    if (content != expected) {
      refuse(place_, "a zstd frame of " + number(content) + " raw bytes; expected " +
                         number(expected) + " with " + number(left) + " of " +
                         number(entry_.raw_bytes) + " left");
    }
    frames_.push_back(rest.first(size));
    rest = rest.subspan(size);
    left -= expected;
  }
  if (!rest.empty()) refuse(place_, number(rest.size()) + " bytes after the last zstd frame");
  if (entry_.codec == Codec::shuffled_zstd && entry_.raw_bytes % 4 != 0) {
    refuse(place_, number(entry_.raw_bytes) + " raw bytes are not a whole number of words");
  }
}

/// Fills `to` with the raw bytes of a frame, which has as many.
void ChunkReader::decode_frame(Bytes frame, std::span<std::byte> to) const {
  const bool shuffled = entry_.codec == Codec::shuffled_zstd;
  std::vector<std::byte> words(shuffled ? to.size() : 0);
  const std::span<std::byte> raw = shuffled ? words : to;
  const std::size_t got = ZSTD_decompress(raw.data(), raw.size(), frame.data(), frame.size());
  if (ZSTD_isError(got) || got != raw.size()) {
    refuse(place_, "the compressed data cannot be decoded");
  }
  if (shuffled) unshuffle(words, to);
}

/// Decodes the frames that `to` holds whole, several at once; returns their raw bytes.
std::size_t ChunkReader::decode_whole_frames(std::span<std::byte> to) {
  const std::size_t whole = to.size() / kFrameBytes;
  parallel_for(0, whole, [&](std::size_t i) {
    decode_frame(frames_[next_frame_ + i], to.subspan(i * kFrameBytes, kFrameBytes));
  });
  next_frame_ += whole;
  return whole * kFrameBytes;
}

/// The next frame, for reads that begin or end within it.
void ChunkReader::decode_next_frame() {
  buffer_.resize(std::size_t(std::min<std::uint64_t>(left_, kFrameBytes)));
  decode_frame(frames_[next_frame_++], buffer_);
  frame_ = buffer_;
}

void ChunkReader::require(std::uint64_t size) const {
  if (size <= left_) return;
  refuse(place_,
         "ends early: " + number(left_) + " bytes are left where " + number(size) + " are needed");
}

std::optional<ChunkReader::InPlace> ChunkReader::take_in_place(std::uint64_t size) {
  require(size);
  if (entry_.codec != Codec::raw || owner_ == nullptr) return std::nullopt;
  const InPlace next{frame_.first(size), owner_};
  frame_ = frame_.subspan(size);
  left_ -= size;
  return next;
}

void ChunkReader::read(std::span<std::byte> to) {
  require(to.size());
  while (!to.empty()) {
    std::size_t n = frame_.empty() ? decode_whole_frames(to) : 0;
    if (n == 0) {
      if (frame_.empty()) decode_next_frame();
      n = std::min(to.size(), frame_.size());
      std::memcpy(to.data(), frame_.data(), n);
      frame_ = frame_.subspan(n);
    }
    to = to.subspan(n);
    left_ -= n;
  }
}

struct ChunkWriter::State {
  std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> hash{XXH3_createState(), XXH3_freeState};
  std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> zstd{ZSTD_createCCtx(), ZSTD_freeCCtx};
  std::vector<std::byte> shuffled, packed;
};

ChunkWriter::ChunkWriter(std::ostream& out, Id id, Codec codec, std::uint64_t offset)
    : state_(std::make_unique<State>()), out_(out) {
  entry_.id = id;
  entry_.codec = codec;
  entry_.offset = offset;
  XXH3_64bits_reset(state_->hash.get());
}

ChunkWriter::~ChunkWriter() = default;

void ChunkWriter::write(Bytes raw) {
  entry_.raw_bytes += raw.size();
  if (entry_.codec == Codec::raw) {
    store(raw);
    return;
  }
  while (!raw.empty()) {
    const std::size_t n = std::min(raw.size(), kFrameBytes - buffer_.size());
    buffer_.insert(buffer_.end(), raw.begin(), raw.begin() + std::ptrdiff_t(n));
    raw = raw.subspan(n);
    if (buffer_.size() == kFrameBytes) write_frame();
  }
}

void ChunkWriter::write_frame() {
  const bool shuffled = entry_.codec == Codec::shuffled_zstd;
  if (shuffled) {
    state_->shuffled.resize(buffer_.size());
    shuffle(buffer_, state_->shuffled.data());
  }
  const std::vector<std::byte>& raw = shuffled ? state_->shuffled : buffer_;
  state_->packed.resize(ZSTD_compressBound(raw.size()));
  const std::size_t size =
      ZSTD_compressCCtx(state_->zstd.get(), state_->packed.data(), state_->packed.size(),
                        raw.data(), raw.size(), shuffled ? kDensityLevel : kBoundsLevel);
  if (ZSTD_isError(size))
    throw Error(std::string("zstd cannot compress: ") + ZSTD_getErrorName(size));
  store(Bytes(state_->packed).first(size));
  buffer_.clear();
}

void ChunkWriter::store(Bytes bytes) {
  XXH3_64bits_update(state_->hash.get(), bytes.data(), bytes.size());
  out_.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  entry_.stored_bytes += bytes.size();
}

std::uint64_t compressed_bytes(Bytes raw) {
  std::ostringstream nowhere;
  ChunkWriter chunk(nowhere, {}, Codec::zstd, 0);
  chunk.write(raw);
  return chunk.finish().stored_bytes;
}

ChunkEntry ChunkWriter::finish() {
  if (!buffer_.empty()) write_frame();
  entry_.checksum = XXH3_64bits_digest(state_->hash.get());
  return entry_;
}

}  // namespace pvol::formats::detail
