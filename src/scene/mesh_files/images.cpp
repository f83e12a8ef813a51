// Reads images, and makes textures in glTF's layout from those of MTL, which has an image per quantity.
#include "scene/mesh_files/images.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/log.h"
#include "base/parallel.h"
#include "base/utf8.h"
#include "scene/textures/texture.h"
#include "shared/color.h"

namespace latelight::scene::mesh_files {
namespace {

std::span<const uint8_t> largestLevel(const Texture& image) {
  return {reinterpret_cast<const uint8_t*>(image.pixels.get()), size_t{4} * image.width * image.height};
}

bool isOpaque(const Texture& image) {
  const std::span<const uint8_t> texels = largestLevel(image);
  for (size_t i = 3; i < texels.size(); i += 4)
    if (texels[i] != 255) return false;
  return true;
}

// Returns the channel of the image from which a scalar is read.
char channelOf(const Texture& image, const ImageUse& use) {
  return use.channel != ImageUse::kOpacity ? use.channel : isOpaque(image) ? 'l' : 'm';
}

// A decoded image, sampled at the nearest texel of another size.
struct Plane {
  std::optional<Texture> image;
  const ImageUse* use = nullptr;
  char channel = 'l';

  const uint8_t* texel(ImageSize size, uint32_t x, uint32_t y) const {
    const size_t column = size_t{x} * image->width / size.width, row = size_t{y} * image->height / size.height;
    return reinterpret_cast<const uint8_t*>(image->pixels.get()) + 4 * (row * image->width + column);
  }
  uint8_t scalar(ImageSize size, uint32_t x, uint32_t y) const {
    if (!image) return 255;
    const uint8_t* t = texel(size, x, y);
    float value = 0;
    switch (channel) {
      case 'r':
      case 'g':
      case 'b':
      case 'm':
        value = t[channel == 'r' ? 0 : channel == 'g' ? 1 : channel == 'b' ? 2 : 3];
        break;
      default:
        value = shared::luminance(vec3(t[0], t[1], t[2]));
    }
    return uint8_t(std::lround(std::clamp(255 * use->base + use->gain * value, 0.0f, 255.0f)));
  }
};

// Normal maps are bluish, height maps gray.
bool isGray(const Texture& image) {
  const std::span<const uint8_t> texels = largestLevel(image);
  for (size_t i = 0; i < texels.size(); i += 4)
    if (std::abs(texels[i] - texels[i + 2]) > 8) return false;
  return true;
}

void storeNormal(const vec3& direction, uint8_t* out) {
  const vec3 normal = direction == vec3(0) ? vec3(0, 0, 1) : glm::normalize(direction);
  for (int i = 0; i < 3; ++i) out[i] = uint8_t(std::lround((normal[i] * 0.5f + 0.5f) * 255));
  out[3] = 255;
}

constexpr float kBumpTexels = 8;  // the height of white over black in texels, at -bm 1

// The gradient by central differences over the wrapped texture. Rows run downwards, so the height rises along the
// bitangent where it falls along the rows.
void normalAt(const Plane& heights, ImageSize size, float bump, uint32_t x, uint32_t y, uint8_t* out) {
  const float scale = bump * kBumpTexels;
  const auto at = [&](uint32_t u, uint32_t v) { return float(heights.scalar(size, u % size.width, v % size.height)); };
  const float du = (at(x + 1, y) - at(x + size.width - 1, y)) * scale / 510;
  const float dv = (at(x, y + 1) - at(x, y + size.height - 1)) * scale / 510;
  storeNormal(vec3(-du, dv, 1), out);
}

// A texel of a normal map at a scale, as glTF's normalTexture.scale defines it.
void scaledNormalAt(const Plane& normals, ImageSize size, float scale, uint32_t x, uint32_t y, uint8_t* out) {
  const uint8_t* t = normals.texel(size, x, y);
  const vec3 normal = vec3(t[0], t[1], t[2]) / 127.5f - 1.0f;
  storeNormal(vec3(scale * normal.x, scale * normal.y, normal.z), out);
}

void fillTexel(const ImageRequest& request, const Plane& first, const Plane& second, ImageSize size, uint32_t x,
               uint32_t y, uint8_t* out) {
  using Make = ImageRequest::Make;
  if (request.make == Make::NormalsFromHeights) return normalAt(first, size, request.bump, x, y, out);
  if (request.make == Make::ScaledNormals) return scaledNormalAt(first, size, request.bump, x, y, out);
  std::fill_n(out, 4, uint8_t{255});
  if (request.make == Make::ColorWithAlpha && first.image) std::copy_n(first.texel(size, x, y), 3, out);
  if (request.make == Make::ColorWithAlpha) out[3] = second.scalar(size, x, y);
  if (request.make == Make::RoughnessMetallic) out[1] = first.scalar(size, x, y), out[2] = second.scalar(size, x, y);
  if (request.make == Make::ScalarInRed) out[0] = out[1] = first.scalar(size, x, y);
  if (request.make == Make::ScalarInAlpha) out[3] = first.scalar(size, x, y);
}

}  // namespace

std::string Images::locate(const std::string& file, const std::string& folder) const {
  const std::filesystem::path inFolder = std::filesystem::path(folder) / file;
  return source_.folders.exists(inFolder) ? inFolder.string() : file;
}

bool Images::isReadable(const std::string& file) {
  const auto [known, isNew] = files_.try_emplace(file);
  if (!isNew) return known->second.has_value();
  if (!source_.folders.exists(file)) {
    warn("{}: the image {} does not exist, and is left out", source_.path.string(), shortened(printable(file)));
    return false;
  }
  try {
    known->second = source_.folders.read(file);
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("an image {}", error.what()));
  }
  source_.claim(known->second->size());
  source_.builder.scene.files.push_back(source_.path.parent_path() / file);
  return true;
}

