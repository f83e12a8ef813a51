// Labels of objects, keypoints and correspondences by the public API, compared with closed forms.
#include <latelight/latelight.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <string>
#include <string_view>

#include "models/models.h"
#include "render/support.h"
#include "test_device.h"

namespace latelight::test {
namespace {

using glm::dmat4;
using glm::dvec2;
using glm::dvec3;

Transform rowsOf(const dmat4& m) {
  Transform rows;
  for (size_t i = 0; i < 16; ++i) rows[i] = m[static_cast<int>(i % 4)][static_cast<int>(i / 4)];
  return rows;
}

dmat4 matrixOf(const Transform& rows) {
  dmat4 m;
  for (size_t i = 0; i < 16; ++i) m[static_cast<int>(i % 4)][static_cast<int>(i / 4)] = rows[i];
  return m;
}

// The square [-1, 1]^2, facing +Z.
MeshData square() {
  return {
      .name = "square", .positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, .indices = {0, 1, 2, 0, 2, 3}};
}

struct SquareAt {
  const char* name;
  dvec3 center;
  dvec2 half;
};

// Squares that face the camera, which looks along -Z, in the scene's own frame.
Scene squares(std::initializer_list<SquareAt> places) {
  Scene scene;
  const Handle<Mesh> mesh = scene.addMesh(square());
  const Handle<Material> material = scene.addMaterial(Material{.name = "plain"});
  for (const SquareAt& place : places) {
    const dmat4 at = glm::scale(glm::translate(dmat4(1), place.center), dvec3(place.half, 1));
    scene.addInstance(mesh, material, rowsOf(at), place.name);
  }
  return scene;
}

// Orthographic: 64 x 64 pixels show [-4, 4]^2, 8 pixels per meter.
Camera front() {
  Camera camera;
  camera.cameraToWorld = rowsOf(dmat4(1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 10, 1));
  camera.orthographic = true;
  camera.halfHeight = 4;
  camera.farClip = 100;
  return camera;
}

Options sized(uint32_t width, uint32_t height) {
  Options options;
  options.width = width;
  options.height = height;
  return options;
}

class LabelsTest : public testing::TestWithParam<const char*> {
 protected:
  Options small(uint32_t width = 64, uint32_t height = 64) const {
    Options options = sized(width, height);
    options.raster = GetParam();
    return options;
  }
  // GPUs interpolate from vertices on a grid of 1/256 pixel; lavapipe and the raster compute do not.
  static double pixelTolerance() {
    return testDevice() != "cpu" && std::string_view(GetParam()) == "hardware" ? 1.0 / 256 : 1e-3;
  }
  static const ObjectLabel& labelOf(const Labels& labels, std::string_view node) {
    for (const ObjectLabel& label : labels.objects)
      if (label.node == node) return label;
    throw std::logic_error("there is no object " + std::string(node));
  }
};

TEST_P(LabelsTest, MasksBoxesAndOrderOfSquares) {
  // From near to far: `left` and `right` overlap `middle`; `behind` is hidden by all of them; `edge` crosses the right
  // edge of the picture.
  const Scene scene = squares({{"left", {-1.5, 0, 3}, {1, 1}},
                               {"right", {1.5, 0, 2}, {1, 1}},
                               {"middle", {0, 0, 1}, {2, 0.5}},
                               {"behind", {0, 0, 0}, {0.5, 0.25}},
                               {"edge", {4, 3, 0}, {0.5, 0.5}},
                               {"outside", {9, 0, 0}, {1, 1}}});
  Renderer renderer(scene, testDevice());
  const Labels labels = renderer.labels(front(), small());
  ASSERT_EQ(labels.objects.size(), 5u);
  const auto expect = [&](const char* node, uint64_t visible, uint64_t amodal, uint64_t full, PixelBox visibleBox,
                          PixelBox amodalBox, PixelBox fullBox) {
    const ObjectLabel& label = labelOf(labels, node);
    EXPECT_EQ(label.visiblePixels, visible) << node;
    EXPECT_EQ(label.amodalPixels, amodal) << node;
    EXPECT_EQ(label.fullPixels, full) << node;
    EXPECT_EQ(label.visibleShare, double(visible) / double(full)) << node;
    EXPECT_TRUE(label.visibleBox == visibleBox) << node;
    EXPECT_TRUE(label.amodalBox == amodalBox) << node;
    EXPECT_TRUE(label.fullBox == fullBox) << node;
    EXPECT_EQ(std::ranges::count(label.visibleMask, 1), int64_t(visible)) << node;
    EXPECT_EQ(std::ranges::count(label.amodalMask, 1), int64_t(amodal)) << node;
    for (size_t i = 0; i < labels.ids.size(); ++i)
      ASSERT_EQ(labels.ids[i] == label.id, label.visibleMask[i] == 1) << node;
  };
  expect("/left", 256, 256, 256, {12, 24, 16, 16}, {12, 24, 16, 16}, {12, 24, 16, 16});
  expect("/right", 256, 256, 256, {36, 24, 16, 16}, {36, 24, 16, 16}, {36, 24, 16, 16});
  expect("/middle", 64, 256, 256, {28, 28, 8, 8}, {16, 28, 32, 8}, {16, 28, 32, 8});
  expect("/behind", 0, 32, 32, {}, {28, 30, 8, 4}, {28, 30, 8, 4});
  expect("/edge", 32, 32, 64, {60, 4, 4, 8}, {60, 4, 4, 8}, {60, 4, 8, 8});
  const auto occlusion = [&](const char* front, const char* back) {
    const auto index = [&](const char* node) { return size_t(&labelOf(labels, node) - labels.objects.data()); };
    return labels.occlusions[index(front) * labels.objects.size() + index(back)];
  };
  EXPECT_EQ(occlusion("/left", "/middle"), 96u);  // 12 x 8
  EXPECT_EQ(occlusion("/right", "/middle"), 96u);
  EXPECT_EQ(occlusion("/middle", "/behind"), 32u);  // although others could be in front of both
  EXPECT_EQ(occlusion("/middle", "/left"), 0u);
  EXPECT_EQ(occlusion("/left", "/right"), 0u);
  EXPECT_EQ(std::ranges::count(labels.occlusions, 0u), 25 - 3);
}

TEST_P(LabelsTest, OrientedBoxesAndTheirCorners) {
  Scene scene;
  const dmat4 rigid = glm::rotate(glm::translate(dmat4(1), dvec3(0.5, -0.3, 1)), 0.6, glm::normalize(dvec3(1, 2, 3)));
  scene.addInstance(scene.addMesh(square()), scene.addMaterial({}), rowsOf(glm::scale(rigid, dvec3(2, 0.5, 1))),
                    "card");
  Renderer renderer(scene, testDevice());
  const Camera camera = scene.lookAt({1, 2, 8}, {0, 0, 0}, 50);
  const Labels labels = renderer.labels(camera, small(80, 60));
  ASSERT_EQ(labels.objects.size(), 1u);
  const ObjectLabel& card = labels.objects.front();
  const dmat4 toCamera = glm::inverse(matrixOf(camera.cameraToWorld)) * rigid;
  for (int i = 0; i < 4; ++i) {
    EXPECT_LE(glm::length(matrixOf(card.objectToWorld)[i] - rigid[i]), 1e-6);
    EXPECT_LE(glm::length(matrixOf(card.objectToCamera)[i] - toCamera[i]), 1e-6);
  }
  const double focal = 30 / std::tan(25 * 3.14159265358979 / 180);
  for (size_t i = 0; i < 8; ++i) {
    const dvec3 corner(i & 1 ? 2 : -2, i & 2 ? 0.5 : -0.5, 0);
    const dvec3 c(toCamera * glm::dvec4(corner, 1));
    EXPECT_NEAR(card.corners[i][0], 40 + focal * c.x / c.z, 1e-4);
    EXPECT_NEAR(card.corners[i][1], 30 + focal * c.y / c.z, 1e-4);
    EXPECT_NEAR(card.corners[i][2], c.z, 1e-5);
  }
}

// --- outside the image -----------------------------------------------------------------------------------------------

// A camera without a lens is that of a pinhole lens with equal focal lengths.
struct Pinhole {
  double fx, fy, cx, cy;  // in pixels
};

// Returns how many pixels an instantaneous row of a square in the plane z = 0 covers, as [certain, possible]: those
// whose ray hits the plane within the square by 1/50 of a pixel, and those whose ray misses it by at most as much.
std::array<uint64_t, 2> countRow(const SquareAt& place, const dmat4& pose, const Pinhole& k, int64_t row, int64_t first,
                                 int64_t end) {
  std::array<uint64_t, 2> count{};
  const auto hits = [&](dvec2 pixel) {
    const dvec3 direction = glm::dmat3(pose) * dvec3((pixel - dvec2(k.cx, k.cy)) / dvec2(k.fx, k.fy), 1);
    const double t = (place.center.z - pose[3].z) / direction.z;
    const dvec3 at = dvec3(pose[3]) + t * direction - place.center;
    return t > 0 && std::abs(at.x) < place.half.x && std::abs(at.y) < place.half.y;
  };
  for (int64_t x = first; x < end; ++x) {
    int corners = 0;
    for (int corner = 0; corner < 4; ++corner)
      corners += hits({double(x) + 0.5 + (corner & 1 ? 0.02 : -0.02), double(row) + 0.5 + (corner & 2 ? 0.02 : -0.02)});
    count[0] += corners == 4;
    count[1] += corners > 0;
  }
  return count;
}

// Compares `fullPixels` with the pixels of an image three times as large, whose rows have a pose each, and
// `amodalPixels` with those of the image in its center.
void expectCounts(const ObjectLabel& label, const SquareAt& place, const Pinhole& k, int64_t width, int64_t height,
                  const std::function<dmat4(int64_t row)>& poseOf) {
  std::array<uint64_t, 2> full{}, inside{};
  for (int64_t row = -height; row < 2 * height; ++row) {
    const std::array<uint64_t, 2> all = countRow(place, poseOf(row), k, row, -width, 2 * width);
    for (size_t i = 0; i < 2; ++i) full[i] += all[i];
    if (row < 0 || row >= height) continue;
    const std::array<uint64_t, 2> some = countRow(place, poseOf(row), k, row, 0, width);
    for (size_t i = 0; i < 2; ++i) inside[i] += some[i];
  }
  EXPECT_GE(label.fullPixels, full[0]) << place.name;
  EXPECT_LE(label.fullPixels, full[1]) << place.name;
  EXPECT_GE(label.amodalPixels, inside[0]) << place.name;
  EXPECT_LE(label.amodalPixels, inside[1]) << place.name;
  EXPECT_GT(full[0], inside[1]) << place.name << " must cross the border";
  EXPECT_EQ(label.visibleShare, double(label.visiblePixels) / double(label.fullPixels)) << place.name;
}

const SquareAt kFloor{"floor", {1, 0, 0}, {4, 3}}, kCard{"card", {-0.5, -0.6, 0.5}, {0.7, 0.2}};

// A lens with different focal lengths is a pinhole, too, for cameras and for worlds with intrinsics.
TEST_P(LabelsTest, PinholeLensesShowWhatIsOutsideTheImage) {
  constexpr uint32_t kWidth = 80, kHeight = 60;
  const Scene scene = squares({kFloor, kCard});
  Renderer renderer(scene, testDevice());
  for (const auto& [fx, fy] : {std::pair(75.0, 70.0), std::pair(75.0, 75.0)}) {
    const Pinhole k{fx, fy, 35, 33};
    Camera camera = scene.lookAt({0, 0.3, 3}, {0.2, 0, 0}, 50);
    Worlds worlds;
    worlds.count = 1;
    worlds.cameras = {camera};
    worlds.intrinsics = {{k.fx, k.fy, k.cx, k.cy}};
    // The calibration may be that of an image of another size.
    camera.lens = Lens{.width = 2 * kWidth, .height = 2 * kHeight, .fx = 2 * fx, .fy = 2 * fy, .cx = 70, .cy = 66};
    const Options options = small(kWidth, kHeight);
    for (const Labels& labels : {renderer.labels(camera, options), renderer.labels(worlds, options).front()}) {
      ASSERT_EQ(labels.objects.size(), 2u);
      for (const SquareAt& place : {kFloor, kCard})
        expectCounts(labelOf(labels, std::string("/") + place.name), place, k, kWidth, kHeight,
                     [&](int64_t) { return matrixOf(camera.cameraToWorld); });
    }
  }
}

// The rows above and below the image continue the times of its rows.
TEST_P(LabelsTest, RollingShuttersShowWhatIsOutsideTheImage) {
  constexpr uint32_t kWidth = 48, kHeight = 36;
  constexpr double kReadout = 0.1;
  const dvec3 velocity(80, 0, 2);
  // The card is within the image at the picture's time. Its lower rows are shown later, when they are beyond the left
  // edge.
  const SquareAt card{"card", {-0.45, -0.3, 0.5}, {0.6, 0.5}};
  const Scene scene = squares({kFloor, card});
  Renderer renderer(scene, testDevice());
  for (const bool hasLens : {false, true}) {
    Camera camera = scene.lookAt({0, 0, 3}, {0, 0, 0}, 60);
    const double focal = kHeight / 2 / std::tan(30 * 3.14159265358979 / 180);
    const Pinhole k{hasLens ? 28 : focal, focal, kWidth / 2.0, kHeight / 2.0};
    if (hasLens) camera.lens = Lens{.width = kWidth, .height = kHeight, .fx = k.fx, .fy = k.fy, .cx = k.cx, .cy = k.cy};
    const auto at = [&](double seconds) {
      return glm::translate(dmat4(1), seconds * velocity) * matrixOf(camera.cameraToWorld);
    };
    Options options = small(kWidth, kHeight);
    options.framesPerSecond = 10;
    options.readout = kReadout;
    options.previousCameras = options.nextCameras = {camera};
    options.previousCameras.front().cameraToWorld = rowsOf(at(-0.1));
    options.nextCameras.front().cameraToWorld = rowsOf(at(0.1));
    const Labels labels = renderer.labels(camera, options);
    ASSERT_EQ(labels.objects.size(), 2u);
    for (const SquareAt& place : {kFloor, card})
      expectCounts(labelOf(labels, std::string("/") + place.name), place, k, kWidth, kHeight,
                   [&](int64_t row) { return at(((double(row) + 0.5) / kHeight - 0.5) * kReadout); });
  }
}

// --- keypoints -------------------------------------------------------------------------------------------------------

TEST_P(LabelsTest, KeypointsProjectWithTheirVisibility) {
  const Scene scene = squares({{"wall", {0, 0, 0}, {3, 3}}, {"screen", {1.5, 0, 2}, {0.5, 1}}});
  Renderer renderer(scene, testDevice());
  const std::vector<Keypoint> keypoints{{"on the wall", "/wall", {0.2, 0.1, 0}},  // the node's scale is 3, 3, 1
                                        {"behind the screen", "/wall", {0.5, 0, 0}},
                                        {"inside the wall", "/wall", {-0.5, 0, -0.1}},
                                        {"under the skin", "/wall", {-0.5, 0, -0.1}, 0.2},
                                        {"behind the screen, too", "/wall", {0.5, 0, -0.1}, 5},
                                        {"outside", "/wall", {2, 0, 0}},
                                        {"in the air", "/screen", {0, 0, 1}}};
  const std::vector<KeypointLabel> labels = renderer.keypoints(front(), keypoints, small());
  const std::array<std::array<double, 2>, 7> pixels{
      {{36.8, 29.6}, {44, 32}, {20, 32}, {20, 32}, {44, 32}, {80, 32}, {44, 32}}};
  const uint32_t visibility[] = {2, 1, 1, 2, 1, 0, 2};
  ASSERT_EQ(labels.size(), 7u);
  for (size_t i = 0; i < 7; ++i) {
    EXPECT_NEAR(labels[i].pixel[0], pixels[i][0], 1e-5) << keypoints[i].name;
    EXPECT_NEAR(labels[i].pixel[1], pixels[i][1], 1e-5) << keypoints[i].name;
    EXPECT_EQ(labels[i].visibility, visibility[i]) << keypoints[i].name;
  }
  EXPECT_NEAR(labels[6].depth, 7, 1e-6);
  EXPECT_NEAR(labels[2].position[2], -0.1, 1e-6);
}

// The screen is at a depth of 8 m, between the eye and a point of the wall at 10 m.
TEST_P(LabelsTest, PlanesOfTheCameraClipKeypointsAndCorrespondences) {
  const Scene scene = squares({{"wall", {0, 0, 0}, {3, 3}}, {"screen", {0, 0, 2}, {1, 1}}});
  Renderer renderer(scene, testDevice());
  const std::vector<Keypoint> keypoints{{"on the wall", "/wall"}, {"on the screen", "/screen"}};
  struct Planes {
    float near, far;
    std::array<uint32_t, 2> visibility;
    size_t matches;  // pixels of the wall, out of those in the screen's 16 x 16, that the second camera shows
  };
  for (const bool orthographic : {true, false})
    for (const Planes& planes : {Planes{1, 20, {1, 2}, 0}, Planes{9, 20, {2, 0}, 256}, Planes{1, 9, {0, 2}, 0}}) {
      SCOPED_TRACE(testing::Message() << orthographic << planes.near << planes.far);
      Camera camera = front();
      camera.orthographic = orthographic;
      camera.verticalFov = static_cast<float>(2 * std::atan(0.4) * 180 / 3.14159265358979);
      Camera first = camera;
      first.nearClip = 9;
      camera.nearClip = planes.near;
      camera.farClip = planes.far;
      Worlds worlds{.count = 1, .cameras = {camera}};
      for (const auto& labels :
           {renderer.keypoints(camera, keypoints, small()), renderer.keypoints(worlds, keypoints, small()).front()}) {
        EXPECT_EQ(labels.at(0).visibility, planes.visibility[0]);
        EXPECT_EQ(labels.at(1).visibility, planes.visibility[1]);
        EXPECT_NEAR(labels.at(1).depth, 8, 1e-6);
      }
      worlds.cameras = {first};
      worlds.nextCameraToWorld = {camera.cameraToWorld};
      const Correspondence match = renderer.correspond(first, camera, small());
      size_t visible = 0;
      for (uint32_t i = 0; i < 64 * 64; ++i)
        if (std::abs(int(i % 64) * 2 - 63) < 16 && std::abs(int(i / 64) * 2 - 63) < 16) visible += match.visible[i];
      EXPECT_EQ(visible, planes.matches);
      // Both cameras of worlds have the planes of the first.
      const Correspondence own = renderer.correspond(worlds, small()).front();
      EXPECT_EQ(own.visible[32 * 64 + 32], 1);
    }
}

TEST_P(LabelsTest, KeypointsThroughALensAndBehindTheCamera) {
  const Scene scene = squares({{"wall", {0, 0, 0}, {3, 3}}});
  Renderer renderer(scene, testDevice());
  Camera camera = scene.lookAt({0.3, -0.2, 2}, {0, 0, 0}, 60);
  const std::vector<Keypoint> keypoints{{"corner", "/wall", {0.9, 0.8, 0}}, {"behind", "/wall", {0, 0, 4}}};
  const dmat4 toCamera = glm::inverse(matrixOf(camera.cameraToWorld));
  const dvec3 corner(toCamera * glm::dvec4(2.7, 2.4, 0, 1));
  // Kannala and Brandt's equidistant model: the radius is the angle times the focal length.
  camera.lens = Lens{.model = LensModel::Fisheye, .width = 64, .height = 64, .fx = 20, .fy = 22, .cx = 30, .cy = 33};
  Options options = sized(64, 64);
  const std::vector<KeypointLabel> labels = renderer.keypoints(camera, keypoints, options);
  const double radius = std::hypot(corner.x, corner.y), angle = std::atan2(radius, corner.z);
  EXPECT_NEAR(labels[0].pixel[0], 30 + 20 * angle * corner.x / radius, 1e-5);
  EXPECT_NEAR(labels[0].pixel[1], 33 + 22 * angle * corner.y / radius, 1e-5);
  EXPECT_EQ(labels[0].visibility, 2u);
  camera.lens.reset();
  const KeypointLabel behind = renderer.keypoints(camera, keypoints, small())[1];
  EXPECT_TRUE(std::isnan(behind.pixel[0]) && std::isnan(behind.depth));
  EXPECT_EQ(behind.visibility, 0u);
}

// Each row has a time of its own, and a keypoint is where its row shows it. The equation of the row is linear in time
// if the camera and the keypoint move in parallel to the image.
TEST_P(LabelsTest, KeypointsFollowARollingShutter) {
  constexpr uint32_t kWidth = 64, kHeight = 48;
  constexpr double kReadout = 0.1;
  const dvec3 velocity(3, -2, 0);  // of the camera, which looks along -Z with the image's x along +X
  const Scene scene = squares({{"wall", {0, 0, 0}, {9, 9}}, {"screen", {0.9, 0, 2}, {0.3, 2}}});
  Renderer renderer(scene, testDevice());
  const Camera camera = scene.lookAt({0, 0, 5}, {0, 0, 0}, 60);
  const auto movedBy = [&](double seconds) {
    Camera moved = camera;
    moved.cameraToWorld = rowsOf(glm::translate(dmat4(1), seconds * velocity) * matrixOf(camera.cameraToWorld));
    return moved;
  };
  const double focal = kHeight / 2 / std::tan(30 * 3.14159265358979 / 180);
  Options options = small(kWidth, kHeight);
  options.framesPerSecond = 10;
  options.readout = kReadout;
  options.previousCameras = {movedBy(-0.1)};
  options.nextCameras = {movedBy(0.1)};
  std::vector<Keypoint> keypoints;
  for (const double x : {-2.5, 0.0, 1.4, 1.6, 2.0})
    for (const double y : {-2.4, -1.0, 0.0, 1.3, 2.5}) keypoints.push_back({"point", "/wall", {x / 9, y / 9, 0}});
  size_t occluded = 0;
  const std::vector<KeypointLabel> labels = renderer.keypoints(camera, keypoints, options);
  for (size_t i = 0; i < keypoints.size(); ++i) {
    // v = H / 2 - f (y - vy t) / 5 with t = (v / H - 1 / 2) readout
    const dvec3 point = 9.0 * dvec3(keypoints[i].position[0], keypoints[i].position[1], 0);
    const double t = -focal * point.y / 5 / (kHeight / kReadout - focal * velocity.y / 5);
    const double u = kWidth / 2.0 + focal * (point.x - velocity.x * t) / 5,
                 v = kHeight / 2.0 - focal * (point.y - velocity.y * t) / 5;
    EXPECT_NEAR(labels[i].pixel[0], u, 1e-4);
    EXPECT_NEAR(labels[i].pixel[1], v, 1e-4);
    EXPECT_NEAR(labels[i].depth, 5, 1e-5);
    const bool inside = u >= 0 && v >= 0 && u < kWidth && v < kHeight;
    // The line of sight passes the screen's plane at 3/5 of its length.
    const double eye = velocity.x * t, passed = eye + 0.6 * (point.x - eye);
    if (std::abs(std::abs(passed - 0.9) - 0.3) < 0.02) continue;  // near its edges
    EXPECT_EQ(labels[i].visibility, !inside ? 0u : std::abs(passed - 0.9) < 0.3 ? 1u : 2u) << point.x << ' ' << point.y;
    occluded += labels[i].visibility == 1;
  }
  EXPECT_GT(occluded, 3u);
}

// Where the scene moves, the keypoint's node and the surfaces are those of the row's time.
TEST_P(LabelsTest, KeypointsOfMovingNodesFollowARollingShutter) {
  constexpr uint32_t kSize = 64;
  constexpr double kReadout = 0.2;
  Scene scene;
  const Handle<Material> material = scene.addMaterial(Material{.name = "plain", .doubleSided = true});
  scene.addInstance(scene.addMesh(square()), material, rowsOf(glm::scale(dmat4(1), dvec3(9, 9, 1))), "wall");
  NodeData mover{.name = "mover", .parts = {{scene.addMesh(square()), material}}};
  const std::string path = scene.addNode(mover);
  // 0.5 m in front of the wall, from x = -4 m to 4 m and 2 m upward in a second.
  scene.addAnimation(
      "move",
      {{.node = path, .property = AnimatedProperty::Translation, .times = {0, 1}, .values = {-4, -1, 0.5, 4, 1, 0.5}}});
  Renderer renderer(scene, testDevice());
  const Camera camera = scene.lookAt({0, 0, 5.5}, {0, 0, 0}, 60);
  Options options = small(kSize, kSize);
  options.time = 0.5;
  options.animation = "move";
  options.readout = kReadout;
  // Corners of the square, and points of the wall, which is at -Z of the square.
  const std::vector<Keypoint> keypoints{{"up", path, {-0.9, 0.9, 0}},
                                        {"down", path, {0.9, -0.9, 0}},
                                        {"covered", "/wall", {1.2 / 9, -0.1, 0}},
                                        {"open", "/wall", {-1.0 / 9, -0.1, 0}}};
  const std::vector<KeypointLabel> labels = renderer.keypoints(camera, keypoints, options);
  const double focal = kSize / 2 / std::tan(30 * 3.14159265358979 / 180);
  for (size_t i = 0; i < 2; ++i) {
    // v = S / 2 - f (y + 2 t) / 5 with t = (v / S - 1 / 2) readout
    const double x = keypoints[i].position[0], y = keypoints[i].position[1];
    const double t = -focal * y / 5 / (kSize / kReadout + focal * 2 / 5);
    EXPECT_NEAR(labels[i].pixel[0], kSize / 2.0 + focal * (x + 8 * t) / 5, 1e-3);
    EXPECT_NEAR(labels[i].pixel[1], kSize / 2.0 - focal * (y + 2 * t) / 5, 1e-3);
    EXPECT_EQ(labels[i].visibility, 2u);
  }
  // The wall's points are at y = -0.9 and in row 32 + f 0.9 / 5.5 = 41.07, 0.0283 s after the image's time: the square
  // is then at x = 0.227, and covers [-0.85, 1.35] of the wall instead of [-1.1, 1.1], seen from x = 0 at 5.5 m.
  EXPECT_EQ(labels[2].visibility, 1u);
  EXPECT_EQ(labels[3].visibility, 2u);
}

TEST_P(LabelsTest, AKeypointNeedsItsNode) {
  const Scene scene = squares({{"wall", {0, 0, 0}, {1, 1}}});
  Renderer renderer(scene, testDevice());
  try {
    renderer.keypoints(front(), {{"nose", "/face"}}, small());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::Usage);
    EXPECT_STREQ(error.what(),
                 "the keypoint \"nose\" follows the node \"/face\", but the scene has no node with this path");
  }
}

// Lines of sight are rays, which accept the frame "world" only, but the user's frame of the images' normals may differ.
TEST_P(LabelsTest, TheFrameOfNormalsDoesNotMatter) {
  const Scene scene = squares({{"wall", {0, 0, 0}, {3, 3}}, {"screen", {1.5, 0, 2}, {0.5, 1}}});
  Renderer renderer(scene, testDevice());
  for (const char* frame : {"opencv", "opengl"}) {
    Options options = small();
    options.normalFrame = frame;
    const std::vector<KeypointLabel> labels =
        renderer.keypoints(front(), {{"open", "/wall", {0, 0, 0}}, {"occluded", "/wall", {0.5, 0, 0}}}, options);
    EXPECT_EQ(labels[0].visibility, 2u);
    EXPECT_EQ(labels[1].visibility, 1u);
    const auto isCorrespondence = [](const Correspondence& match) {
      EXPECT_EQ(std::ranges::count(match.visible, 1), 48 * 48) << "the wall has 6 x 6 m, with 8 pixels per meter";
      EXPECT_NEAR(match.depth[32 * 64 + 32], 10, 1e-5);
    };
    isCorrespondence(renderer.correspond(front(), front(), options));
    Worlds worlds;
    worlds.count = 1;
    worlds.cameras = {front()};
    isCorrespondence(renderer.correspond(worlds, options).front());
  }
}

// A joint moves with the animation, and the flesh around it does not occlude it.
TEST_P(LabelsTest, JointsAreKeypoints) {
  const Scene scene(models::modelPath("skinned.glb").string());
  Renderer renderer(scene, testDevice());
  std::string joint;
  for (const Node& node : scene.nodes()) joint = node.path.size() > joint.size() ? node.path : joint;  // the last one
  Options options = small(96, 96);
  options.animation = "bend";
  const auto at = [&](double time, double thickness) {
    options.time = time;
    return renderer.keypoints(scene.defaultCamera(1), {{"joint", joint, {0, 0, 0}, thickness}}, options).front();
  };
  EXPECT_GT(std::hypot(at(0.25, 0).pixel[0] - at(0, 0).pixel[0], at(0.25, 0).pixel[1] - at(0, 0).pixel[1]), 2);
  EXPECT_EQ(at(0.25, 0).visibility, 1u);
  EXPECT_EQ(at(0.25, 1).visibility, 2u);
}

// Edits move instances, and joints move with the instances that they deform.
TEST_P(LabelsTest, JointsFollowEditsOfTheirInstances) {
  Scene scene(models::modelPath("skinned.glb").string());
  std::string joint;
  for (const Node& node : scene.nodes()) joint = node.path.size() > joint.size() ? node.path : joint;  // the last one
  const dmat4 turn = glm::rotate(glm::translate(dmat4(1), dvec3(0.5, -0.25, 2)), 0.7, glm::normalize(dvec3(1, 2, 3)));
  Options options = small(96, 96);
  options.animation = "bend";
  options.time = 0.25;
  const Camera camera = scene.defaultCamera(1);
  const auto position = [&] {
    Renderer renderer(scene, testDevice());
    const auto p = renderer.keypoints(camera, {{"joint", joint, {0.1, 0.2, 0.3}}}, options).front().position;
    return dvec3(p[0], p[1], p[2]);
  };
  const dvec3 expected(turn * glm::dvec4(position(), 1));
  for (const Handle<Instance> instance : scene.instances())
    scene.setTransform(instance, rowsOf(turn * matrixOf(scene.instance(instance).transform)));
  EXPECT_LE(glm::length(position() - expected), 1e-6);
}

// --- correspondence --------------------------------------------------------------------------------------------------

struct PixelRay {
  dvec3 origin, direction;
};

PixelRay rayOf(const Camera& camera, dvec2 pixel, dvec2 size) {
  const dmat4 pose = matrixOf(camera.cameraToWorld);
  const double focal = size.y / 2 / std::tan(camera.verticalFov * 3.14159265358979 / 360);
  return {dvec3(pose[3]), glm::dmat3(pose) * dvec3((pixel - size / 2.0) / focal, 1)};
}

// A floor and a square above it. Each pixel's point follows from the planes, and its visibility in the other picture
// from whether the line of sight passes the square.
TEST_P(LabelsTest, CorrespondenceOfTwoCameras) {
  constexpr uint32_t kWidth = 64, kHeight = 48;
  const dvec2 size(kWidth, kHeight);
  const Scene scene = squares({{"floor", {0, 0, 0}, {30, 30}}, {"card", {0.2, 0.1, 1}, {0.7, 0.5}}});
  Renderer renderer(scene, testDevice());
  const Camera first = scene.lookAt({-1, 0.5, 6}, {0, 0, 0}, 40),
               second = scene.lookAt({1.5, -0.7, 5}, {0.3, 0, 0}, 45);
  const Correspondence match = renderer.correspond(first, second, small(kWidth, kHeight));
  const dmat4 toSecond = glm::inverse(matrixOf(second.cameraToWorld));
  const dvec3 eye(matrixOf(second.cameraToWorld)[3]);
  const double focal = size.y / 2 / std::tan(second.verticalFov * 3.14159265358979 / 360);
  const auto onCard = [](dvec3 p, double slack) {
    return std::abs(p.x - 0.2) < 0.7 + slack && std::abs(p.y - 0.1) < 0.5 + slack;
  };
  size_t occluded = 0, visible = 0;
  for (uint32_t i = 0; i < kWidth * kHeight; ++i) {
    const PixelRay ray = rayOf(first, dvec2(i % kWidth, i / kWidth) + 0.5, size);
    const auto meet = [](const PixelRay& r, double z) {
      return r.origin + r.direction * ((z - r.origin.z) / r.direction.z);
    };
    const dvec3 above = meet(ray, 1);
    if (onCard(above, 0.02) != onCard(above, -0.02)) continue;  // near the card's edge
    const bool onFloor = !onCard(above, 0);
    const dvec3 point = onFloor ? meet(ray, 0) : above;
    const dvec3 c(toSecond * glm::dvec4(point, 1));
    const dvec2 pixel = size / 2.0 + focal * dvec2(c) / c.z;
    EXPECT_NEAR(match.pixels[i][0], pixel.x, pixelTolerance());
    EXPECT_NEAR(match.pixels[i][1], pixel.y, pixelTolerance());
    EXPECT_NEAR(match.depth[i], c.z, 1e-4);
    EXPECT_EQ(match.flow[i], (std::array<float, 3>{0, 0, 0}));
    const dvec3 between = meet({eye, point - eye}, 1);
    if (onFloor && onCard(between, 0.02) != onCard(between, -0.02)) continue;
    const bool inside = pixel.x >= 0 && pixel.y >= 0 && pixel.x < size.x && pixel.y < size.y;
    const bool hidden = onFloor && onCard(between, 0);
    EXPECT_EQ(match.visible[i], inside && !hidden);
    occluded += inside && hidden;
    visible += match.visible[i];
  }
  EXPECT_GT(occluded, 50u);
  EXPECT_GT(visible, 1000u);
}

// Between two times of one camera, it is the output motion plus visibility.
TEST_P(LabelsTest, CorrespondenceInTimeIsMotion) {
  const Scene scene(models::modelPath("skinned.glb").string());
  Renderer renderer(scene, testDevice());
  Options options = small(64, 64);
  options.animation = "bend";
  options.time = 0.3;
  options.framesPerSecond = 10;
  const Camera camera = scene.defaultCamera(1);
  const Correspondence match = renderer.correspond(camera, camera, options, 0.4);
  options.aovs = {"motion", "id", "scene-flow"};
  options.picture = false;
  const Frame frame = renderer.render(camera, options);
  double longest = 0;
  for (size_t i = 0; i < 64 * 64; ++i) {
    const bool drawn = frame.aovs.at("id").ids[i] != 0;
    EXPECT_EQ(std::isnan(match.pixels[i][0]), !drawn);
    if (!drawn) continue;
    const float* motion = &frame.aovs.at("motion").values[4 * i];
    const dvec2 moved = dvec2(match.pixels[i][0], match.pixels[i][1]) - (dvec2(i % 64, i / 64) + 0.5);
    EXPECT_NEAR(moved.x, motion[2], 2 * pixelTolerance());  // each of them is interpolated
    EXPECT_NEAR(moved.y, motion[3], 2 * pixelTolerance());
    for (size_t k = 0; k < 3; ++k) EXPECT_EQ(match.flow[i][k], frame.aovs.at("scene-flow").values[3 * i + k]);
    longest = std::max(longest, glm::length(moved));
  }
  EXPECT_GT(longest, 1);
  EXPECT_GT(std::ranges::count(match.visible, 1), 100);
  EXPECT_THROW(renderer.correspond(camera, camera, small(), 0.4), Error);
}

INSTANTIATE_TEST_SUITE_P(Rasters, LabelsTest, testing::Values("hardware", "compute"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace latelight::test
