// KTX 2.0 files (Khronos, 2020) as KHR_texture_basisu restricts them: two-dimensional images in ETC1S, which BasisLZ
// compresses, and in UASTC, plain or compressed by Zstandard.
#include <zstd.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string_view>

#include "base/error.h"
#include "scene/textures/bits.h"
#include "scene/textures/codecs.h"
#include "scene/textures/etc1s.h"
#include "scene/textures/uastc.h"

namespace latelight::scene {
namespace {

using Bytes = std::span<const std::byte>;

constexpr uint64_t kHeaderBytes = 80, kLevelBytes = 24, kImageBytes = 20;
constexpr uint32_t kBasisLz = 1, kZstandard = 2;          // supercompressionScheme
constexpr uint32_t kEtc1sModel = 163, kUastcModel = 166;  // KHR_DF_MODEL_*

Bytes part(Bytes file, uint64_t offset, uint64_t length) {
  if (offset > file.size() || length > file.size() - offset) throw BrokenTexture("a part of it lies beyond its end");
  return file.subspan(size_t(offset), size_t(length));
}

uint64_t numberAt(Bytes bytes, uint64_t offset, uint64_t length) {
  uint64_t value = 0;
  const Bytes number = part(bytes, offset, length);
  for (size_t i = number.size(); i-- > 0;) value = value << 8 | uint64_t(number[i]);
  return value;
}
uint32_t wordAt(Bytes bytes, uint64_t offset) {
  return uint32_t(numberAt(bytes, offset, 4));
}
uint64_t uint64At(Bytes bytes, uint64_t offset) {
  return numberAt(bytes, offset, 8);
}

struct Ktx2Header {
  explicit Ktx2Header(Bytes file)
      : format(wordAt(file, 12)),
        size{wordAt(file, 20), wordAt(file, 24)},
        depth(wordAt(file, 28)),
        layers(wordAt(file, 32)),
        faces(wordAt(file, 36)),
        levels(std::max(1u, wordAt(file, 40))),
        scheme(wordAt(file, 44)),
        descriptor(part(file, wordAt(file, 48), wordAt(file, 52))),
        metadata(part(file, wordAt(file, 56), wordAt(file, 60))),
        global(part(file, uint64At(file, 64), uint64At(file, 72))) {}

  uint32_t format;  // VkFormat
  ImageSize size;
  uint32_t depth, layers, faces, levels, scheme;
  Bytes descriptor, metadata, global;