int Images::request(const ImageRequest& request) {
  const auto [known, isNew] = known_.try_emplace(request, int(requests_.size()));
  if (isNew) requests_.push_back(request);
  return known->second;
}

size_t Images::bytesOf(const ImageRequest& request) const {
  ImageSize size{1, 1};
  for (const ImageUse* use : {&request.first, &request.second}) {
    if (use->file.empty()) continue;
    const ImageSize own = imageSize(encoded(use->file), use->file);
    size = {std::max(size.width, own.width), std::max(size.height, own.height)};
  }
  return mipChainBytes(size);
}

Texture Images::pack(ImageRequest request) const {
  Plane planes[2];
  ImageSize size{1, 1};
  for (int i = 0; i < 2; ++i) {
    const ImageUse& use = i == 0 ? request.first : request.second;
    if (use.file.empty()) continue;
    planes[i] = {decodeTexture(encoded(use.file), request.srgb && i == 0, utf8OrLatin1(use.file)), &use};
    planes[i].channel = channelOf(*planes[i].image, use);
    size = {std::max(size.width, planes[i].image->width), std::max(size.height, planes[i].image->height)};
  }
  if (request.make == ImageRequest::Make::NormalsFromHeights && !isGray(*planes[0].image)) {
    if (request.bump == 1) return *std::move(planes[0].image);
    request.make = ImageRequest::Make::ScaledNormals;
  }
  Texture texture = makeTexture(size, request.srgb, utf8OrLatin1(request.first.file + request.second.file));
  auto* texels = reinterpret_cast<uint8_t*>(texture.pixels.get());
  parallelFor(size.height, 64, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y)
      for (uint32_t x = 0; x < size.width; ++x)
        fillTexel(request, planes[0], planes[1], size, x, uint32_t(y), texels + 4 * (y * size.width + x));
  });
  buildMips(texture);
  return texture;
}

Texture Images::make(const ImageRequest& request) const {
  if (request.make == ImageRequest::Make::Plain)
    return decodeTexture(encoded(request.first.file), request.srgb, utf8OrLatin1(request.first.file));
  return pack(request);
}

void Images::decode() {
  Scene& scene = source_.builder.scene;
  scene.textures.resize(requests_.size());
  size_t total = 0;
  for (const ImageRequest& request : requests_) total += bytesOf(request);
  scene.memory.grow(total, "its textures");
  parallelFor(requests_.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) scene.textures[i] = make(requests_[i]);
  });
}

}  // namespace latelight::scene::mesh_files
