// A block of deflate has three steps. Its bytes are divided into segments, which are literals followed by a run, a
// stretch that repeats the pixel before it. The literals, and the matches that runs consist of, are counted, and
// receive Huffman codes. The segments are then written with these codes (RFC 1951, section 3.2.7).
#include "output/deflate.h"

#include <isa-l/igzip_lib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstring>

#include "output/huffman.h"

namespace latelight::output {
namespace {

constexpr size_t kWord = 8;  // bytes compared at a time, and the length of the shortest runs
constexpr size_t kMaxMatch = 258, kMinMatch = 3;
constexpr size_t kEndOfBlock = 256, kLengthSymbols = 29, kSymbols = kEndOfBlock + 1 + kLengthSymbols;
using Codes = std::array<HuffmanCode, kSymbols>;

// A length or distance: its symbol, and the bits that follow it.
struct Extended {
  uint16_t symbol = 0;
  uint16_t extraBits = 0;
  uint16_t extra = 0;
};

// RFC 1951, section 3.2.5. Values are in groups that double in size, with a symbol per `perDoubling`-th of a group.
constexpr Extended extended(uint32_t offset, uint32_t perDoublingLog2) {
  const uint32_t perDoubling = 1u << perDoublingLog2;
  if (offset < 2 * perDoubling) return {static_cast<uint16_t>(offset), 0, 0};
  const uint32_t extraBits = std::bit_width(offset) - 1 - perDoublingLog2;
  const uint32_t symbol = extraBits * perDoubling + (offset >> extraBits);
  return {static_cast<uint16_t>(symbol), static_cast<uint16_t>(extraBits),
          static_cast<uint16_t>(offset & ((1u << extraBits) - 1))};
}

constexpr std::array<Extended, kMaxMatch + 1> kLengths = [] {
  std::array<Extended, kMaxMatch + 1> lengths;
  for (uint32_t length = kMinMatch; length < kMaxMatch; ++length) {
    lengths[length] = extended(length - kMinMatch, 2);
    lengths[length].symbol += kEndOfBlock + 1;
  }
  lengths[kMaxMatch] = {kSymbols - 1, 0, 0};
  return lengths;
}();
static_assert(kLengths[257].symbol == 284 && kLengths[257].extra == 30 && kLengths[11].symbol == 265);
static_assert(extended(4, 1).symbol == 4 && extended(4, 1).extraBits == 1 && extended(32767, 1).symbol == 29);

// Returns the length of the next match of a run with `run` bytes left, so that no rest is shorter than a match.
size_t nextMatch(size_t run) {
  if (run <= kMaxMatch) return run;
  return run - kMaxMatch >= kMinMatch ? kMaxMatch : kMaxMatch - kMinMatch;
}

struct Segment {
  uint32_t literals = 0, run = 0;
};

const uint8_t* bytesOf(std::span<const std::byte> bytes) {
  return reinterpret_cast<const uint8_t*>(bytes.data());
}

// Returns the bits by which 8 bytes differ from those a pixel before.
uint64_t difference(const uint8_t* bytes, size_t pixelBytes) {
  uint64_t word, before;
  std::memcpy(&word, bytes, kWord);
  std::memcpy(&before, bytes - pixelBytes, kWord);
  if constexpr (std::endian::native == std::endian::big) return __builtin_bswap64(word ^ before);
  return word ^ before;
}

// Returns the end of the run that begins at or before `at`.
size_t endOfRun(const uint8_t* bytes, size_t size, size_t pixelBytes, size_t at) {
  const auto bitsAt = [&](size_t i) { return difference(bytes + i, pixelBytes); };
  while (at + 4 * kWord <= size &&
         (bitsAt(at) | bitsAt(at + kWord) | bitsAt(at + 2 * kWord) | bitsAt(at + 3 * kWord)) == 0)
    at += 4 * kWord;
  for (; at + kWord <= size; at += kWord)
    if (const uint64_t bits = bitsAt(at)) return at + std::countr_zero(bits) / 8;
  return at;
}

// Finds runs where a whole word repeats, and extends them byte by byte in both directions.
std::vector<Segment> divide(const uint8_t* bytes, size_t size, size_t pixelBytes) {
  std::vector<Segment> segments;
  size_t literals = 0;  // begin of the segment
  for (size_t at = pixelBytes; at + kWord <= size;) {
    if (difference(bytes + at, pixelBytes) != 0) {
      at += kWord;
      continue;
    }
    const size_t end = endOfRun(bytes, size, pixelBytes, at + kWord);
    if (at >= literals + kWord && at >= pixelBytes + kWord)
      at -= std::countl_zero(difference(bytes + at - kWord, pixelBytes)) / 8;
    segments.push_back({static_cast<uint32_t>(at - literals), static_cast<uint32_t>(end - at)});
    literals = at = end;
  }
  segments.push_back({static_cast<uint32_t>(size - literals), 0});
  return segments;
}

// Counts in four tables, because equal bytes in a row would wait for each other's count.
std::array<uint32_t, kSymbols> count(const uint8_t* bytes, const std::vector<Segment>& segments) {
  std::array<std::array<uint32_t, 256>, 4> tables{};
  std::array<uint32_t, kSymbols> counts{};
  for (const Segment& segment : segments) {
    uint32_t i = 0;
    for (; i + kWord <= segment.literals; i += kWord) {
      uint64_t word;
      std::memcpy(&word, bytes + i, kWord);
      for (uint32_t k = 0; k < kWord; ++k) ++tables[k % 4][word >> 8 * k & 255];
    }
    for (; i < segment.literals; ++i) ++tables[0][bytes[i]];
    bytes += segment.literals + segment.run;
    for (size_t run = segment.run; run > 0; run -= nextMatch(run)) ++counts[kLengths[nextMatch(run)].symbol];
  }
  for (size_t i = 0; i < 256; ++i) counts[i] = tables[0][i] + tables[1][i] + tables[2][i] + tables[3][i];
  counts[kEndOfBlock] = 1;
  return counts;
}

// Writes bits to memory that suffices. The first bit is the lowest one of the first byte.
struct BitWriter {
  std::byte* out;
  uint64_t bits;
  uint32_t count;

