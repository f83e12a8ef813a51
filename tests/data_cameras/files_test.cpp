// Files of cameras, written by hand according to the specifications of the formats.

#include "data/cameras/bop.h"
#include "data/cameras/calibrated.h"
#include "data/cameras/colmap.h"
#include "data/cameras/transforms.h"
#include "data/cameras/tum.h"
#include "data_cameras/support.h"

namespace latelight::data::test {
namespace {

using testing::ElementsAre;
using enum scene::LensModel;

// The axes of a camera (right, down, forward) and its position.
void expectPose(const dmat4& pose, dvec3 right, dvec3 down, dvec3 away, dvec3 eye) {
  expectNear(dvec3(pose[0]), right, 1e-12);
  expectNear(dvec3(pose[1]), down, 1e-12);
  expectNear(dvec3(pose[2]), away, 1e-12);
  expectNear(dvec3(pose[3]), eye, 1e-12);
}

TEST(TransformsTest, ReadsNerfstudios) {
  const Folder folder;
  folder.write("transforms.json", R"({
    "camera_model": "OPENCV", "w": 640, "h": 480, "fl_x": 500, "fl_y": 510, "cx": 320.5, "cy": 239,
    "k1": 0.1, "k2": 0.2, "k3": 0.3, "p1": 0.01, "p2": 0.02,
    "frames": [
      {"file_path": "./images/0001.png", "transform_matrix": [[1, 0, 0, 7], [0, 1, 0, 8], [0, 0, 1, 9], [0, 0, 0, 1]]},
      {"file_path": "images/0002.png", "camera_model": "OPENCV_FISHEYE", "k4": 0.4, "fl_x": 600,
       "transform_matrix": [[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]}]})");
  const auto cameras = readTransforms(folder.at("transforms.json"));
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[0].name, "./images/0001.png");
  // OpenGL's camera: without rotation it looks along -Z, with Y up.
  expectPose(cameras[0].pose, {1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {7, 8, 9});
  expectPose(cameras[1].pose, {0, 0, -1}, {0, -1, 0}, {-1, 0, 0}, {0, 0, 0});
  const scene::Lens& lens = *cameras[0].lens;
  EXPECT_EQ(lens.model, OpenCv);
  EXPECT_EQ(lens.fy, 510);
  EXPECT_EQ(lens.cx, 320.5);
  EXPECT_THAT(lens.distortion, ElementsAre(0.1, 0.2, 0.01, 0.02, 0.3, 0, 0, 0));
  EXPECT_EQ(cameras[1].lens->model, Fisheye);
  EXPECT_EQ(cameras[1].lens->fx, 600);
  EXPECT_EQ(cameras[1].lens->fy, 510);
  EXPECT_THAT(cameras[1].lens->distortion, ElementsAre(0.1, 0.2, 0.3, 0.4, 0, 0, 0, 0));
}

TEST(TransformsTest, ReadsAnglesOfView) {
  // Like the synthetic scenes of NeRF: one angle for the width, and no size.
  const Folder folder;
  folder.write("transforms.json", R"({"camera_angle_x": 1.5707963267948966, "frames": [{"file_path": "r_0",
      "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]]}]})");
  const auto cameras = readTransforms(folder.at("transforms.json"), {800, 400});
  EXPECT_EQ(cameras[0].lens->model, Pinhole);
  EXPECT_NEAR(cameras[0].lens->fx, 400, 1e-9);
  EXPECT_NEAR(cameras[0].lens->fy, 400, 1e-9);
  EXPECT_EQ(cameras[0].lens->cy, 200);
  errorOf([&] { readTransforms(folder.at("transforms.json")); }, ExitCode::BadInput);
  const auto placed = made(R"({"type": "transforms", "size": [800, 400], "axes": "z-up", "file": ")" +
                           folder.at("transforms.json") + "\"}");
  EXPECT_EQ(placed[0].name, "r_0");
  EXPECT_EQ(placed[0].width, 800u);
  expectNear(eyeOf(placed[0]), {0, 4, 0}, 1e-6);  // Z up becomes Y up in the scene
  EXPECT_NEAR(placed[0].camera.verticalFov, 2 * std::atan(0.5), 1e-6);
}

TEST(TransformsTest, RefusesWhatNoLensHolds) {
  const Folder folder;
  const auto reads = [&](const std::string& keys, const std::string& focal = R"("fl_x": 4, )") {
    folder.write("t.json", R"({"w": 4, "h": 4, )" + focal + keys +
                               R"(, "frames": [{"transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})");
    return errorOf([&] { readTransforms(folder.at("t.json")); }, ExitCode::BadInput);
  };
  EXPECT_THAT(reads(R"("camera_model": "OPENCV", "k4": 0.1)"), testing::HasSubstr("k4"));
  EXPECT_THAT(reads(R"("camera_model": "ORTHOPHOTO")"), testing::HasSubstr("ORTHOPHOTO"));
  EXPECT_THAT(reads(R"("fl_y": -2)"), testing::HasSubstr("focal length of -2"));
  EXPECT_THAT(reads(R"("cx": "middle")"), testing::HasSubstr("\"cx\" must be a finite number"));
  EXPECT_THAT(reads(R"("fl_x": 0)", ""), testing::HasSubstr("focal length of 0"));
  EXPECT_THAT(reads(R"("cx": 2)", ""), testing::HasSubstr("neither \"fl_x\" nor \"camera_angle_x\""));
}

