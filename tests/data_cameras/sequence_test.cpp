// The order of cameras, and the image sizes and camera models that come from sources other than their files.
#include "data/cameras/colmap.h"
#include "data/cameras/transforms.h"
#include "data_cameras/support.h"

namespace latelight::data::test {
namespace {

using testing::ElementsAre;

std::vector<int> placesOf(const std::vector<JobCamera>& cameras, std::optional<size_t> SequencePosition::*neighbor) {
  std::vector<int> places;
  for (const JobCamera& camera : cameras) {
    const std::optional<size_t> place = camera.sequence ? (*camera.sequence).*neighbor : std::nullopt;
    places.push_back(place ? static_cast<int>(*place) : -1);
  }
  return places;
}
std::vector<int> nextsOf(const std::vector<JobCamera>& cameras) {
  return placesOf(cameras, &SequencePosition::next);
}
std::vector<int> previousOf(const std::vector<JobCamera>& cameras) {
  return placesOf(cameras, &SequencePosition::previous);
}
std::vector<double> secondsOf(const std::vector<JobCamera>& cameras) {
  std::vector<double> seconds;
  for (const JobCamera& camera : cameras) seconds.push_back(camera.sequence->seconds.value_or(-1));
  return seconds;
}

constexpr const char* kOrbit = R"({"type": "orbit", "count": 3, "distance": 20})";

TEST(SequenceTest, EachSourceIsOneOfItsOwn) {
  const auto cameras = made(fmt::format(R"([{{"type": "list", "cameras": [{{"eye": [0, 0, 5]}}]}}, {0},
      {{"type": "sphere", "count": 2, "radius": 20}}, {0}])",
                                        kOrbit));
  ASSERT_EQ(cameras.size(), 9u);
  EXPECT_THAT(nextsOf(cameras), ElementsAre(-1, 2, 3, -1, -1, -1, 7, 8, -1));
  EXPECT_THAT(previousOf(cameras), ElementsAre(-1, -1, 1, 2, -1, -1, -1, 6, 7));
  EXPECT_FALSE(cameras[0].sequence);
  EXPECT_EQ(cameras[8].sequence->number, 2u);
  EXPECT_FALSE(cameras[8].sequence->seconds);
}

TEST(SequenceTest, MembersOfARigKeepToThemselves) {
  const auto cameras = made(fmt::format(R"([{0}, {{"type": "rig", "cameras": {{"type": "stereo", "baseline": 0.1,
      "cameras": {0}}}, "offsets": [
          {{"name": "a", "translation": [0, 0, 0]}}, {{"name": "b", "translation": [1, 0, 0]}}]}}])",
                                        kOrbit));
  ASSERT_EQ(cameras.size(), 3u + 12u);
  // Four members at each of three poses.
  EXPECT_THAT(nextsOf(cameras), ElementsAre(1, 2, -1, 7, 8, 9, 10, 11, 12, 13, 14, -1, -1, -1, -1));
  EXPECT_THAT(previousOf(cameras), ElementsAre(-1, 0, 1, -1, -1, -1, -1, 3, 4, 5, 6, 7, 8, 9, 10));
}

TEST(SequenceTest, PathsAndTrajectoriesHaveTimes) {
  const char* timed = R"({"type": "path", "count": 3, "keys": [{"time": 4, "eye": [0, 0, 5], "target": [0, 0, 0]},
      {"time": 5, "eye": [1, 0, 5], "target": [1, 0, 0]}]})";
  EXPECT_THAT(secondsOf(made(timed)), ElementsAre(0, 0.5, 1));
  const std::string keys =
      R"("keys": [{"eye": [0, 0, 5], "target": [0, 0, 0]}, {"eye": [1, 0, 5], "target": [1, 0, 0]}]})";
  EXPECT_THAT(secondsOf(made(R"({"type": "path", "fps": 2, )" + keys)), ElementsAre(0, 0.5, 1));
  EXPECT_THAT(secondsOf(made(R"({"type": "path", "count": 3, )" + keys)), ElementsAre(-1, -1, -1));
  const Folder folder;
  folder.write("tum.txt", std::string_view("12.25 0 0 0 0 0 0 1\n12 1 0 0 0 0 0 1\n13.5 2 0 0 0 0 0 1\n"));
  const auto cameras = made(R"({"type": "tum", "file": ")" + folder.at("tum.txt") + "\"}");
  EXPECT_THAT(secondsOf(cameras), ElementsAre(0, 0.25, 1.5));
  expectNear(eyeOf(cameras[0]), {1, 0, 0}, 1e-6);  // ordered by time, whatever the order in the file
}