  void put(uint64_t value, uint32_t valueBits) {
    bits |= value << count;
    count += valueBits;
  }
  void put(HuffmanCode code) { put(code.code, code.bits); }
  // Must follow at most 56 bits. Writes whole words, and keeps the bits that do not fill a byte.
  void flush() {
    if constexpr (std::endian::native == std::endian::big) {
      const uint64_t swapped = __builtin_bswap64(bits);
      std::memcpy(out, &swapped, kWord);
    } else {
      std::memcpy(out, &bits, kWord);
    }
    out += count / 8;
    bits >>= count & ~7u;
    count &= 7;
  }
};

// The code lengths are written in a code of 16 symbols with 4 bits each: lengths of up to 12 bits, and repeats.
constexpr uint32_t kRepeatLength = 16, kRepeatZero = 17, kRepeatZeroLong = 18;

void putLength(BitWriter& writer, uint32_t symbol) {
  static_assert(kMaxCodeBits == 12);
  const uint32_t code = symbol <= kMaxCodeBits ? symbol : symbol - 3;
  writer.put((code & 1) << 3 | (code & 2) << 1 | (code & 4) >> 1 | code >> 3, 4);
}

void putLengths(BitWriter& writer, std::span<const uint16_t> lengths) {
  for (size_t i = 0; i < lengths.size(); writer.flush()) {
    size_t same = 1;
    while (i + same < lengths.size() && lengths[i + same] == lengths[i]) ++same;
    if (lengths[i] == 0 && same >= 3) {
      same = std::min<size_t>(same, 138);
      putLength(writer, same < 11 ? kRepeatZero : kRepeatZeroLong);
      writer.put(same < 11 ? same - 3 : same - 11, same < 11 ? 3 : 7);
    } else {
      putLength(writer, lengths[i]);
      same = same >= 4 ? std::min<size_t>(same, 7) : 1;
      if (same > 1) putLength(writer, kRepeatLength);
      if (same > 1) writer.put(same - 4, 2);
    }
    i += same;
  }
}

// Writes the header of a block. `distance` is the only symbol of distances, with a code of one bit.
void putHeader(BitWriter& writer, const Codes& codes, uint32_t distance, bool last) {
  constexpr uint32_t kDynamicCodes = 2;
  constexpr uint8_t kOrder[] = {16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1};
  writer.put(last, 1);
  writer.put(kDynamicCodes, 2);
  writer.put(kSymbols - 257, 5);
  writer.put(distance, 5);
  writer.put(std::size(kOrder) - 4, 4);
  for (const uint8_t symbol : kOrder) {
    writer.put(symbol == 13 || symbol == 14 ? 0 : 4, 3);
    writer.flush();
  }
  std::vector<uint16_t> lengths;
  for (const HuffmanCode& code : codes) lengths.push_back(code.bits);
  lengths.resize(lengths.size() + distance);
  lengths.push_back(1);
  putLengths(writer, lengths);
}

[[gnu::always_inline]] inline void putEachLiteral(BitWriter& writer, const Codes& codes, const uint8_t* bytes,
                                                  size_t size) {
  BitWriter local = writer;  // in registers
  size_t i = 0;
  for (; i + 4 <= size; i += 4) {
    const HuffmanCode a = codes[bytes[i]], b = codes[bytes[i + 1]], c = codes[bytes[i + 2]], d = codes[bytes[i + 3]];
    const uint64_t first = a.code | uint64_t{b.code} << a.bits, second = c.code | uint64_t{d.code} << c.bits;
    local.put(first | second << (a.bits + b.bits), a.bits + b.bits + c.bits + d.bits);
    local.flush();
  }
  for (; i < size; ++i) {
    local.put(codes[bytes[i]]);
    local.flush();
  }
  writer = local;
}

void putLiterals(BitWriter& writer, const Codes& codes, const uint8_t* bytes, size_t size) {
  putEachLiteral(writer, codes, bytes, size);
}

#ifdef __x86_64__
// The same for processors that shift by any register in one operation.
[[gnu::target("bmi2")]] void putLiteralsBmi2(BitWriter& writer, const Codes& codes, const uint8_t* bytes, size_t size) {
  putEachLiteral(writer, codes, bytes, size);
}
#endif

using PutLiterals = void (*)(BitWriter& writer, const Codes& codes, const uint8_t* bytes, size_t size);

PutLiterals putLiteralsOfProcessor() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("bmi2")) return putLiteralsBmi2;
#endif
  return putLiterals;
}

