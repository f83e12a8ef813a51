// Objects of a frame compared with closed forms: their bounding boxes, and the pixels that each object would cover by
// itself (amodal masks).
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <string_view>

#include "data_formats/support.h"
#include "labels/amodal.h"
#include "models/models.h"
#include "scene/builtin/builtin.h"
#include "scene/edit.h"
#include "scene/load/load.h"
#include "scene/scene_builder.h"

namespace latelight::data::test {
namespace {

using output::Aov;

// A format that requests what a test needs of its frames, and writes nothing.
class Needs : public Format {
 public:
  explicit Needs(Extras extras, std::vector<Aov> aovs = {Aov::Id}) : extras_(extras), aovs_(std::move(aovs)) {}
  std::vector<Aov> needs() const override { return aovs_; }
  Extras needsExtras() const override { return extras_; }
  std::vector<FormatFile> files(const DataFrame&) const override { return {}; }

 private:
  void writeFiles(const DataFrame&, const std::filesystem::path&, FrameRecord&) const override {}

  Extras extras_;
  std::vector<Aov> aovs_;
};
const Needs kAlone({.alone = true}), kOrder({.order = true}), kBoxes({.boxes = true}), kIds({});

const Object& objectAt(const DataFrame& frame, std::string_view node) {
  for (const output::IdEntry& entry : frame.metadata.ids->ids)
    for (const Object& object : frame.objects)
      if (entry.node == node && object.id == entry.id) return object;
  throw std::logic_error("the frame has no object " + std::string(node));
}

void expectNear(glm::dvec3 a, glm::dvec3 b, double tolerance) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << "axis " << i;
}

class ObjectsTest : public FormatsTest {};
class AloneTest : public FormatsTest, public testing::WithParamInterface<render::Raster> {};

TEST_F(ObjectsTest, BoxesOfKnownBoxes) {
  const scene::Scene scene = scene::load("builtin:boxes");
  Studio studio(device(), scene);
  const DataFrame frame = studio.frame(scene.cameras.front(), 32, 18, {&kBoxes});
  ASSERT_EQ(frame.objects.size(), scene::boxesBoxes().size());
  for (const scene::BoxesBox& box : scene::boxesBoxes()) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Object& object : frame.objects) {
      glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
      for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec4 at((corner & 1) != 0 ? object.high.x : object.low.x,
                            (corner & 2) != 0 ? object.high.y : object.low.y,
                            (corner & 4) != 0 ? object.high.z : object.low.z, 1);
        low = glm::min(low, glm::dvec3(object.toWorld * at));
        high = glm::max(high, glm::dvec3(object.toWorld * at));
      }
      nearest = std::min(nearest, glm::length(low - glm::dvec3(box.min)) + glm::length(high - glm::dvec3(box.max)));
    }
    EXPECT_LT(nearest, 1e-5);
  }
}

// The node is rotated by 30 degrees about Y, stretched and mirrored. The box rotates with the node and has its scale.
TEST_F(ObjectsTest, BoxesTurnWithTheirNodes) {
  scene::SceneBuilder builder("turned");
  builder.scene.meshes.push_back(render::test::sphereMesh(1));
  builder.scene.materials.push_back(scene::plainMaterial("white", {1, 1, 1}, 0, 1));
  const double angle = shared::kPi / 6;
  const glm::dvec3 x(std::cos(angle), 0, -std::sin(angle)), y(0, 1, 0), z(std::sin(angle), 0, std::cos(angle));
  builder.addInstance("ball", 0, 0, 0,
                      glm::mat4(glm::vec4(glm::vec3(x * -3.0), 0), glm::vec4(glm::vec3(y * 2.0), 0),
                                glm::vec4(glm::vec3(z), 0), glm::vec4(4, 5, 6, 1)));
  const scene::Scene scene = std::move(builder.scene);
  Studio studio(device(), scene);
  const DataFrame frame = studio.frame(squaresCamera(), 16, 16, {&kBoxes});
  const Object& ball = objectAt(frame, "/turned/ball");
  expectNear(glm::dvec3(ball.toWorld[3]), {4, 5, 6}, 1e-6);
  EXPECT_NEAR(glm::determinant(glm::dmat3(ball.toWorld)), 1, 1e-6);
  EXPECT_NEAR(std::abs(glm::dot(glm::dvec3(ball.toWorld[0]), x)), 1, 1e-6);
  EXPECT_NEAR(std::abs(glm::dot(glm::dvec3(ball.toWorld[2]), z)), 1, 1e-6);
  expectNear(ball.low, {-3, -2, -1}, 1e-5);
  expectNear(ball.high, {3, 2, 1}, 1e-5);
}

