#include "scene/environment.h"

#include <array>
#include <cstring>
#include <optional>
#include <span>

#include "base/error.h"
#include "base/files.h"
#include "base/hash.h"
#include "base/log.h"
#include "scene/environment_filter.h"
#include "scene/environment_picture.h"
#include "scene/picture_io.h"

namespace latelight::scene {
namespace {

// Incremented whenever the same source gives different bytes, through a new filter or a new studio.
constexpr uint32_t kFileVersion = 2;
constexpr uint32_t kMagic = 0x564e454c;  // "LENV"
constexpr size_t kMostImages = 16;
constexpr uint32_t kStudioHeight = 256;

// --- the cache: a header, then every image's halves
// -------------------------------------------------------------------

struct CacheHeader {
  uint32_t magic = kMagic, version = kFileVersion;
  uint64_t key = 0;
  uint32_t imageCount = 0, unused = 0;  // radiance, diffuse, specular levels
  struct Size {
    uint32_t width = 0, height = 0;
  } sizes[kMostImages];
};

std::string cacheName(uint64_t key) {
  return fmt::format("environment-{:016x}-{}.bin", key, kFileVersion);
}

// The images in cache order. Works on const and mutable environments.
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
  for (const HalfImage* image : imagesOf(environment)) {
    header.sizes[header.imageCount++] = {image->width, image->height};
    bytes += image->pixels.size() * sizeof(uint16_t);
  }
  std::vector<std::byte> entry(bytes);
  std::memcpy(entry.data(), &header, sizeof(header));
  std::byte* to = entry.data() + sizeof(header);
  for (const HalfImage* image : imagesOf(environment)) {
    std::memcpy(to, image->pixels.data(), image->pixels.size() * sizeof(uint16_t));
    to += image->pixels.size() * sizeof(uint16_t);
  }
  storeCache(cacheName(key), entry);
}

// Nothing unless the entry has exactly the layout that this version stores for this key.
std::optional<CacheHeader> validHeader(std::span<const std::byte> entry, uint64_t key) {
  CacheHeader header;
  if (entry.size() < sizeof(header)) return std::nullopt;
  std::memcpy(&header, entry.data(), sizeof(header));
  if (header.magic != kMagic || header.version != kFileVersion || header.key != key) return std::nullopt;
  if (header.imageCount < 4 || header.imageCount > kMostImages) return std::nullopt;
  uint64_t bytes = sizeof(header);
  for (uint32_t i = 0; i < header.imageCount; ++i) {
    const auto [width, height] = header.sizes[i];
    if (width == 0 || height == 0 || width > kMostPicturePixels || height > kMostPicturePixels) return std::nullopt;
    bytes += uint64_t{4} * sizeof(uint16_t) * width * height;
    if (bytes > entry.size()) return std::nullopt;
  }
  return bytes == entry.size() ? std::optional(header) : std::nullopt;
}

std::optional<Environment> restore(uint64_t key) {
  const std::optional<std::vector<std::byte>> entry = loadCache(cacheName(key));
  if (!entry) return std::nullopt;
  const std::optional<CacheHeader> header = validHeader(*entry, key);
  if (!header) return std::nullopt;
  Environment environment;
  environment.specular.resize(header->imageCount - 2);
  const std::byte* from = entry->data() + sizeof(CacheHeader);
  const CacheHeader::Size* size = header->sizes;
  for (HalfImage* image : imagesOf(environment)) {
    image->width = size->width;
    image->height = size->height;
    const size_t count = size_t{4} * size->width * size->height;
    const auto* halves = reinterpret_cast<const uint16_t*>(from);  // the header keeps them aligned
    image->pixels.assign(halves, halves + count);
    from += count * sizeof(uint16_t);
    ++size;
  }
  return environment;
}
static_assert(sizeof(CacheHeader) % alignof(uint16_t) == 0);

// --- sources
// ----------------------------------------------------------------------------------------------------------

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
