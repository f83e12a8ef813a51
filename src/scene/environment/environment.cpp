// Loads environments from files, the built-in studio or programs, and caches their prefiltered maps.
#include "scene/environment/environment.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <span>

#include "base/error.h"
#include "base/files.h"
#include "base/hash.h"
#include "base/log.h"
#include "scene/environment/filter.h"
#include "scene/environment/picture.h"
#include "scene/environment/picture_io.h"

namespace latelight::scene {
namespace {

// Must be incremented whenever the same source produces different bytes, because of a changed filter or studio.
constexpr uint32_t kFileVersion = 3;
constexpr uint32_t kMagic = 0x564e454c;  // "LENV"
constexpr size_t kMaxImages = 16;
constexpr uint32_t kStudioHeight = 256;

// --- the cache: a header, then the texels of every map --------------------------------------------------------------

struct CacheHeader {
  uint32_t magic = kMagic, version = kFileVersion;
  uint64_t key = 0;
  uint32_t imageCount = 0, unused = 0;  // radiance, diffuse, specular levels
  struct Entry {
    uint32_t width = 0, height = 0, isFloat = 0;
  } entries[kMaxImages];
};

std::string cacheName(uint64_t key) {
  return fmt::format("environment-{:016x}-{}.bin", key, kFileVersion);
}

// Returns the images in cache order, for const and mutable environments.
template <typename E>
auto imagesOf(E& environment) {
  std::vector<decltype(&environment.radiance)> images{&environment.radiance, &environment.diffuse};
  for (auto& level : environment.specular) images.push_back(&level);
  return images;
}

void store(uint64_t key, const Environment& environment) {
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
  storeCache(cacheName(key), entry);
}

// Returns nullopt unless the entry has exactly the layout that this version stores for this key.
std::optional<CacheHeader> validHeader(std::span<const std::byte> entry, uint64_t key) {
  CacheHeader header;
  if (entry.size() < sizeof(header)) return std::nullopt;
  std::memcpy(&header, entry.data(), sizeof(header));
  if (header.magic != kMagic || header.version != kFileVersion || header.key != key) return std::nullopt;
  if (header.imageCount < 4 || header.imageCount > kMaxImages) return std::nullopt;
  uint64_t bytes = sizeof(header);
  for (uint32_t i = 0; i < header.imageCount; ++i) {
    const auto [width, height, isFloat] = header.entries[i];
    if (width == 0 || height == 0 || width > kMaxPicturePixels || height > kMaxPicturePixels) return std::nullopt;
    if (isFloat > 1 || (i > 2 && isFloat != header.entries[2].isFloat)) return std::nullopt;
    bytes += RadianceMap{.isFloat = isFloat == 1, .texels = {}}.texelBytes() * width * height;
    if (bytes > entry.size()) return std::nullopt;
  }
  return bytes == entry.size() ? std::optional(header) : std::nullopt;
}

std::optional<Environment> restore(uint64_t key) {
  const std::optional<std::vector<std::byte>> bytes = loadCache(cacheName(key));
  if (!bytes) return std::nullopt;
  const std::optional<CacheHeader> header = validHeader(*bytes, key);
  if (!header) return std::nullopt;
  Environment environment;
  environment.specular.resize(header->imageCount - 2);
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

// --- sources --------------------------------------------------------------------------------------------------------

template <typename Make>
Environment cached(uint64_t key, Make make) {
  if (std::optional<Environment> environment = restore(key)) return std::move(*environment);
  Environment environment = make();
  store(key, environment);
  return environment;
}

Environment loadStudio() {
  constexpr std::string_view kKey = "built-in studio";
  return cached(hash64(kKey.data(), kKey.size()), [] { return filterEnvironment(makeStudio(kStudioHeight)); });
}

Environment loadPicture(const std::string& file) {
  const std::vector<std::byte> bytes = readFile(file);
  return cached(hash64(bytes.data(), bytes.size()), [&] {
    FloatImage picture = decodePicture(bytes, file);
    if (picture.width != 2 * picture.height) {
      warn(
          "'{}' has {} x {} pixels; an equirectangular image is twice as wide as high, so this one will look stretched",
          file, picture.width, picture.height);
    }
    return filterEnvironment(std::move(picture));
  });
}

}  // namespace

Environment loadEnvironment(const std::string& source) {
  const bool studio = source == "studio";
  Environment environment = studio ? loadStudio() : loadPicture(source);
  environment.name = studio ? source : std::filesystem::path(source).stem().string();
  return environment;
}

Environment makeEnvironment(FloatImage picture) {
  const uint64_t key = hash64(picture.pixels.data(), picture.pixels.size() * sizeof(float)) ^ picture.width;
  return cached(key, [&] { return filterEnvironment(std::move(picture)); });
}

}  // namespace latelight::scene
