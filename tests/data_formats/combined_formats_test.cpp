// Formats of one job: a frame has everything that any of them requires, and each format writes only its own part.
#include <gmock/gmock.h>

#include "data_formats/support.h"
#include "scene/edit.h"

namespace latelight::data::test {
namespace {

class CombinedFormatsTest : public FormatsTest {
 protected:
  // Writes a frame of squares(), with a small square 0.5 m behind "back", in the first format. The frame also has what
  // the second format requires.
  FrameRecord write(const Format& format, const Format& other) {
    scene::Scene scene = squares();
    glm::dmat4 toWorld = scene.instances[0].toWorld;
    for (int axis = 0; axis < 3; ++axis) toWorld[axis] *= 0.25;
    toWorld[3] += glm::dvec4(-0.5, 0.5, 0, 0);  // the camera looks along the world's +Y
    const scene::ObjectPart part{0, 0, toWorld};
    scene::addObject(scene, {&part, 1}, "occluded");
    Studio studio(device(), scene);
    return format.writeFrame(studio.frame(squaresCamera(), 128, 128, {&format, &other}), folder);
  }
};

const Json kKeypoints{{"keypoints", Json::array({{{"name", "center"}}, {{"name", "tip"}, {"position", {0, 0.5, 0}}}})}};

TEST_F(CombinedFormatsTest, BoxesHaveOnlyTheirOwnKeypoints) {
  const auto yolo = make("yolo", kKeypoints), boxes = make("boxes"), labeled = make("boxes", kKeypoints);
  write(*boxes, *yolo);
  const Json without = json("boxes/000000.json");
  EXPECT_EQ(without["objects"].size(), 4u);
  for (const Json& object : without["objects"]) EXPECT_FALSE(object.contains("keypoints")) << object;
  write(*labeled, *yolo);
  const Json with = json("boxes/000000.json");
  EXPECT_EQ(with["objects"].size(), 4u);
  for (const Json& object : with["objects"]) {
    ASSERT_EQ(object["keypoints"].size(), 2u);
    EXPECT_EQ(object["keypoints"][1]["name"], "tip");
  }
}

TEST_F(CombinedFormatsTest, CocoHasOnlyItsOwnKeypoints) {
  const auto yolo = make("yolo", kKeypoints), coco = make("coco"), labeled = make("coco", kKeypoints);
  const FrameRecord without = write(*coco, *yolo), with = write(*labeled, *yolo);
  EXPECT_EQ(without.entry["objects"].size(), 3u);
  EXPECT_EQ(with.entry["objects"].size(), 3u);
  for (const Json& object : without.entry["objects"]) {
    EXPECT_FALSE(object.contains("keypoints")) << object;
    EXPECT_FALSE(object.contains("num_keypoints")) << object;
  }
  for (const Json& object : with.entry["objects"]) EXPECT_EQ(object["keypoints"].size(), 3 * 2u);
}

// The square behind "back" is in no pixel. It has an amodal mask, which the format voc requires.
TEST_F(CombinedFormatsTest, OccludedObjectsAreListedOnlyWithAmodalMasks) {
  const auto nodes = [&](bool whole) {
    write(*make("boxes", {{"whole", whole}}), *make("voc"));
    std::vector<std::string> nodes;
    const Json written = json("boxes/000000.json");
    for (const Json& object : written["objects"]) nodes.push_back(object["node"]);
    return nodes;
  };
  EXPECT_THAT(nodes(true), testing::UnorderedElementsAre("/squares/back", "/squares/front", "/squares/cut",
                                                         testing::HasSubstr("occluded")));
  EXPECT_THAT(nodes(false), testing::UnorderedElementsAre("/squares/back", "/squares/front", "/squares/cut"));
}

}  // namespace
}  // namespace latelight::data::test