// The frame of a group is that of its topmost node, turned by 30 degrees about Y, whichever of its parts are shown. The
// parts are turned and stretched themselves, and the topmost node mirrors Y and Z, which is part of the coordinates.
TEST_F(ObjectsTest, FramesOfGroupsDoNotDependOnTheirVisibleParts) {
  for (const glm::vec3 scale : {glm::vec3(2), glm::vec3(2, -2, -2)}) {
    scene::SceneBuilder builder("scene");
    scene::Scene& scene = builder.scene;
    scene.meshes.push_back(render::test::sphereMesh(1));
    scene.materials.push_back(scene::plainMaterial("white", {1, 1, 1}, 0, 1));
    const double angle = shared::kPi / 6;
    const scene::RigNode group{
        .translation = {4, 5, 6}, .scale = scale, .rotation = {0, std::sin(angle / 2), 0, std::cos(angle / 2)}};
    const glm::dmat4 rigid = glm::rotate(glm::translate(glm::dmat4(1), {4, 5, 6}), angle, {0, 1, 0});
    const glm::mat4 local(glm::scale(rigid, glm::dvec3(scale)));
    const uint32_t top = builder.addNode("group", builder.kRoot, local);
    for (const float turn : {1.1f, -0.7f}) {
      const glm::mat4 part = glm::translate(glm::mat4(1), {turn, 0, 0}) * glm::rotate(glm::mat4(1), turn, {1, 1, 0}) *
                             glm::scale(glm::mat4(1), {0.5f, 0.25f, 1});
      const uint32_t node = builder.addInstance("part", top, 0, 0, part);
      scene.instances.back().id = scene.nodes[node].id = scene.nodes[top].id;
    }
    scene.fileNodes.resize(scene.nodes.size());
    scene.fileNodes[top] = group;
    for (const auto& [first, second] : {std::pair(true, true), {true, false}, {false, true}}) {
      scene.instances[0].hidden = !first;
      scene.instances[1].hidden = !second;
      const std::vector<Object> objects = labels::objectsOf(scene, {}, false, nullptr);
      ASSERT_EQ(objects.size(), 1u);
      expectNear(glm::dvec3(objects[0].toWorld[3]), {4, 5, 6}, 1e-5);
      for (int axis = 0; axis < 3; ++axis) {
        SCOPED_TRACE(fmt::format("{} {} {} {}", scale.y, first, second, axis));
        expectNear(glm::dvec3(objects[0].toWorld[axis]), glm::dvec3(rigid[axis]), 1e-6);
      }
    }
  }
}

// Edges lie between pixels, so every count is an integer.
TEST_P(AloneTest, CountsOfSquares) {
  const scene::Scene scene = squares();
  for (const bool perspective : {false, true}) {
    SCOPED_TRACE(perspective);
    Studio studio(device(), scene, GetParam());
    const DataFrame frame = studio.frame(squaresCamera(perspective), 128, 128, {&kAlone});
    const Object &back = objectAt(frame, "/squares/back"), &cut = objectAt(frame, "/squares/cut");
    EXPECT_EQ(back.alone.area(), 64u * 64);
    EXPECT_EQ(back.pixels, 64u * 64);
    EXPECT_EQ(back.full, (PixelBox{32, 32, 64, 64}));
    EXPECT_EQ(cut.alone.area(), 32u * 48);
    EXPECT_EQ(cut.alone.box(), (PixelBox{96, 0, 32, 48}));
    EXPECT_EQ(cut.pixels, 64u * 64);
    EXPECT_EQ(cut.full, (PixelBox{96, -16, 64, 64}));
  }
}

// The front square occludes 16 x 32 of the back one's 64 x 64 pixels: seven eighths of it are visible.
TEST_P(AloneTest, ShareVisible) {
  const scene::Scene scene = squares();
  Studio studio(device(), scene, GetParam());
  const DataFrame frame = studio.frame(squaresCamera(), 128, 128, {&kOrder});
  const Object &back = objectAt(frame, "/squares/back"), &front = objectAt(frame, "/squares/front");
  std::map<uint32_t, Mask> visible = masksOf(frame.picture.aovs.front());
  EXPECT_EQ(8 * visible.at(back.id).area(), 7 * back.pixels);
  EXPECT_EQ(visible.at(front.id).area(), front.pixels);
  EXPECT_EQ(front.occludes, (std::vector<labels::Occlusion>{{back.id, 16 * 32}}));
  EXPECT_TRUE(back.occludes.empty());
}

