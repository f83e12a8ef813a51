#include "data/formats/correspondence_arrays.h"

#include <span>
#include <string_view>

#include "output/exr.h"
#include "output/npy.h"
#include "output/zip_archive.h"

namespace latelight::data {

using labels::Correspondence;

std::vector<std::pair<std::string, std::vector<std::byte>>> correspondenceArrays(const Correspondence& match) {
  const uint64_t rows = match.height, columns = match.width;
  const auto bytes = [](const auto& values) { return std::as_bytes(std::span(values)); };
  const auto npy = [&](std::string_view type, std::vector<uint64_t> shape, std::span<const std::byte> data) {
    return output::encodeNpy(type, shape, data);
  };
  return {{"pixels", npy("<f4", {rows, columns, 2}, bytes(match.pixels))},
          {"depth", npy("<f4", {rows, columns}, bytes(match.depth))},
          {"visible", npy("|b1", {rows, columns}, bytes(match.visible))},
          {"flow", npy("<f4", {rows, columns, 3}, bytes(match.flow))}};
}

std::vector<std::byte> encodeCorrespondenceNpz(const Correspondence& match) {
  output::ZipArchive archive;
  for (const auto& [name, bytes] : correspondenceArrays(match)) archive.add(name + ".npy", bytes);
  return archive.finish();
}

// The channels of scene flow are those of the output of that name.
std::vector<std::byte> encodeCorrespondenceExr(const Correspondence& match, output::Metadata metadata) {
  output::AovImage flow{.aov = output::Aov::SceneFlow, .width = match.width, .height = match.height};
  std::vector<float> x, y, visible;
  for (size_t i = 0; i < match.depth.size(); ++i) {
    for (const int c : {0, 1, 2}) flow.values.push_back(match.flow[i][c]);
    x.push_back(match.pixels[i].x);
    y.push_back(match.pixels[i].y);
    visible.push_back(match.visible[i]);
  }
  output::ExrExtras extras;
  extras.channels = {{"match.X", x}, {"match.Y", y}, {"match.depth", match.depth}, {"match.visible", visible}};
  metadata.ids = {};
  const output::AovImage* images[] = {&flow};
  return output::encodeExr(images, metadata, extras);
}

}  // namespace latelight::data