TEST(TransformsTest, ReadsExposures) {
  const Folder folder;
  const auto write = [&](const std::string& all, const std::string& first) {
    const std::string pose = R"("transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]])";
    folder.write("t.json",
                 R"({"w": 4, "h": 4, "fl_x": 4, )" + all + R"("frames": [{)" + first + pose + "}, {" + pose + "}]}");
    return folder.at("t.json");
  };
  const auto cameras = readTransforms(
      write(R"("shutter": 0.02, "readout": -0.01, )", R"("shutter": 0.5, "noiseSeed": 9007199254740992, )"));
  EXPECT_EQ(cameras[0].exposure, (CameraExposure{.shutter = 0.5, .readout = -0.01, .noiseSeed = uint64_t{1} << 53}));
  EXPECT_EQ(cameras[1].exposure, (CameraExposure{.shutter = 0.02, .readout = -0.01}));
  // The file's values replace the source's, which replace the job's options.
  const auto placed = made(R"({"type": "transforms", "shutter": 1, "noiseSeed": 7, "file": ")" +
                           write("", R"("shutter": 0.5, )") + "\"}");
  EXPECT_EQ(placed[0].exposure, (CameraExposure{.shutter = 0.5, .noiseSeed = 7}));
  EXPECT_EQ(placed[1].exposure, (CameraExposure{.shutter = 1, .noiseSeed = 7}));
  const auto stops = readTransforms(write(R"("EV": -2, )", R"("shutter": 0.02, "ISO": 200, "fNumber": 2, "EV": 1, )"));
  EXPECT_DOUBLE_EQ(stops[0].exposure.ev.value(), 1 + std::log2(0.02 * 200 / 400));
  EXPECT_EQ(stops[1].exposure, (CameraExposure{.ev = -2}));
  const auto sentence = [&](const std::string& all, const std::string& first) {
    const std::string file = write(all, first);
    return errorOf([&] { readTransforms(file); }, ExitCode::BadInput);
  };
  EXPECT_THAT(sentence("", R"("ISO": 200, )"),
              testing::HasSubstr("\"ISO\" and \"fNumber\" require each other and \"shutter\""));
  EXPECT_THAT(sentence("", R"("EV": 61, )"), testing::HasSubstr("\"EV\" must be a number from -60 to 60, not 61"));
  EXPECT_THAT(sentence("", R"("EV": 60, "ISO": 1e7, "fNumber": 1, "shutter": 1, )"),
              testing::HasSubstr("the exposure must be from -60 to 60 stops, not 76.6"));
  EXPECT_EQ(sentence("", R"("shutter": -1, )"),
            "frame 0 of " + folder.at("t.json") + ": \"shutter\" must be a number from 0 to 10000, not -1");
  EXPECT_EQ(sentence(R"("readout": 1e5, )", ""),
            folder.at("t.json") + ": \"readout\" must be a number from -10000 to 10000, not 100000");
  EXPECT_THAT(sentence("", R"("noiseSeed": 1.5, )"), testing::HasSubstr("must be a whole number, not 1.5"));
  EXPECT_THAT(sentence("", R"("noiseSeed": -1, )"), testing::HasSubstr("\"noiseSeed\" must be a number from 0"));
  EXPECT_THAT(sentence("", R"("shutter": "1/50", )"), testing::HasSubstr("\"shutter\" must be a finite number"));
}

// The example from COLMAP's page "Output Format".
constexpr const char* kCamerasText = R"(# Camera list with one line of data per camera:
#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]
# Number of cameras: 3
1 SIMPLE_PINHOLE 3072 2304 2559.81 1536 1152
2 PINHOLE 3072 2304 2560.56 2560.56 1536 1152
3 SIMPLE_RADIAL 3072 2304 2559.69 1536 1152 -0.0218531
)";
constexpr const char* kImagesText = R"(# Image list with two lines of data per image:
#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME
#   POINTS2D[] as (X, Y, POINT3D_ID)
# Number of images: 2, mean observations per image: 2
1 0.851773 0.0165051 0.503764 -0.142941 -0.737434 1.02973 3.74354 1 P1180141.JPG
2362.39 248.498 58396 1784.7 268.254 59027 1784.7 268.254 -1
2 0.851773 0.0165051 0.503764 -0.142941 -0.737434 1.02973 3.74354 3 left eye/P1180142.JPG

)";