// The visible pixels of an object are a subset of those that it covers by itself, in a scene with edges in all
// directions.
TEST_P(AloneTest, HoldsWhatIsVisible) {
  const scene::Scene& scene = render::test::hall();
  Studio studio(device(), scene, GetParam());
  const DataFrame frame = studio.frame(render::test::cameraOf(scene, 96, 54), 96, 54, {&kAlone});
  size_t hidden = 0;
  for (const auto& [id, visible] : masksOf(frame.picture.aovs.front())) {
    const auto object = std::ranges::find(frame.objects, id, &Object::id);
    ASSERT_NE(object, frame.objects.end());
    const std::vector<uint8_t> seen = visible.pixels(), alone = object->alone.pixels();
    for (size_t i = 0; i < seen.size(); ++i) ASSERT_LE(seen[i], alone[i]) << "pixel " << i;
    hidden += visible.area() < object->alone.area();
    EXPECT_GE(object->pixels, object->alone.area());
  }
  EXPECT_GT(hidden, 3u);
}

// Objects that are rendered together in one view have the same masks as in views of their own.
TEST_F(ObjectsTest, AloneTogetherAsOneByOne) {
  const scene::Scene& scene = render::test::hall();
  const scene::Camera camera = render::test::cameraOf(scene, 96, 54);
  Studio studio(device(), scene);
  const DataFrame frame = studio.frame(camera, 96, 54, {&kAlone});
  render::Renderer renderer(device(), scene, nullptr);
  size_t seen = 0;
  for (size_t i = 0; i < frame.objects.size(); i += 60) {
    std::vector<Object> one{frame.objects[i]};
    one[0].alone = {};
    one[0].pixels = 0;
    one[0].full = {};
    labels::renderIsolated(renderer, scene, camera, render::test::settingsOf(96, 54), {}, one);
    EXPECT_EQ(one[0].alone.runs, frame.objects[i].alone.runs);
    EXPECT_EQ(one[0].pixels, frame.objects[i].pixels);
    EXPECT_EQ(one[0].full, frame.objects[i].full);
    seen += one[0].pixels > 0;
  }
  EXPECT_GT(seen, 5u);
}

// The visible points of an object lie in its box, in the middle of every animation. This includes groups.
void expectBoxesHoldPixels(vk::Device& device, const scene::Scene& scene, const render::SceneState& moment) {
  Studio studio(device, scene);
  const Needs needs({.boxes = true}, {Aov::Id, Aov::Position});
  const DataFrame frame = studio.frame(render::test::cameraOf(scene, 64, 36), 64, 36, {&needs}, 0, moment);
  const output::AovImage &ids = frame.picture.aovs[0], &positions = frame.picture.aovs[1];
  EXPECT_GT(ids.ids.size() - static_cast<size_t>(std::ranges::count(ids.ids, 0u)), 50u);
  for (size_t i = 0; i < ids.ids.size(); ++i) {
    if (ids.ids[i] == 0) continue;
    const auto object = std::ranges::find(frame.objects, ids.ids[i], &Object::id);
    ASSERT_NE(object, frame.objects.end());
    const glm::dvec3 at(glm::inverse(object->toWorld) * glm::dvec4(render::test::vec3At(positions, i), 1));
    const double slack = 1e-3 * glm::length(object->high - object->low);
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_GE(at[axis], object->low[axis] - slack);
      ASSERT_LE(at[axis], object->high[axis] + slack);
    }
  }
}

class ModelBoxesTest : public FormatsTest, public testing::WithParamInterface<std::string> {};

TEST_P(ModelBoxesTest, HoldTheirPixels) {
  const scene::Scene scene = scene::load(models::modelPath(GetParam()).string());
  render::SceneState moment;
  if (!scene.rig.animations.empty()) {
    const scene::Playback playback = scene::choosePlayback(scene, "", false);
    const scene::Pose pose = scene::poseAt(scene, playback, scene::duration(scene, playback) / 2);
    moment.poses = {pose, pose, pose};
  }
  expectBoxesHoldPixels(device(), scene, moment);
}

TEST_F(ObjectsTest, GroupsHaveOneBox) {
  scene::LoadOptions options;
  options.ids.depth = 1;
  const scene::Scene scene = scene::load("builtin:hall,triangles=60k,lights=20", options);
  expectBoxesHoldPixels(device(), scene, {});
}

INSTANTIATE_TEST_SUITE_P(Models, ModelBoxesTest,
                         testing::ValuesIn(models::withReal({"skinned.glb", "morphed.glb", "intricate.glb"},
                                                            {"Fox.glb", "CesiumMan.glb"})),
                         [](const auto& info) { return render::test::caseName(info); });
INSTANTIATE_TEST_SUITE_P(Rasters, AloneTest, testing::Values(render::Raster::Hardware, render::Raster::Compute),
                         [](const auto& info) { return render::nameOf(info.param); });

}  // namespace
}  // namespace latelight::data::test
