// Recognizes the format of high dynamic range images, and checks their size.
#include "scene/environment/picture_io.h"

#include <algorithm>
#include <new>

#include "base/error.h"
#include "base/files.h"
#include "base/memory.h"

namespace latelight::scene {
namespace {

bool startsWith(std::span<const std::byte> bytes, std::initializer_list<unsigned char> magic) {
  return bytes.size() >= magic.size() &&
         std::equal(magic.begin(), magic.end(), bytes.begin(),
                    [](unsigned char a, std::byte b) { return a == std::to_integer<unsigned char>(b); });
}

}  // namespace

FloatImage decodePicture(std::span<const std::byte> bytes, const std::string& name) try {
  if (startsWith(bytes, {'#', '?'})) return decodeRadiance(bytes, name);
  if (startsWith(bytes, {0x76, 0x2f, 0x31, 0x01})) return decodeExr(bytes, name);
  badInput("'{}' is neither a Radiance .hdr nor an OpenEXR .exr image; use one of these", name);
} catch (const std::bad_alloc&) {
  failWithoutMemory(fmt::format("'{}'", name));
}

void checkPictureSize(int64_t width, int64_t height, const std::string& name) {
  constexpr auto kMax = static_cast<int64_t>(kMaxPicturePixels);
  if (width > kLongestPictureSide || height > kLongestPictureSide || width * height > kMax) {
    badInput("'{}' claims {} x {} pixels: at most {} million, and {} along a side, can be read; make it smaller", name,
             width, height, kMax / 1000000, kLongestPictureSide);
  }
  // Checks the memory limit here, so that the error names the file. The image claims its memory itself.
  const MemoryClaim fits(sizeof(float) * 4 * static_cast<uint64_t>(width * height), fmt::format("'{}'", name));
}

FloatImage readPicture(const std::filesystem::path& path) {
  return decodePicture(readFile(path), path.string());
}

}  // namespace latelight::scene
