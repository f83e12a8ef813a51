#include "output/read.h"

#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "base/files.h"
#include "output/decode.h"
#include "output/exr.h"
#include "output/npy.h"
#include "output/png.h"

namespace latelight::output {
namespace {

bool startsWith(std::span<const std::byte> bytes, std::string_view magic) {
  return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

}  // namespace

const Channel* ReadImage::find(std::string_view name) const {
  const auto found = std::find_if(channels.begin(), channels.end(), [&](const Channel& c) { return c.name == name; });
  return found == channels.end() ? nullptr : &*found;
}

std::vector<std::string> usualChannels(uint64_t count) {
  switch (count) {
    case 1:
      return {"Y"};
    case 2:
      return {"Y", "A"};
    case 3:
      return {"R", "G", "B"};
    case 4:
      return {"R", "G", "B", "A"};
    default:
      break;
  }
  std::vector<std::string> names;
  for (uint64_t i = 0; i < count; ++i) names.push_back(std::to_string(i));
  return names;
}

ReadImage makeReadImage(uint64_t width, uint64_t height, const std::vector<std::string>& names, ChannelType type,
                        const std::filesystem::path& path) {
  const double bytes = static_cast<double>(width) * static_cast<double>(height) * static_cast<double>(names.size()) * 8;
  const double memory = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  // Half of the limit, because two images are compared.
  if (bytes > memory / 2) {
    badInput("'{}' declares {}x{} pixels with {} channels, more than the memory of this machine; use a smaller one",
             path.string(), width, height, names.size());
  }
  ReadImage image{static_cast<uint32_t>(width), static_cast<uint32_t>(height), {}};
  for (const std::string& name : names) image.channels.push_back({name, type, std::vector<double>(width * height)});
  return image;
}

ReadImage readImage(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = readFile(path);
  if (startsWith(bytes, "\x89PNG")) return decodePng(bytes, path);
  if (startsWith(bytes, "\x76\x2f\x31\x01")) return decodeExr(bytes, path);
  if (startsWith(bytes, "\x93NUMPY")) return decodeNpy(bytes, path);
  badInput("'{}' is not a PNG, OpenEXR or NPY file; give one of these", path.string());
}

}  // namespace latelight::output
