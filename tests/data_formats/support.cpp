#include "data_formats/support.h"

#include <stdlib.h>

#include <cmath>

#include "render/submit/id_manifest.h"
#include "render/submit/session.h"
#include "scene/scene_builder.h"

namespace latelight::data::test {

namespace {

// Derived from the field of view, independently of the renderer.
std::array<double, 9> intrinsicsOf(const scene::Camera& camera, double width, double height) {
  const double f = height / 2 / (camera.orthographic ? camera.yHalf : std::tan(double{camera.verticalFov} / 2));
  return {f, 0, width / 2, 0, f, height / 2, 0, 0, 1};
}

}  // namespace

std::unique_ptr<Format> make(std::string_view name, const Json& options) {
  for (const FormatInfo& info : formats())
    if (info.name == name) return info.make(options);
  throw std::logic_error("there is no format " + std::string(name));
}

DataFrame Studio::frame(const scene::Camera& camera, uint32_t width, uint32_t height,
                        const std::vector<const Format*>& formats, uint64_t index, const render::SceneState& moment) {
  render::Settings settings = render::test::settingsOf(width, height);
  settings.raster = raster_;
  Extras extras;
  for (const Format* format : formats) {
    for (const output::Aov aov : format->needs())
      if (!output::contains(settings.aovs, aov)) settings.aovs.push_back(aov);
    settings.display = settings.display || format->needsDisplay();
    extras = both(extras, format->needsExtras());
  }
  DataFrame frame{.index = index, .name = fmt::format("{:06}", index)};
  frame.camera = static_cast<uint32_t>(index);
  if (settings.display || !settings.aovs.empty())
    frame.picture = std::move(renderer_.render({&camera, 1}, settings, moment).front());
  frame.metadata.ids = std::make_shared<output::IdManifest>(render::idManifest(scene_));
  renderExtras(renderer_, scene_, camera, settings, moment, extras, geometry_, frame);
  frame.picture.width = width;
  frame.picture.height = height;
  frame.metadata.scene = "test";
  frame.metadata.camera.name = camera.name;
  frame.metadata.camera.intrinsics = intrinsicsOf(camera, width, height);
  frame.metadata.camera.cameraToWorld = render::openCvPose(camera, scene_, false);
  frame.metadata.camera.orthographic = camera.orthographic;
  if (camera.lens) {
    const scene::Lens lens = scene::scaledTo(*camera.lens, width, height);
    if (lens.model != scene::LensModel::Pinhole) frame.metadata.camera.lens = lens;
    frame.metadata.camera.intrinsics = {lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1};
  }
  frame.metadata.axes = scene_.yUp ? "gltf" : "z-up";
  return frame;
}

scene::Scene squares() {
  scene::SceneBuilder builder("squares");
  builder.scene.meshes.push_back(render::test::squareMesh());
  builder.scene.materials.push_back(scene::plainMaterial("red", {1, 0, 0}, 0, 1));
  builder.scene.materials.push_back(scene::plainMaterial("blue", {0, 0, 1}, 0, 1));
  for (uint32_t id = 1; scene::Material & material : builder.scene.materials) material.data.id = id++;
  const auto add = [&](const char* name, glm::vec3 at, float size, uint32_t material) {
    glm::mat4 local(size);
    local[3] = glm::vec4(at, 1);
    builder.scene.nodes[builder.addInstance(name, 0, 0, material, local)].mesh = "square";
  };
  add("back", {0, 0, 0}, 1, 0);
  add("front", {1, 0, 0.5f}, 0.5f, 1);
  add("cut", {2, 1.5f, 0}, 1, 0);
  return std::move(builder.scene);
}

scene::Camera squaresCamera(bool perspective) {
  return perspective ? render::test::frontPerspective(shared::kPi / 2, 2) : render::test::frontCamera(2, 4);
}

FormatsTest::FormatsTest() {
  std::string name = (std::filesystem::temp_directory_path() / "latelight-formats-XXXXXX").string();
  folder = mkdtemp(name.data());
}

FormatsTest::~FormatsTest() {
  std::filesystem::remove_all(folder);
}

Json FormatsTest::json(const std::string& file) const {
  const std::vector<std::byte> bytes = readFile(folder / file);
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  return Json::parse(text, text + bytes.size());
}

}  // namespace latelight::data::test
