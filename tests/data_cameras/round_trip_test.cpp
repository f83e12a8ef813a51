// Cameras are unchanged after they are written and read back.
#include <fmt/format.h>

#include "data/cameras/bop.h"
#include "data/cameras/colmap.h"
#include "data/cameras/transforms.h"
#include "data/cameras/tum.h"
#include "data/random.h"
#include "data_cameras/support.h"

namespace latelight::data::test {
namespace {

using enum scene::LensModel;

scene::Lens anyLens(scene::LensModel model, Random& random) {
  scene::Lens lens{.model = model, .width = 640.0 + random.below(9), .height = 480.0 + random.below(9)};
  lens.fx = random.between(100, 2000), lens.fy = random.between(100, 2000);
  lens.cx = random.between(0, 640), lens.cy = random.between(0, 480);
  const size_t terms = model == OpenCv ? 5 : model == Fisheye ? 4 : 0;
  for (size_t i = 0; i < terms; ++i) lens.distortion[i] = random.between(-1, 1);
  return lens;
}

// Rotations of all kinds, including half turns, and positions near and far.
dmat4 anyPose(uint64_t number, Random& random) {
  dvec4 q(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
  if (number % 4 == 0) q[0] = 0;
  if (number % 8 == 0) q = dvec4(0), q[1 + number / 8 % 3] = 1;
  dmat4 pose(rotationOf(q));
  const double reach = number % 3 == 0 ? 1e4 : 1;
  for (int axis = 0; axis < 3; ++axis) pose[3][axis] = random.between(-reach, reach);
  return pose;
}

std::vector<CalibratedCamera> anyCameras(const std::vector<scene::LensModel>& models) {
  std::vector<CalibratedCamera> cameras;
  for (uint64_t i = 0; i < 200; ++i) {
    Random random(5, i, "round trip");
    const scene::Lens lens = i % 5 == 4 ? *cameras.back().lens : anyLens(models[random.below(models.size())], random);
    cameras.push_back({fmt::format("{}", 1000 + i), lens, anyPose(i, random)});
    if (i % 3 == 1) cameras.back().exposure = {.shutter = random.between(0, 1), .readout = random.between(-1, 1)};
    if (i % 4 == 1) cameras.back().exposure.noiseSeed = random.below(1000);
    if (i % 5 == 1) cameras.back().exposure.ev = random.between(-20, 20);
  }
  return cameras;
}

void expectSame(const std::vector<CalibratedCamera>& actual, const std::vector<CalibratedCamera>& expected,
                bool lenses = true, bool exposures = false) {
  ASSERT_EQ(actual.size(), expected.size());
  for (size_t i = 0; i < actual.size(); ++i) {
    EXPECT_EQ(actual[i].name, expected[i].name);
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 4; ++row)
        EXPECT_NEAR(actual[i].pose[column][row], expected[i].pose[column][row],
                    1e-9 * std::max(1.0, glm::length(dvec3(expected[i].pose[3]))))
            << i;
    if (exposures) {
      EXPECT_EQ(actual[i].exposure, expected[i].exposure) << i;
    }
    if (!lenses) continue;
    const scene::Lens &a = *actual[i].lens, &b = *expected[i].lens;
    EXPECT_EQ(a.model, b.model);
    EXPECT_EQ(a.width, b.width);
    EXPECT_EQ(a.height, b.height);
    for (const auto member : {&scene::Lens::fx, &scene::Lens::fy, &scene::Lens::cx, &scene::Lens::cy})
      EXPECT_EQ(a.*member, b.*member);
    EXPECT_EQ(a.distortion, b.distortion);
  }
}

TEST(RoundTripTest, Transforms) {
  const Folder folder;
  const auto cameras = anyCameras({Pinhole, OpenCv, Fisheye});
  writeTransforms(folder.path() / "transforms.json", cameras);
  expectSame(readTransforms(folder.at("transforms.json")), cameras, true, true);
  auto alike = cameras;
  for (CalibratedCamera& camera : alike) camera.lens = cameras[1].lens;
  writeTransforms(folder.path() / "alike.json", alike);
  expectSame(readTransforms(folder.at("alike.json")), alike);
  EXPECT_LT(folder.read("alike.json").size(), folder.read("transforms.json").size());
}

TEST(RoundTripTest, TransformsAllAround) {
  const Folder folder;
  const std::vector<CalibratedCamera> camera{
      {"pano.png", scene::Lens{.model = Equirectangular, .width = 200, .height = 100}, dmat4(1)}};
  writeTransforms(folder.path() / "t.json", camera);
  expectSame(readTransforms(folder.at("t.json")), camera);
  const Json json = Json::parse(folder.read("t.json"));  // as nerfstudio's rays need them
  EXPECT_EQ(json["fl_x"], 100);
  EXPECT_EQ(json["fl_y"], 100);
  EXPECT_EQ(json["cx"], 100);
  EXPECT_EQ(json["cy"], 50);
}

TEST(RoundTripTest, Colmap) {
  auto cameras = anyCameras({Pinhole, OpenCv, Fisheye});
  cameras[3].lens->model = OpenCv;
  cameras[3].lens->distortion = {1, 2, 3, 4, 5, 6, 7, 8};
  const Folder text, binary;
  writeColmapText(text.path(), cameras);
  writeColmapBinary(binary.path(), cameras);
  EXPECT_THAT(text.names(), testing::ElementsAre("cameras.txt", "images.txt", "points3D.txt"));
  EXPECT_THAT(binary.names(), testing::ElementsAre("cameras.bin", "images.bin", "points3D.bin"));
  expectSame(readColmap(text.path()), cameras);
  expectSame(readColmap(binary.path()), cameras);
}

TEST(RoundTripTest, Tum) {
  const Folder folder;
  const auto cameras = anyCameras({Pinhole});
  writeTum(folder.path() / "poses.txt", cameras);
  expectSame(readTum(folder.at("poses.txt")), cameras, false);
}

TEST(RoundTripTest, Bop) {
  const Folder folder;
  auto cameras = anyCameras({Pinhole});
  for (CalibratedCamera& camera : cameras) camera.lens->width = 640, camera.lens->height = 480;
  writeBop(folder.path() / "scene_camera.json", cameras, 0.1);
  expectSame(readBop(folder.at("scene_camera.json"), {640, 480}), cameras, true, true);
  EXPECT_EQ(Json::parse(folder.read("scene_camera.json"))["1000"]["depth_scale"], 0.1);
}

TEST(RoundTripTest, WhatAFormatCantHoldIsRefused) {
  const Folder folder;
  std::vector<CalibratedCamera> camera{{"a", scene::Lens{.model = CubeMap, .width = 6, .height = 1}, dmat4(1)}};
  const auto refused = [&](const auto& write) { EXPECT_THAT(errorOf([&] { write(); }), testing::HasSubstr("\"a\"")); };
  refused([&] { writeTransforms(folder.path() / "t.json", camera); });
  refused([&] { writeColmapText(folder.path(), camera); });
  refused([&] { writeColmapBinary(folder.path(), camera); });
  refused([&] { writeBop(folder.path() / "b.json", camera, 1); });
  refused([&] { writeTum(folder.path() / "t.txt", camera); });
  camera[0].lens->model = OpenCv;
  camera[0].lens->distortion[6] = 1;
  refused([&] { writeTransforms(folder.path() / "t.json", camera); });
  EXPECT_THAT(folder.names(), testing::IsEmpty());
}

}  // namespace
}  // namespace latelight::data::test
