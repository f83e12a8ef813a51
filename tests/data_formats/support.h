// Helpers for the tests of formats: frames of a data set, scenes with known pixels, and an output folder.
#pragma once

#include <nlohmann/json.hpp>

#include "data/extras.h"
#include "data/format.h"
#include "output/support.h"
#include "render/support.h"

namespace latelight::data::test {

using Json = nlohmann::ordered_json;

std::unique_ptr<Format> make(std::string_view name, const Json& options = Json::object());

// A scene, its renderer, and rendered frames.
class Studio {
 public:
  Studio(vk::Device& device, const scene::Scene& scene, render::Raster raster = render::test::testRaster())
      : scene_(scene), raster_(raster), renderer_(device, scene, nullptr) {}

  // Returns a frame with everything that these formats need. `index` is the frame's number and name.
  DataFrame frame(const scene::Camera& camera, uint32_t width, uint32_t height,
                  const std::vector<const Format*>& formats, uint64_t index = 0, const render::SceneState& moment = {});

 private:
  const scene::Scene& scene_;
  render::Raster raster_;
  render::Renderer renderer_;
  GeometryHashes geometry_;
};

// Squares that face a camera at +Z (glTF's frame). "back" is [-1, 1]^2 at z = 0. "front", half as large, stands at z =
// 0.5 in front of its right edge, with its center at x = 1. "cut" is as large as the back one and has its center at (2,
// 1.5).
scene::Scene squares();
// The camera of squares(): it looks along -Z, and the square [-2, 2]^2 at z = 0 fills the picture.
scene::Camera squaresCamera(bool perspective = false);

class FormatsTest : public render::test::RenderTest {
 protected:
  FormatsTest();
  ~FormatsTest() override;
  Json json(const std::string& file) const;
  std::filesystem::path folder;
};

}  // namespace latelight::data::test
