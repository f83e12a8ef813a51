// Loads environments from files, the built-in studio or programs, and caches their prefiltered maps.
#include "scene/environment/environment.h"

#include <optional>

#include "base/error.h"
#include "base/files.h"
#include "base/hash.h"
#include "base/log.h"
#include "scene/environment/environment_cache.h"
#include "scene/environment/filter.h"
#include "scene/environment/picture.h"
#include "scene/environment/picture_io.h"

namespace latelight::scene {
namespace {

constexpr uint32_t kStudioHeight = 256;

template <typename Make>
Environment cached(uint64_t key, Make make) {
  if (std::optional<Environment> environment = restoreEnvironment(key)) return std::move(*environment);
  Environment environment = make();
  storeEnvironment(key, environment);
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