void putRun(BitWriter& writer, const Codes& codes, const Extended& distance, size_t run) {
  for (; run > 0; run -= nextMatch(run)) {
    const Extended& length = kLengths[nextMatch(run)];
    writer.put(codes[length.symbol]);
    writer.put(length.extra, length.extraBits);
    writer.put(0, 1);
    writer.put(distance.extra, distance.extraBits);
    writer.flush();
  }
}

// The maximum size of a block: its longest codes, its header, and the word after the end that flush() may write.
size_t capacityOf(size_t bytes) {
  constexpr size_t kHeader = 512;
  return bytes * kMaxCodeBits / 8 + kHeader + kWord;
}

}  // namespace

void Deflater::add(std::span<const std::byte> bytes, bool last) {
  assert(bytes.size() < size_t{1} << 32 && pixelBytes_ >= 1 && pixelBytes_ <= 32768);
  const std::vector<Segment> segments = divide(bytesOf(bytes), bytes.size(), pixelBytes_);
  Codes codes;
  makeHuffmanCodes(count(bytesOf(bytes), segments), codes);
  if (blockCapacity_ < capacityOf(bytes.size())) {
    blockCapacity_ = capacityOf(bytes.size());
    block_ = std::make_unique_for_overwrite<std::byte[]>(blockCapacity_);
  }
  BitWriter writer{block_.get(), bits_, bitCount_};
  const Extended distance = extended(static_cast<uint32_t>(pixelBytes_ - 1), 1);
  putHeader(writer, codes, distance.symbol, last);
  const uint8_t* at = bytesOf(bytes);
  static const PutLiterals put = putLiteralsOfProcessor();
  for (const Segment& segment : segments) {
    put(writer, codes, at, segment.literals);
    putRun(writer, codes, distance, segment.run);
    at += segment.literals + segment.run;
  }
  writer.put(codes[kEndOfBlock]);
  writer.flush();
  output_.insert(output_.end(), block_.get(), writer.out);
  bits_ = writer.bits;
  bitCount_ = writer.count;
  if (last && bitCount_ > 0) {
    output_.push_back(static_cast<std::byte>(bits_));
    bitCount_ = 0;
  }
}

void Deflater::alignToByte() {
  constexpr std::byte kLengthZero[] = {std::byte{0}, std::byte{0}, std::byte{0xff}, std::byte{0xff}};
  constexpr uint32_t kStoredHeader = 3;  // bits, all zero: a stored block, which begins at the next byte
  output_.push_back(static_cast<std::byte>(bits_));
  if (bitCount_ + kStoredHeader > 8) output_.push_back(std::byte{0});
  output_.insert(output_.end(), std::begin(kLengthZero), std::end(kLengthZero));
  bits_ = 0;
  bitCount_ = 0;
}

std::vector<std::byte> deflateZlib(std::span<const std::byte> bytes, size_t pixelBytes) {
  constexpr std::byte kHeader[] = {std::byte{0x78}, std::byte{0x01}};  // 32 KiB window, fastest level
  Deflater deflater(pixelBytes);
  deflater.output().assign(std::begin(kHeader), std::end(kHeader));
  const size_t blockBytes = std::max<size_t>(1, Deflater::kBlockBytes / pixelBytes) * pixelBytes;
  for (size_t at = 0; at == 0 || at < bytes.size(); at += blockBytes) {
    const std::span<const std::byte> block = bytes.subspan(at, std::min(blockBytes, bytes.size() - at));
    deflater.add(block, at + block.size() == bytes.size());
  }
  const uint32_t checksum = isal_adler32(1, bytesOf(bytes), bytes.size());
  for (int shift = 24; shift >= 0; shift -= 8) deflater.output().push_back(static_cast<std::byte>(checksum >> shift));
  return std::move(deflater.output());
}

}  // namespace latelight::output
