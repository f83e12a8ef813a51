// Picked pixels compared with the data outputs and the scene.
#include "render/submit/picking.h"

#include <latelight/latelight.h>

#include "base/error.h"
#include "render/support.h"
#include "scene/gltf_builder.h"
#include "scene/load/load.h"
#include "test_device.h"

namespace latelight::render::test {
namespace {

using output::Aov;

class Picking : public RenderTest {};

TEST_F(Picking, SaysWhatTheDataOutputsHave) {
  constexpr uint32_t kWidth = 64, kHeight = 36;
  const scene::Scene scene = scene::load("builtin:boxes");
  Renderer renderer(device(), scene, nullptr);
  scene::Camera camera = scene.cameras.front();
  camera.principal = {0, -1.2f};  // with some background
  Settings settings = settingsOf(
      kWidth, kHeight, {Aov::Id, Aov::Position, Aov::Normal, Aov::GeoNormal, Aov::Depth, Aov::Distance, Aov::Uv});
  const output::FrameOutput frame = std::move(renderer.render({&camera, 1}, settings).front());
  std::vector<glm::uvec2> pixels;
  for (uint32_t y = 0; y < kHeight; y += 5)
    for (uint32_t x = 0; x < kWidth; x += 7) pixels.push_back({x, y});
  const std::vector<Picked> picked = pick(renderer, scene, camera, settings, pixels).picked;
  ASSERT_EQ(picked.size(), pixels.size());
  size_t surfaces = 0;
  for (size_t i = 0; i < picked.size(); ++i) {
    const Picked& p = picked[i];
    const size_t at = size_t{pixels[i].y} * kWidth + pixels[i].x;
    EXPECT_EQ(p.pixel, pixels[i]);
    ASSERT_EQ(p.id, imageOf(frame, Aov::Id).ids[at]);
    if (p.id == 0) continue;
    ++surfaces;
    EXPECT_EQ(p.position, vec3At(imageOf(frame, Aov::Position), at));
    EXPECT_EQ(p.normal, vec3At(imageOf(frame, Aov::Normal), at));
    EXPECT_EQ(p.geonormal, vec3At(imageOf(frame, Aov::GeoNormal), at));
    EXPECT_EQ(p.depth, imageOf(frame, Aov::Depth).values[at]);
    EXPECT_EQ(p.distance, imageOf(frame, Aov::Distance).values[at]);
    EXPECT_EQ(p.uv, vec2At(imageOf(frame, Aov::Uv), at));
    const auto instance = std::find_if(scene.instances.begin(), scene.instances.end(),
                                       [&](const scene::Instance& candidate) { return candidate.id == p.id; });
    ASSERT_NE(instance, scene.instances.end());
    EXPECT_EQ(p.node, scene.nodes[instance->node].path);
    EXPECT_EQ(p.mesh, scene.meshes[instance->mesh].name);
    EXPECT_EQ(p.material, scene.materials[instance->material].name);
  }
  EXPECT_GT(surfaces, picked.size() / 4);
  EXPECT_LT(surfaces, picked.size());
}

TEST_F(Picking, OutsideThePictureIsRefused) {
  const scene::Scene scene = scene::load("builtin:boxes");
  Renderer renderer(device(), scene, nullptr);
  for (const glm::uvec2 outside : {glm::uvec2(64, 0), glm::uvec2(0, 36), glm::uvec2(~0u, ~0u)}) {
    try {
      pick(renderer, scene, scene.cameras.front(), settingsOf(64, 36), {&outside, 1});
      ADD_FAILURE() << outside.x << "," << outside.y;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::Usage);
      EXPECT_NE(std::string(error.what()).find("64x36"), std::string::npos) << error.what();
    }
  }
}

// A triangle that moves 10 m along X in one second, picked at its current position.
TEST_F(Picking, ShowsTheTimeThatIsAskedFor) {
  scene::test::GltfBuilder b = scene::test::triangleFile();
  const std::vector<float> times = {0, 1};
  const int input = b.accessor(b.view(times), scene::test::kFloat, "SCALAR", times.size());
  const int output = b.positions({{0, 0, 0}, {10, 0, 0}});
  b.add("animations", {{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}},
                       {"samplers", {{{"input", input}, {"output", output}}}}});
  const scene::test::TemporaryFolder folder;
  const std::string file = (folder.path() / "slide.glb").string();
  scene::test::writeBytes(file, b.glb());
  const latelight::Scene scene(file);
  latelight::Renderer renderer(scene, latelight::test::testDevice());
  latelight::Options options;
  options.width = options.height = 16;
  for (const double time : {0.0, 0.5, 1.0}) {
    SCOPED_TRACE(time);
    const float x = static_cast<float>(10 * time) + 0.25f;  // for a point of the triangle
    latelight::Camera camera = scene.lookAt({x, 0.25f, 3}, {x, 0.25f, 0}, 40);
    camera.nearClip = 0.01f;
    options.time = time;
    const latelight::Pick picked = renderer.pick(camera, {{8, 8}}, options).front();
    EXPECT_NE(picked.id, 0u);
    EXPECT_NEAR(picked.position[0], x, 0.1);
    options.time = time < 1 ? 1.0 : 0.0;
    EXPECT_EQ(renderer.pick(camera, {{8, 8}}, options).front().id, 0u) << "it is elsewhere then";
  }
}

}  // namespace
}  // namespace latelight::render::test