TEST(SequenceTest, ImagesOfColmapAreInTheOrderOfTheirNames) {
  const Folder folder;
  folder.write("cameras.txt", std::string_view("1 PINHOLE 4 4 1 1 2 2\n"));
  std::string images;
  for (const char* name : {"b/10.png", "a/2.png", "b/9.png", "a/010.png", "a/1.png"})
    images += fmt::format("7 1 0 0 0 0 0 0 1 {}\n\n", name);
  folder.write("images.txt", std::string_view(images));
  const auto cameras = made(R"({"type": "colmap", "folder": ")" + folder.path().string() + "\"}");
  std::vector<std::string> names;
  for (const JobCamera& camera : cameras) names.push_back(camera.name);
  EXPECT_THAT(names, ElementsAre("a_1", "a_2", "a_010", "b_9", "b_10"));
  EXPECT_THAT(nextsOf(cameras), ElementsAre(1, 2, -1, 4, -1));
}

// --- sizes ----------------------------------------------------------------------------------------------------------

const std::string kOneFrame =
    R"("frames": [{"transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]]}]})";

// 2 atan(0.5) across 80 pixels is a focal length of 80 pixels.
TEST(SizeTest, IsTheJobsWhereAFileDoesNotSayIt) {
  const Folder folder;
  folder.write("t.json", R"({"camera_angle_x": 0.9272952180016122, )" + kOneFrame);
  folder.write("b.json", std::string_view(R"({"1": {"cam_K": [80, 0, 39.5, 0, 80, 29.5, 0, 0, 1],
      "cam_R_w2c": [1, 0, 0, 0, 1, 0, 0, 0, 1], "cam_t_w2c": [0, 0, 0]}})"));
  const std::string specs[] = {
      R"({"type": "transforms", "file": ")" + folder.at("t.json") + "\"}",
      R"({"type": "bop", "file": ")" + folder.at("b.json") + "\"}",
      R"({"type": "list", "K": [[80, 0, 40], [0, 80, 30], [0, 0, 1]], "cameras": [{"eye": [0, 0, 5]}]})",
      R"({"type": "rig", "cameras": {"type": "list", "cameras": [{"eye": [0, 0, 5]}]}, "offsets": [
          {"name": "a", "translation": [0, 0, 0], "K": [[80, 0, 40], [0, 80, 30], [0, 0, 1]]}]})"};
  for (const std::string& spec : specs) {
    SCOPED_TRACE(spec);
    const auto cameras = makeCameras(Json::parse(spec), boxes(), 1, {.size = {80, 60}});
    EXPECT_EQ(cameras[0].width, 80u);
    EXPECT_EQ(cameras[0].height, 60u);
    EXPECT_NEAR(cameras[0].camera.verticalFov, 2 * std::atan(30.0 / 80), 1e-6);
  }
  EXPECT_THAT(errorOf([&] { made(specs[0]); }, ExitCode::BadInput), testing::HasSubstr("among the job's options"));
  for (const size_t i : {1, 2})
    EXPECT_THAT(errorOf([&] { made(specs[i]); }), testing::HasSubstr("among the job's options"));
}

// --- models ---------------------------------------------------------------------------------------------------------