TEST(ColmapTest, ReadsTheExampleOfItsPage) {
  const Folder folder;
  folder.write("cameras.txt", kCamerasText);
  folder.write("images.txt", kImagesText);
  const auto cameras = readColmap(folder.path());
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[1].name, "left eye/P1180142.JPG");
  EXPECT_EQ(cameras[0].lens->fy, 2559.81);
  EXPECT_EQ(cameras[1].lens->model, OpenCv);
  EXPECT_EQ(cameras[1].lens->distortion[0], -0.0218531);
  // "The coordinates of the projection/camera center are given by -R^t * T", and R X + T is a point in the camera
  // frame, "whose X axis points to the right, the Y axis to the bottom, and the Z axis to the front".
  const double w = 0.851773, x = 0.0165051, y = 0.503764, z = -0.142941, n = w * w + x * x + y * y + z * z;
  const dvec3 v(x, y, z), t(-0.737434, 1.02973, 3.74354);
  const auto turned = [&](dvec3 p) { return p + 2.0 / n * glm::cross(v, glm::cross(v, p) + w * p); };
  for (const dvec3 p : {dvec3(0), dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1)})
    expectNear(dvec3(glm::inverse(cameras[0].pose) * dvec4(p, 1)), turned(p) + t, 1e-12);
}

template <typename T>
void put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

TEST(ColmapTest, ReadsBinaryFiles) {
  std::string cameras, images;
  put<uint64_t>(cameras, 2);
  put<uint32_t>(cameras, 9), put<int32_t>(cameras, 5), put<uint64_t>(cameras, 64), put<uint64_t>(cameras, 48);
  for (const double p : {30.0, 31.0, 32.0, 24.0, 0.1, 0.2, 0.3, 0.4}) put(cameras, p);
  put<uint32_t>(cameras, 4), put<int32_t>(cameras, 6), put<uint64_t>(cameras, 10), put<uint64_t>(cameras, 20);
  for (const double p : {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0}) put(cameras, p);
  put<uint64_t>(images, 2);
  for (const uint32_t id : {7u, 8u}) {
    put(images, id);
    for (const double p : {0.0, 1.0, 0.0, 0.0, 1.0, 2.0, 3.0}) put(images, p);  // half a turn about X, then (1, 2, 3)
    put<uint32_t>(images, id == 7 ? 9 : 4);
    images += id == 7 ? "one.png" : "two.png";
    put<char>(images, 0);
    put<uint64_t>(images, id == 7 ? 2 : 0);
    if (id == 7)
      for (int point = 0; point < 2; ++point) put(images, 1.5), put(images, 2.5), put<uint64_t>(images, 3);
  }
  const Folder folder;
  folder.write("cameras.bin", cameras);
  folder.write("images.bin", images);
  const auto read = readColmap(folder.path());
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].lens->model, Fisheye);
  EXPECT_EQ(read[0].lens->fy, 31);
  EXPECT_EQ(read[0].lens->width, 64);
  EXPECT_THAT(read[0].lens->distortion, ElementsAre(0.1, 0.2, 0.3, 0.4, 0, 0, 0, 0));
  EXPECT_THAT(read[1].lens->distortion, ElementsAre(5, 6, 7, 8, 9, 10, 11, 12));
  EXPECT_EQ(read[1].name, "two.png");
  expectPose(read[0].pose, {1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {-1, 2, 3});
}

TEST(CalibratedTest, CamerasAreNamedAfterTheirPictures) {
  for (const char* picture : {"a/1.5.png", "./a/1.5.Png", "../a/1.5.JPEG", "a/1.5.webp", "a/1.5.WEBP", "a/1.5.NPY"})
    EXPECT_EQ(stemOf(picture), "a/1.5") << picture;
  for (const char* name : {"1.5", "a.png/1.5", "png"}) EXPECT_EQ(stemOf(name), name);
}

