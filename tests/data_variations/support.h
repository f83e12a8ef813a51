// Helpers for the tests of variations.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "app/folder.h"
#include "base/error.h"
#include "data/variations/variations.h"
#include "scene/builtin/builtin.h"
#include "scene/load/load.h"
#include "scene/scene.h"

namespace latelight::data::test {

using app::Folder;
using glm::dmat4, glm::dvec3, glm::dvec4;
using Json = nlohmann::ordered_json;

// Returns a .bmp file of 2x2 pixels of one color.
inline std::string bitmap(uint8_t red, uint8_t green, uint8_t blue) {
  const std::string head{'B', 'M', 70, 0, 0, 0, 0, 0,  0, 0, 54, 0, 0, 0, 40, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 1,
                         0,   24,  0,  0, 0, 0, 0, 16, 0, 0, 0,  0, 0, 0, 0,  0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  std::string text = head;
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 2; ++column)
      for (const uint8_t channel : {blue, green, red}) text += static_cast<char>(channel);
    text.append(2, 0);
  }
  return text;
}

// A scene and its variations.
struct Varied {
  explicit Varied(const std::string& spec, const std::string& source = "builtin:boxes", uint64_t seed = 42)
      : scene(scene::load(source)), variations(Json::parse(spec), scene, seed) {}
  scene::Scene scene;
  Variations variations;
};

}  // namespace latelight::data::test