// COLMAP's models without distortion: a fisheye camera projects an angle t from the axis to a distance of f t from the
// principal point.
TEST(ModelsTest, ColmapsFisheyesWithoutDistortionAreEquidistant) {
  const Folder folder;
  folder.write("images.txt", std::string_view("1 1 0 0 0 0 0 0 1 a.png\n\n"));
  for (const std::string line : {"SIMPLE_FISHEYE 64 48 20 32 24", "FISHEYE 64 48 20 20 32 24"}) {
    folder.write("cameras.txt", "1 " + line + "\n");
    const scene::Lens lens = *readColmap(folder.path())[0].lens;
    EXPECT_EQ(lens.model, scene::LensModel::Fisheye);
    for (const double angle : {0.3, 1.0, 1.5}) {
      const auto pixel = scene::LensProjection(lens).project({std::sin(angle), 0, std::cos(angle)});
      ASSERT_TRUE(pixel);
      EXPECT_NEAR(pixel->x, 32 + 20 * angle, 1e-9) << line;
      EXPECT_NEAR(pixel->y, 24, 1e-9);
    }
  }
  folder.write("cameras.txt", std::string_view("1 FISHEYE 64 48 20 21 32 24\n"));
  EXPECT_EQ(readColmap(folder.path())[0].lens->fy, 21);
}

TEST(ModelsTest, ColmapsEquirectangularPicturesAreOurs) {
  const Folder folder;
  folder.write("images.txt", std::string_view("1 1 0 0 0 0 0 0 1 a.png\n\n"));
  folder.write("cameras.txt", std::string_view("1 EQUIRECTANGULAR 64 32 64 32\n"));
  const scene::Lens lens = *readColmap(folder.path())[0].lens;
  EXPECT_EQ(lens.model, scene::LensModel::Equirectangular);
  const auto pixel = scene::LensProjection(lens).project({1, 0, 0});  // a quarter turn to the right
  EXPECT_NEAR(pixel->x, 48, 1e-9);
  folder.write("cameras.txt", std::string_view("1 EQUIRECTANGULAR 64 32 32 16\n"));
  EXPECT_THAT(errorOf([&] { readColmap(folder.path()); }, ExitCode::BadInput), testing::HasSubstr("must be the size"));
  for (const std::string refused : {"SIMPLE_DIVISION 4 5 1 2 3 4", "DIVISION 4 5 1 2 3 4 5", "EUCM 4 5 1 2 3 4 5 6"}) {
    folder.write("cameras.txt", "1 " + refused + "\n");
    EXPECT_THAT(errorOf([&] { readColmap(folder.path()); }, ExitCode::BadInput),
                testing::HasSubstr("COLMAP's model " + refused.substr(0, refused.find(' ')) + ", which"));
  }
}

TEST(ModelsTest, NerfstudiosRadialOnesAreOpenCvs) {
  const Folder folder;
  const auto lens = [&](const std::string& keys) {
    folder.write("t.json", R"({"w": 64, "h": 48, "fl_x": 50, )" + keys + ", " + kOneFrame);
    return *readTransforms(folder.at("t.json"))[0].lens;
  };
  EXPECT_EQ(lens(R"("camera_model": "SIMPLE_RADIAL")").model, scene::LensModel::Pinhole);
  EXPECT_THAT(lens(R"("camera_model": "SIMPLE_RADIAL", "k1": 0.1)").distortion, ElementsAre(0.1, 0, 0, 0, 0, 0, 0, 0));
  const scene::Lens radial = lens(R"("camera_model": "RADIAL", "k1": 0.1, "k2": 0.2)");
  EXPECT_EQ(radial.model, scene::LensModel::OpenCv);
  // OpenCV's model: x (1 + k1 r^2 + k2 r^4) for the point (x, y) at depth 1.
  const auto pixel = scene::LensProjection(radial).project({0.5, 0, 1});
  EXPECT_NEAR(pixel->x, 32 + 50 * 0.5 * (1 + 0.1 * 0.25 + 0.2 * 0.0625), 1e-9);
  for (const char* model : {"SIMPLE_PINHOLE", "PINHOLE", "OPENCV", "OPENCV_FISHEYE", "EQUIRECTANGULAR"})
    EXPECT_GT(lens(fmt::format(R"("camera_model": "{}")", model)).width, 0) << model;
  EXPECT_EQ(lens(R"("is_fisheye": true)").model, scene::LensModel::Fisheye);  // keys of instant-ngp
  EXPECT_EQ(lens(R"("latlong": true)").model, scene::LensModel::Equirectangular);
  EXPECT_THAT(errorOf([&] { lens(R"("camera_model": "FISHEYE624")"); }, ExitCode::BadInput),
              testing::HasSubstr("give OPENCV, SIMPLE_RADIAL, RADIAL"));
}

}  // namespace
}  // namespace latelight::data::test