TEST(ColmapTest, KnowsEachModel) {
  const Folder folder;
  folder.write("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n");
  const auto lens = [&](const std::string& line) {
    folder.write("cameras.txt", "1 " + line + "\n");
    return *readColmap(folder.path())[0].lens;
  };
  EXPECT_EQ(lens("SIMPLE_PINHOLE 4 5 1 2 3").fy, 1);
  EXPECT_EQ(lens("PINHOLE 4 5 1 2 3 4").cy, 4);
  EXPECT_THAT(lens("RADIAL 4 5 1 2 3 4 5").distortion, ElementsAre(4, 5, 0, 0, 0, 0, 0, 0));
  EXPECT_THAT(lens("OPENCV 4 5 1 2 3 4 5 6 7 8").distortion, ElementsAre(5, 6, 7, 8, 0, 0, 0, 0));
  EXPECT_EQ(lens("SIMPLE_RADIAL_FISHEYE 4 5 1 2 3 4").model, Fisheye);
  EXPECT_THAT(lens("RADIAL_FISHEYE 4 5 1 2 3 4 5").distortion, ElementsAre(4, 5, 0, 0, 0, 0, 0, 0));
  for (const std::string refused : {"FOV 4 5 1 2 3 4 5", "THIN_PRISM_FISHEYE 4 5 1 2 3 4 5 6 7 8 9 10 11 12"}) {
    const std::string sentence = errorOf([&] { lens(refused); }, ExitCode::BadInput);
    EXPECT_THAT(sentence, testing::HasSubstr(refused.substr(0, refused.find(' '))));
    EXPECT_THAT(sentence, testing::HasSubstr("line 1 of " + folder.at("cameras.txt")));
  }
}

TEST(TumTest, ReadsTrajectories) {
  const Folder folder;
  // Half a turn about X, then a quarter turn about Y.
  folder.write(
      "groundtruth.txt",
      "# ground truth trajectory\n# timestamp tx ty tz qx qy qz qw\n"
      "1305031102.175304 1 2 3 1 0 0 0\r\n1305031102.211214 0 0 0 0 0.7071067811865476 0 0.7071067811865476\n");
  const auto cameras = readTum(folder.at("groundtruth.txt"));
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[0].name, "1305031102.175304");
  EXPECT_FALSE(cameras[0].lens);
  expectPose(cameras[0].pose, {1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {1, 2, 3});
  expectPose(cameras[1].pose, {0, 0, -1}, {0, 1, 0}, {1, 0, 0}, {0, 0, 0});
  const auto placed =
      made(R"({"type": "tum", "fov": 50, "scale": 0.5, "file": ")" + folder.at("groundtruth.txt") + "\"}");
  EXPECT_EQ(placed[0].name, "1305031102.175304");
  expectNear(eyeOf(placed[0]), {0.5, 1, 1.5}, 1e-6);
  expectNear(seenFrom(placed[0], {0.5, 1, 0.5}), {0, 0, 1}, 1e-6);
}

TEST(BopTest, ReadsSceneCameras) {
  // As in docs/bop_datasets_format.md of bop_toolkit: millimeters, world to camera, row by row.
  const Folder folder;
  folder.write("scene_camera.json", R"({
    "10": {"cam_K": [572.4, 0.0, 325.2, 0.0, 573.5, 242.0, 0.0, 0.0, 1.0], "depth_scale": 1.0,
           "cam_R_w2c": [1, 0, 0, 0, -1, 0, 0, 0, -1], "cam_t_w2c": [100, 200, 3000]},
    "9": {"cam_K": [500, 0, 320, 0, 500, 240, 0, 0, 1], "cam_R_w2c": [0, 0, 1, 0, 1, 0, -1, 0, 0], "cam_t_w2c": [0, 0, 1000]}})");
  const auto cameras = readBop(folder.at("scene_camera.json"), {640, 480});
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[0].name, "9");
  EXPECT_EQ(cameras[1].lens->fy, 573.5);
  EXPECT_EQ(cameras[1].lens->cx, 325.7);  // OpenCV's first pixel has its center at 0
  EXPECT_EQ(cameras[1].lens->cy, 242.5);
  expectPose(cameras[1].pose, {1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {-0.1, 0.2, 3});
  expectPose(cameras[0].pose, {0, 0, 1}, {0, 1, 0}, {-1, 0, 0}, {1, 0, 0});
}

TEST(BopTest, ReadsExposures) {
  const Folder folder;
  const auto write = [&](const std::string& keys) {
    folder.write("c.json", R"({"3": {"cam_K": [500, 0, 320, 0, 500, 240, 0, 0, 1], "cam_R_w2c": [1,0,0,0,1,0,0,0,1],
                               "cam_t_w2c": [0, 0, 0], )" +
                               keys + "}}");
    return folder.at("c.json");
  };
  const auto cameras = readBop(write(R"("shutter": 0.25, "readout": 0.5, "noiseSeed": 3)"), {640, 480});
  EXPECT_EQ(cameras[0].exposure, (CameraExposure{.shutter = 0.25, .readout = 0.5, .noiseSeed = 3}));
  const std::string file = write(R"("readout": null)");
  EXPECT_EQ(errorOf(
                [&] {
                  readBop(file, {640, 480});
                },
                ExitCode::BadInput),
            "picture 3 of " + file + ": \"readout\" must be a finite number");
}

}  // namespace
}  // namespace latelight::data::test
