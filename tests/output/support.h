// Helpers for the tests of output: a temporary folder, frames filled with numbers, and error messages.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <random>
#include <string>

#include "base/error.h"
#include "base/files.h"
#include "error_of.h"
#include "output/files.h"
#include "output/read.h"

namespace latelight::output {

class InFolder : public testing::Test {
 protected:
  InFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "latelight-output-XXXXXX").string();
    folder = mkdtemp(name.data());
  }
  ~InFolder() override { std::filesystem::remove_all(folder); }
  // The names of all files, sorted; folders end in a slash.
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      all.push_back(entry.path().lexically_relative(folder).string() + (entry.is_directory() ? "/" : ""));
    }
    std::sort(all.begin(), all.end());
    return all;
  }
  std::string at(const std::string& name) const { return (folder / name).string(); }
  std::filesystem::path folder;
};

inline bool isNormal(Aov aov) {
  return aov == Aov::Normal || aov == Aov::GeoNormal;
}

// Values like those of a renderer, including the extremes; every seventh pixel is background.
inline AovImage numbers(Aov aov, uint32_t width, uint32_t height, unsigned seed = 1) {
  std::mt19937 random(seed + static_cast<unsigned>(aov));  // produces the same sequence on every platform
  const auto uniform = [&] { return static_cast<float>(random() >> 8) / 16777216.0f; };
  AovImage image = makeAovImage(aov, width, height);
  for (size_t i = 0; i < image.ids.size(); ++i) image.ids[i] = i % 7 == 0 ? 0 : random();
  const size_t channels = info(aov).channels;
  for (size_t i = 0; i < image.values.size() / channels; ++i) {
    if (i % 7 == 0) continue;
    for (size_t c = 0; c < channels; ++c) {
      float& value = image.values[i * channels + c];
      value = uniform();
      if (aov == Aov::Depth || aov == Aov::Distance) value *= 80;
      if (aov == Aov::Position || aov == Aov::Uv) value = (value - 0.5f) * 12;
      if (aov == Aov::Samples) value = std::floor(value * 5);
      if (aov == Aov::LightsTested || aov == Aov::LightsUsed || aov == Aov::Raw) value = std::floor(value * 5000);
      if (aov == Aov::RasterClasses && c == 0) value = std::floor(value * 4) + 1;
      if (aov == Aov::RasterClusters || aov == Aov::RasterTriangles) value = std::floor(value * 5000);
      if (aov == Aov::RasterOverdraw) value = std::floor(value * 40);
      if (isNormal(aov)) value = value * 2 - 1;
      if (aov == Aov::Emissive || (aov == Aov::Color && c < 3)) value *= i % 5 == 0 ? 3e5f : 1.5f;
    }
  }
  return image;
}

inline FrameOutput frameOfNumbers(uint32_t width, uint32_t height) {
  FrameOutput frame{width, height, {}, {}};
  for (const AovInfo& aov : aovs()) frame.aovs.push_back(numbers(aov.aov, width, height));
  std::mt19937 random(7);
  for (size_t i = 0; i < size_t{width} * height * 4; ++i) frame.display.push_back(static_cast<uint8_t>(random()));
  return frame;
}

inline std::vector<Aov> allAovs() {
  std::vector<Aov> all;
  for (const AovInfo& aov : aovs()) all.push_back(aov.aov);
  return all;
}

}  // namespace latelight::output
