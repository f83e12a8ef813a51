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

// A scene, its renderer, and frames of it.
class Studio {
 public:
  Studio(vk::Device& device, const scene::Scene& scene, render::Raster raster = render::test::testRaster())
      : scene_(scene), raster_(raster), renderer_(device, scene, nullptr) {}

  // With all that these formats need. `index`: of the frame, which is named by it.
  DataFrame frame(const scene::Camera& camera, uint32_t width, uint32_t height,
                  const std::vector<const Format*>& formats, uint64_t index = 0, const render::SceneState& moment = {});

 private:
  const scene::Scene& scene_;
  render::Raster raster_;
  render::Renderer renderer_;
  GeometryHashes geometry_;
};

// Squares that face a camera at +Z, of glTF's frame: "back" is [-1, 1]^2 at z = 0; "front", half as large, stands at
// z = 0.5 before its right edge, its middle at x = 1; "cut" is as large as the back one, its middle at (2, 1.5).
scene::Scene squares();
// Camera of squares(): looks at them along -Z, so that the square [-2, 2]^2 at z = 0 fills the picture.
scene::Camera squaresCamera(bool perspective = false);

class FormatsTest : public render::test::RenderTest {
 protected:
  FormatsTest();
  ~FormatsTest() override;
  Json json(const std::string& file) const;
  std::filesystem::path folder;
};

}  // namespace latelight::data::test