  uint32_t model() const { return uint32_t(numberAt(descriptor, 12, 1)); }
  // The basic descriptor's second sample, if present, is alpha.
  bool hasAlphaSlice() const { return numberAt(descriptor, 10, 2) >= 24 + 2 * 16; }
};

struct Ktx2Level {
  ImageSize size;
  Bytes bytes;
  uint64_t uncompressedBytes;
};

Ktx2Level levelOf(Bytes file, const Ktx2Header& header, uint32_t index) {
  const uint64_t entry = kHeaderBytes + index * kLevelBytes;
  return {{std::max(1u, header.size.width >> index), std::max(1u, header.size.height >> index)},
          part(file, uint64At(file, entry), uint64At(file, entry + 8)),
          uint64At(file, entry + 16)};
}

// Returns a value of the file's key/value data, or nullopt if the key does not exist.
std::optional<std::string_view> findValue(Bytes metadata, std::string_view wanted) {
  for (uint64_t at = 0; at < metadata.size();) {
    const uint32_t length = wordAt(metadata, at);
    const Bytes pair = part(metadata, at + 4, length);
    const std::string_view text(reinterpret_cast<const char*>(pair.data()), pair.size());
    const size_t end = text.find('\0');
    if (end == std::string_view::npos) throw BrokenTexture("a key of its metadata does not end");
    const std::string_view value = text.substr(end + 1);
    if (text.substr(0, end) == wanted) return value.substr(0, value.find('\0'));
    at += 4 + (uint64_t{length} + 3) / 4 * 4;
  }
  return std::nullopt;
}

void checkKind(const Ktx2Header& header) {
  const bool etc1s = header.model() == kEtc1sModel && header.scheme == kBasisLz;
  const bool uastc = header.model() == kUastcModel && (header.scheme == 0 || header.scheme == kZstandard);
  if (header.format != 0 || !(etc1s || uastc))
    throw BrokenTexture("it is neither ETC1S in BasisLZ nor UASTC, plain or in Zstandard");
  if (header.depth > 0 || header.layers > 0 || header.faces != 1)
    throw BrokenTexture("it is not a single two-dimensional picture");
  if (findValue(header.metadata, "KTXorientation").value_or("rd") != "rd")
    throw BrokenTexture("its rows or columns do not run as glTF asks (KTXorientation is not rd)");
  if (findValue(header.metadata, "KTXswizzle").value_or("rgba") != "rgba")
    throw BrokenTexture("its channels are swizzled, which glTF does not allow");
}

Etc1sCodebooks readCodebooks(const Ktx2Header& header) {
  const Bytes data = header.global;
  const uint64_t start = 20 + kImageBytes * header.levels;
  const uint32_t endpoints = wordAt(data, 4), selectors = wordAt(data, 8), tables = wordAt(data, 12);
  return Etc1sCodebooks({.endpointCount = uint32_t(numberAt(data, 0, 2)),
                         .selectorCount = uint32_t(numberAt(data, 2, 2)),
                         .endpoints = part(data, start, endpoints),
                         .selectors = part(data, start + endpoints, selectors),
                         .tables = part(data, start + endpoints + selectors, tables)});
}

void decodeEtc1s(const Ktx2Header& header, const Etc1sCodebooks& codebooks, uint32_t index, const Ktx2Level& level,
                 std::byte* rgba) {
  const uint64_t image = 20 + kImageBytes * index;
  const auto slice = [&](uint64_t at) {
    return part(level.bytes, wordAt(header.global, image + at), wordAt(header.global, image + at + 4));
  };
  codebooks.decode(slice(4), level.size, Etc1sCodebooks::Channels::Color, rgba);
  if (header.hasAlphaSlice()) codebooks.decode(slice(12), level.size, Etc1sCodebooks::Channels::Alpha, rgba);
}

void decodeUastcLevel(const Ktx2Header& header, const Ktx2Level& level, bool srgb, std::byte* rgba) {
  if (header.scheme != kZstandard) return decodeUastc(level.bytes, level.size, srgb, rgba);
  const size_t wanted = size_t((level.size.width + 3) / 4) * ((level.size.height + 3) / 4) * kUastcBlockBytes;
  if (level.uncompressedBytes != wanted) throw BrokenTexture("a level has not the bytes of its size");
  const auto blocks = std::make_unique_for_overwrite<std::byte[]>(wanted);
  if (ZSTD_decompress(blocks.get(), wanted, level.bytes.data(), level.bytes.size()) != wanted)
    throw BrokenTexture("a level is broken Zstandard data");
  decodeUastc({blocks.get(), wanted}, level.size, srgb, rgba);
}

void fill(Bytes file, Texture& texture, uint32_t levels) {
  const Ktx2Header header(file);
  std::optional<Etc1sCodebooks> codebooks;
  if (header.model() == kEtc1sModel) codebooks.emplace(readCodebooks(header));
  std::byte* rgba = texture.pixels.get();
  for (uint32_t i = 0; i < levels; ++i) {
    const Ktx2Level level = levelOf(file, header, i);
    if (codebooks)
      decodeEtc1s(header, *codebooks, i, level, rgba);
    else
      decodeUastcLevel(header, level, texture.srgb, rgba);
    rgba += size_t{4} * level.size.width * level.size.height;
  }
}

// Runs `body` and adds the texture's name to its errors.
template <typename Body>
auto named(const std::string& name, Body body) {
  try {
    return body();
  } catch (const BrokenTexture& problem) {
    badInput("{} is an invalid or unsupported KTX2 texture: {}", name, problem.what());
  }
}

ImageSize sizeOfKtx2(Bytes encoded, const std::string& name) {
  return named(name, [&] {
    const Ktx2Header header(encoded);
    checkKind(header);
    return header.size;
  });
}

uint32_t decodeKtx2(Bytes encoded, Texture& texture) {
  return named(texture.name, [&] {
    const uint32_t stored = Ktx2Header(encoded).levels;
    if (stored > texture.levels) throw BrokenTexture("it has more mip levels than its size allows");
    // An incomplete mip chain is not used: the other levels are generated from level 0, as for other textures.
    const uint32_t used = stored == texture.levels ? stored : 1;
    fill(encoded, texture, used);
    return used;
  });
}

}  // namespace

const Codec kKtx2Codec{.size = sizeOfKtx2, .decodeLevels = decodeKtx2};

}  // namespace latelight::scene
