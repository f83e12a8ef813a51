// The cache of prefiltered environments: an entry is a header, then the texels of every map.
#include "scene/environment/environment_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <vector>

#include "base/files.h"

namespace latelight::scene {
namespace {

// Must be incremented whenever the same source produces different bytes, because of a changed filter or studio.
constexpr uint32_t kFileVersion = 3;
constexpr uint32_t kMagic = 0x564e454c;                    // "LENV"
constexpr size_t kImages = 2 + kSpecularRoughness.size();  // radiance, diffuse, specular levels
constexpr size_t kSpecular = 2;                            // index of the first specular level
constexpr size_t kMaxImages = 16;
static_assert(kImages <= kMaxImages);

struct CacheHeader {
  uint32_t magic = kMagic, version = kFileVersion;
  uint64_t key = 0;
  uint32_t imageCount = 0, unused = 0;
  struct Entry {
    uint32_t width = 0, height = 0, isFloat = 0;
  } entries[kMaxImages];
};

// Returns the images in cache order, for const and mutable environments.
template <typename E>
auto imagesOf(E& environment) {
  std::vector<decltype(&environment.radiance)> images{&environment.radiance, &environment.diffuse};
  for (auto& level : environment.specular) images.push_back(&level);
  return images;
}

// Returns nullopt unless the entry has exactly the layout that this version stores for this key.
std::optional<CacheHeader> validHeader(std::span<const std::byte> entry, uint64_t key) {
  CacheHeader header;
  if (entry.size() < sizeof(header)) return std::nullopt;
  std::memcpy(&header, entry.data(), sizeof(header));
  if (header.magic != kMagic || header.version != kFileVersion || header.key != key) return std::nullopt;
  if (header.imageCount != kImages) return std::nullopt;
  uint64_t bytes = sizeof(header);
  for (size_t i = 0; i < kImages; ++i) {
    const auto [width, height, isFloat] = header.entries[i];
    if (width == 0 || height == 0 || width > kMaxPicturePixels || height > kMaxPicturePixels) return std::nullopt;
    if (isFloat > 1 || (i > kSpecular && isFloat != header.entries[kSpecular].isFloat)) return std::nullopt;
    if (i > kSpecular && (2 * width != header.entries[i - 1].width || height != width)) return std::nullopt;
    bytes += RadianceMap{.isFloat = isFloat == 1, .texels = {}}.texelBytes() * width * height;
    if (bytes > entry.size()) return std::nullopt;
  }
  return bytes == entry.size() ? std::optional(header) : std::nullopt;
}

}  // namespace

std::string environmentCacheName(uint64_t key) {
  return fmt::format("environment-{:016x}-{}.bin", key, kFileVersion);
}

void storeEnvironment(uint64_t key, const Environment& environment) {
  CacheHeader header;
  header.key = key;
  size_t bytes = sizeof(header);
  for (const RadianceMap* map : imagesOf(environment)) {
    header.entries[header.imageCount++] = {map->width, map->height, map->isFloat};
    bytes += map->texels.size();
  }
  std::vector<std::byte> entry(bytes);
  std::memcpy(entry.data(), &header, sizeof(header));
  std::byte* to = entry.data() + sizeof(header);
  for (const RadianceMap* map : imagesOf(environment)) to = std::ranges::copy(map->texels, to).out;
  storeCache(environmentCacheName(key), entry);
}

std::optional<Environment> restoreEnvironment(uint64_t key) {
  const std::optional<std::vector<std::byte>> bytes = loadCache(environmentCacheName(key));
  if (!bytes) return std::nullopt;
  const std::optional<CacheHeader> header = validHeader(*bytes, key);
  if (!header) return std::nullopt;
  Environment environment;
  environment.specular.resize(kSpecularRoughness.size());
  const std::byte* from = bytes->data() + sizeof(CacheHeader);
  const CacheHeader::Entry* entry = header->entries;
  for (RadianceMap* map : imagesOf(environment)) {
    *map = {entry->width, entry->height, entry->isFloat == 1, {}};
    const size_t size = map->texelBytes() * map->width * map->height;
    map->texels.assign(from, from + size);
    from += size;
    ++entry;
  }
  return environment;
}

}  // namespace latelight::scene
