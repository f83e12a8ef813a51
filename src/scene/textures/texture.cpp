// Chooses the codec of an image by its first bytes, and shares the pixels of textures decoded from the same bytes.
#include "scene/textures/texture.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <string_view>
#include <tuple>

#include "base/error.h"
#include "base/fork.h"
#include "base/hash.h"
#include "base/huge_pages.h"
#include "scene/textures/codecs.h"

namespace latelight::scene {
namespace {

bool startsWith(std::span<const std::byte> bytes, std::string_view magic, size_t at = 0) {
  return bytes.size() >= at + magic.size() && std::memcmp(bytes.data() + at, magic.data(), magic.size()) == 0;
}

// TGA has no magic number, so its header must be plausible (Truevision TGA 2.0, field 3: image type, field 5.5: depth).
bool looksLikeTga(std::span<const std::byte> bytes) {
  if (bytes.size() < 18) return false;
  int colorMap = int(bytes[1]), type = int(bytes[2]), depth = int(bytes[16]);
  bool knownType = (colorMap == 1 && (type == 1 || type == 9)) ||
                   (colorMap == 0 && (type == 2 || type == 3 || type == 10 || type == 11));
  return knownType && (depth == 8 || depth == 15 || depth == 16 || depth == 24 || depth == 32);
}

const Codec& chooseCodec(std::span<const std::byte> encoded, const std::string& name) {
  using namespace std::string_view_literals;
  if (startsWith(encoded, "\xff\xd8\xff"sv)) return kJpegCodec;
  if (startsWith(encoded, "\x89PNG\r\n\x1a\n"sv)) return kPngCodec;
  if (startsWith(encoded, "ftypavif"sv, 4) || startsWith(encoded, "ftypavis"sv, 4)) return kAvifCodec;
  if (startsWith(encoded, "RIFF"sv) && startsWith(encoded, "WEBP"sv, 8)) return kWebpCodec;
  if (startsWith(encoded, "GIF8"sv) || startsWith(encoded, "BM"sv) || looksLikeTga(encoded)) return kStbCodec;
  if (startsWith(encoded, "\xabKTX 20\xbb\r\n\x1a\n"sv)) return kKtx2Codec;
  if (startsWith(encoded, "\xabKTX 11"sv))
    badInput("{} is a KTX 1 texture, which glTF does not support: convert it to KTX 2, PNG, JPEG or WebP", name);
  badInput("{} is not a JPEG, PNG, WebP, KTX2, AVIF, BMP, TGA or GIF image", name);
}

// Returns the number of levels that it has filled.
uint32_t decodeLevels(const Codec& codec, std::span<const std::byte> encoded, Texture& texture) {
  if (codec.decodeLevels) return codec.decodeLevels(encoded, texture);
  codec.decode(encoded, texture.name, {texture.width, texture.height}, texture.pixels.get());
  return 1;
}

ImageSize checkedSize(const Codec& codec, std::span<const std::byte> encoded, const std::string& name) {
  ImageSize size = codec.size(encoded, name);
  if (size.width == 0 || size.height == 0) badInput("{} has no pixels", name);
  if (size.width > kMaxTextureSide || size.height > kMaxTextureSide)
    badInput("{} is {}x{} pixels; width and height are limited to {}: scale it down", name, size.width, size.height,
             kMaxTextureSide);
  return size;
}

// The pixels of all live textures, indexed by their encoded source.
class SharedPixels {
 public:
  using Key = std::tuple<uint64_t, size_t, bool>;  // hash and size of the encoded bytes, and the sRGB flag

  std::shared_ptr<std::byte[]> find(const Key& key) {
    const std::lock_guard lock(mutex_);
    const auto found = all_.find(key);
    return found == all_.end() ? nullptr : found->second.lock();
  }
  void add(const Key& key, const std::shared_ptr<std::byte[]>& pixels) {
    const std::lock_guard lock(mutex_);
    std::erase_if(all_, [](const auto& entry) { return entry.second.expired(); });
    all_[key] = pixels;
  }

 private:
  ForkSafeMutex mutex_;
  std::map<Key, std::weak_ptr<std::byte[]>> all_;
};

}  // namespace

ImageSize imageSize(std::span<const std::byte> encoded, const std::string& name) {
  return checkedSize(chooseCodec(encoded, name), encoded, name);
}

Texture makeTexture(ImageSize size, bool srgb, const std::string& name) {
  Texture texture{.name = name,
                  .width = size.width,
                  .height = size.height,
                  .levels = mipLevelCount(size),
                  .srgb = srgb,
                  .pixels = std::make_shared_for_overwrite<std::byte[]>(mipChainBytes(size))};
  // Textures are written once, sequentially. With pages of 4 KiB, the page faults would cost more than generating the
  // mip levels.
  adviseHugePages(texture.pixels.get(), mipChainBytes(size));
  return texture;
}

Texture decodeTexture(std::span<const std::byte> encoded, bool srgb, const std::string& name) {
  static SharedPixels shared;
  const Codec& codec = chooseCodec(encoded, name);
  ImageSize size = checkedSize(codec, encoded, name);
  const SharedPixels::Key key{hash64(encoded.data(), encoded.size()), encoded.size(), srgb};
  if (std::shared_ptr<std::byte[]> pixels = shared.find(key))
    return {name, size.width, size.height, mipLevelCount(size), srgb, std::move(pixels)};
  Texture texture = makeTexture(size, srgb, name);
  if (decodeLevels(codec, encoded, texture) < texture.levels) buildMips(texture);
  shared.add(key, texture.pixels);
  return texture;
}

}  // namespace latelight::scene
