// The picture of a variation is byte for byte that of a scene without earlier variations, in any order of variations.
#include "data/random.h"
#include "data_variations/support.h"
#include "edits/workshop.h"

namespace latelight::data::test {
namespace {

using render::test::RenderTest;

// One variation of each kind, and two that alternate on the same elements.
std::string everyKind(const Folder& folder) {
  folder.write("a.bmp", bitmap(255, 60, 20));
  folder.write("b.bmp", bitmap(30, 60, 255));
  return R"([
    {"type": "materials", "materials": ["floor", "metal", "both*"], "baseColor": [[0, 0, 0], [1, 1, 1]], "roughness": [0, 1]},
    {"type": "materials", "materials": "metal", "metallic": [0, 1]},
    {"type": "textures", "materials": ["floor", "holes"], "repeat": [1, 3], "folder": ")" +
         folder.path().string() + R"("},
    {"type": "lights", "lights": ["bulb", "spot"], "intensity": [0.5, 3], "temperature": [2500, 8000], "jitter": 0.5, "on": [0, 2]},
    {"type": "addedLights", "count": [0, 2], "min": [-2, 1, -2], "max": [2, 3, 2], "intensity": [1, 4]},
    {"type": "transforms", "nodes": ["ball", "mirrored*", "fence"], "translation": [[-0.5, 0, -0.5], [0.5, 0.5, 0.5]],
     "rotation": [0, 360], "scale": [0.6, 1.2]},
    {"type": "visibility", "nodes": ["ball", "pane", "lens", "card", "lamp"], "probability": 0.6},
    {"type": "visibility", "nodes": ["sign", "fence"], "visible": [0, 1]},
    {"type": "scatter", "objects": [{"node": "lamp"}, {"node": "card"}], "count": [0, 5], "on": "ground", "scale": [0.3, 0.6]},
    {"type": "scatter", "objects": [{"file": "builtin:boxes"}], "count": [0, 1], "min": [-2, 0, -2], "max": [2, 2, 2], "scale": 0.05}
  ])";
}

class OrderTest : public RenderTest {
 protected:
  static output::FrameOutput picture(render::Renderer& renderer) {
    const scene::Camera camera = render::test::workshopCamera();
    return std::move(renderer.render({&camera, 1}, render::test::workshopSettings()).front());
  }
  output::FrameOutput freshPicture(const Json& spec, uint64_t number, Json& said) {
    scene::Scene scene = render::test::workshop();
    Variations variations(spec, scene, 7);
    said = variations.apply(number);
    render::Renderer renderer(device(), scene, nullptr);
    return picture(renderer);
  }
};

TEST_F(OrderTest, NothingIsLeftOfOtherNumbers) {
  const Folder folder;
  const Json spec = Json::parse(everyKind(folder));
  scene::Scene scene = render::test::workshop();
  Variations variations(spec, scene, 7);
  render::Renderer renderer(device(), scene, nullptr);
  Random random(9, 1, "order");
  std::map<uint64_t, output::FrameOutput> fresh;
  std::map<uint64_t, Json> expected;
  for (int i = 0; i < 24; ++i) {
    const uint64_t number = random.below(8);
    const Json said = variations.apply(number);
    if (!fresh.contains(number)) fresh[number] = freshPicture(spec, number, expected[number]);
    EXPECT_EQ(said, expected[number]);
    render::test::expectSame(picture(renderer), fresh[number]);
  }
  // The pictures of different variations differ.
  ASSERT_GE(fresh.size(), 6u);
  for (auto a = fresh.begin(); std::next(a) != fresh.end(); ++a)
    EXPECT_NE(a->second.aovs[0].values, std::next(a)->second.aovs[0].values);
}

TEST_F(OrderTest, WhatIsNotDrawnKeepsTheFilesValues) {
  scene::Scene scene = render::test::workshop(), untouched = render::test::workshop();
  Variations variations(nullptr, scene, 7);
  variations.apply(3);
  render::Renderer renderer(device(), scene, nullptr), plain(device(), untouched, nullptr);
  render::test::expectSame(picture(renderer), picture(plain));
}

TEST_F(OrderTest, SeedsDiffer) {
  const Folder folder;
  const Json spec = Json::parse(everyKind(folder));
  scene::Scene a = render::test::workshop(), b = render::test::workshop();
  EXPECT_NE(Variations(spec, a, 1).apply(0), Variations(spec, b, 2).apply(0));
}

}  // namespace
}  // namespace latelight::data::test
