// The contents of the files of single frames, compared with closed forms and results computed by hand.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>

#include "data/cameras/transforms.h"
#include "data_formats/support.h"
#include "output/png.h"
#include "output/support.h"
#include "render/submit/session.h"
#include "scene/edit.h"
#include "scene/load/load.h"

namespace latelight::data::test {
namespace {

using output::Aov;
using output::AovImage;
using output::ReadImage;

class FormatFilesTest : public FormatsTest {
 protected:
  // A frame with one output that has these values.
  ReadImage png(std::string_view format, const Json& options, Aov aov, std::vector<float> values) {
    DataFrame frame{.name = "a"};
    const auto width = static_cast<uint32_t>(values.size() / output::info(aov).channels);
    frame.picture = {width, 1, {AovImage{aov, width, 1, std::move(values), {}}}, {}};
    const FrameRecord record = make(format, options)->writeFrame(frame, folder);
    return output::decodePng(readFile(folder / record.files.at(0)), record.files.at(0));
  }
};

std::vector<double> channel(const ReadImage& image, size_t i) {
  std::vector<double> codes;
  for (const double value : image.channels.at(i).values) codes.push_back(std::round(value * 65535));
  return codes;
}

TEST_F(FormatFilesTest, DepthIsRoundedToTheNearestStep) {
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> meters{1.2344f, 1.2346f, 65.535f, 65.54f, 0.0004f, 0.0006f, inf, 255.998f, 256};
  EXPECT_EQ(channel(png("depth-png", {}, Aov::Depth, meters), 0),
            (std::vector<double>{1234, 1235, 65535, 0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(channel(png("depth-png", {{"unit", "kitti"}}, Aov::Depth, meters), 0),
            (std::vector<double>{316, 316, 16777, 16778, 0, 0, 0, 65535, 0}));
  EXPECT_EQ(channel(png("depth-png", {{"scale", 0.1}}, Aov::Depth, meters), 0),
            (std::vector<double>{12344, 12346, 0, 0, 4, 6, 0, 0, 0}));
}

TEST_F(FormatFilesTest, KittiFlowIsRoundedAndSaysWhatItHolds) {
  const ReadImage flow =
      png("flow", {{"as", "kitti"}}, Aov::Motion, {9, 9, 0, 0, 9, 9, 1.5f, -2.25f, 9, 9, 0.01f, -0.01f, 9, 9, 600, 0});
  EXPECT_EQ(channel(flow, 0), (std::vector<double>{32768, 32864, 32769, 0}));
  EXPECT_EQ(channel(flow, 1), (std::vector<double>{32768, 32624, 32767, 0}));
  EXPECT_EQ(channel(flow, 2), (std::vector<double>{1, 1, 1, 0}));
}

// If there is no next frame, the flow is 1e10, above Middlebury's limit of 1e9, and KITTI's blue is 0.
TEST_F(FormatFilesTest, FlowToNoFrameIsUnknown) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> motion{1, 2, nan, nan, 3, 4, nan, nan};
  const ReadImage kitti = png("flow", {{"as", "kitti"}}, Aov::Motion, motion);
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(channel(kitti, i), (std::vector<double>{0, 0}));
  EXPECT_EQ(channel(png("flow", {{"as", "kitti"}, {"to", "previous"}}, Aov::Motion, motion), 2),
            (std::vector<double>{1, 1}));
  DataFrame frame{.name = "a"};
  frame.picture = {2, 1, {AovImage{Aov::Motion, 2, 1, motion, {}}}, {}};
  const auto flowTo = [&](const char* to) {
    make("flow", {{"to", to}})->writeFrame(frame, folder);
    std::vector<float> flow(4);
    const std::vector<std::byte> bytes = readFile(folder / "flow/a.flo");
    EXPECT_EQ(bytes.size(), 12u + sizeof(float) * flow.size());
    std::memcpy(flow.data(), bytes.data() + 12, sizeof(float) * flow.size());
    return flow;
  };
  EXPECT_EQ(flowTo("next"), (std::vector<float>{1e10f, 1e10f, 1e10f, 1e10f}));
  EXPECT_EQ(flowTo("previous"), (std::vector<float>{1, 2, 3, 4}));
}

// A plane at depth z that moves by t parallel to the image plane has a flow of f t / z at every pixel.
TEST_F(FormatFilesTest, FlowOfAPlane) {
  const scene::Scene scene = squares();
  Studio studio(device(), scene);
  const scene::Camera camera = squaresCamera(true);
  render::SceneState moment;
  moment.previousCameras = moment.nextCameras = {camera};
  // the camera moves left and down, so everything moves right and up in the picture
  moment.nextCameras[0].toWorld[3] += glm::vec4(-0.25f, 0, -0.125f, 0);
  const std::unique_ptr<Format> forward = make("flow"), backward = make("flow", {{"to", "previous"}});
  const DataFrame frame = studio.frame(camera, 64, 64, {forward.get()}, 0, moment);
  const std::string file = forward->writeFrame(frame, folder).files.at(0);
  EXPECT_EQ(file, "flow/000000.flo");
  const std::vector<std::byte> bytes = readFile(folder / file);
  ASSERT_EQ(bytes.size(), 12u + 64 * 64 * 8);
  float magic, flow[2];
  std::memcpy(&magic, bytes.data(), 4);
  EXPECT_EQ(magic, 202021.25f);
  const size_t pixel = 32 * 64 + 20;  // a pixel of the back square, 2 m away, where 32 pixels are 1 m
  std::memcpy(flow, bytes.data() + 12 + 8 * pixel, 8);
  EXPECT_NEAR(flow[0], 32.0 / 2 * 0.25, 1e-4);
  EXPECT_NEAR(flow[1], -32.0 / 2 * 0.125, 1e-4);
  const std::vector<std::byte> before = readFile(folder / backward->writeFrame(frame, folder).files.at(0));
  std::memcpy(flow, before.data() + 12 + 8 * pixel, 8);
  EXPECT_NEAR(flow[0], 0, 1e-6);
  EXPECT_NEAR(flow[1], 0, 1e-6);
}

// The points of a square in the plane z = 0 lie in it, have its normal and its color.
TEST_F(FormatFilesTest, PointsLieOnTheirSurface) {
  const scene::Scene scene = squares();
  Studio studio(device(), scene);
  const std::unique_ptr<Format> ply = make("ply");
  const DataFrame frame = studio.frame(squaresCamera(true), 64, 64, {ply.get()});
  const std::vector<std::byte> bytes = readFile(folder / ply->writeFrame(frame, folder).files.at(0));
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const size_t begin = text.find("end_header\n") + 11;
  constexpr size_t kPoint = 31;
  ASSERT_EQ((bytes.size() - begin) % kPoint, 0u);
  const uint32_t front = scene.instances.at(1).id;
  size_t plane = 0;
  for (size_t at = begin; at < bytes.size(); at += kPoint) {
    float values[6];
    uint32_t id;
    std::memcpy(values, &bytes[at], 24);
    std::memcpy(&id, &bytes[at + 27], 4);
    EXPECT_NEAR(values[2], id == front ? 0.5 : 0, 1e-5);
    EXPECT_FLOAT_EQ(values[5], 1);
    plane += id != front;
  }
  EXPECT_GT(plane, 32u * 32 / 2);
}

TEST_F(FormatFilesTest, FilmsNeedFfmpeg) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder.c_str(), 1);
  EXPECT_THAT(errorOf([] { make("video"); }), testing::HasSubstr("requires ffmpeg"));
  std::ofstream(folder / "ffmpeg") << "#!/bin/sh\nexit 1\n";
  std::filesystem::permissions(folder / "ffmpeg", std::filesystem::perms::owner_all);
  std::ofstream(folder / "a.png") << std::string(1 << 20, 'x');  // more than a socket accepts at once
  EXPECT_THAT(errorOf([&] { make("video")->writeSet({std::vector<Json>{"a.png"}}, folder); }),
              testing::HasSubstr("ffmpeg failed to encode"));
  setenv("PATH", path.c_str(), 1);
  EXPECT_FALSE(std::filesystem::exists(folder / "video.mp4"));
}

std::vector<uint8_t> outputOf(const std::string& command) {
  std::vector<uint8_t> bytes;
  FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) return bytes;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) bytes.push_back(static_cast<uint8_t>(c));
  pclose(pipe);
  return bytes;
}

// BT.709 in limited range (ITU-R BT.709, item 3): Y' = 16 + 219 (0.2126 R' + 0.7152 G' + 0.0722 B'),
// Cb = 128 + 224 (B' - Y) / 1.8556 and Cr = 128 + 224 (R' - Y) / 1.5748, where Y is the sum in parentheses.
TEST_F(FormatFilesTest, FilmsStateTheirColors) {
  if (outputOf("ffprobe -version 2>/dev/null").empty()) GTEST_SKIP() << "ffmpeg is not installed";
  constexpr uint32_t kWidth = 32, kHeight = 16;
  const auto format = make("video");
  for (const auto& [color, code] : {std::pair{std::array<uint8_t, 3>{255, 0, 0}, std::array{63, 102, 240}},
                                    {std::array<uint8_t, 3>{0, 255, 0}, std::array{173, 42, 26}}}) {
    DataFrame frame{.name = "a"};
    frame.picture = {kWidth, kHeight, {}, {}};
    for (uint32_t i = 0; i < kWidth * kHeight; ++i)
      frame.picture.display.insert(frame.picture.display.end(), {color[0], color[1], color[2], 255});
    const FrameRecord record = format->writeFrame(frame, folder);
    const std::string video = folder / format->writeSet({std::vector{record.entry}}, folder).at(0);
    const std::vector<uint8_t> tags = outputOf(
        "ffprobe -v error -of csv=p=0 -show_entries "
        "stream=color_range,color_space,color_transfer,color_primaries '" +
        video + "'");
    EXPECT_EQ(std::string(tags.begin(), tags.end()), "tv,bt709,iec61966-2-1,bt709\n");
    const std::vector<uint8_t> planes = outputOf("ffmpeg -v error -i '" + video + "' -f rawvideo -pix_fmt yuv420p -");
    ASSERT_EQ(planes.size(), kWidth * kHeight * 3 / 2);
    const size_t pixel = kWidth * kHeight / 2 + kWidth / 2,
                 chroma = kWidth * kHeight + kWidth * kHeight / 8 + kWidth / 4;
    EXPECT_NEAR(planes[pixel], code[0], 1);
    EXPECT_NEAR(planes[chroma], code[1], 1);
    EXPECT_NEAR(planes[chroma + kWidth * kHeight / 4], code[2], 1);
  }
}

// Intrinsics that are equal in all frames are written once, different ones with each frame.
TEST_F(FormatFilesTest, TransformsOfSeveralCameras) {
  const scene::Scene scene = squares();
  Studio studio(device(), scene);
  const std::unique_ptr<Format> transforms = make("transforms", {{"depth", false}, {"write-pictures", false}});
  std::vector<Json> entries;
  for (const float fov : {0.5f, 0.75f}) {
    const DataFrame frame = studio.frame(render::test::frontPerspective(fov, 4), 32, 32, {transforms.get()});
    const FrameRecord record = transforms->writeFrame(frame, folder);
    EXPECT_THAT(record.files, testing::IsEmpty());
    entries.push_back(record.entry);
  }
  transforms->writeSet({entries}, folder);
  const Json different = json("transforms.json");
  EXPECT_FALSE(different.contains("fl_x"));
  EXPECT_NEAR(different["frames"][0]["fl_x"].get<double>(), 16 / std::tan(0.25), 1e-4);
  EXPECT_NEAR(different["frames"][1]["fl_y"].get<double>(), 16 / std::tan(0.375), 1e-4);
  EXPECT_EQ(different["frames"][0]["transform_matrix"],
            Json::parse("[[1.0,0.0,0.0,0.0],[0.0,1.0,0.0,0.0],[0.0,0.0,1.0,4.0],[0.0,0.0,0.0,1.0]]"));
  const std::vector<Json> alike{entries[0], entries[0]};
  transforms->writeSet({alike}, folder);
  EXPECT_TRUE(json("transforms.json").contains("fl_x"));
  EXPECT_FALSE(json("transforms.json")["frames"][0].contains("fl_x"));
}

// Lenses of pictures that are 64 pixels wide.
const scene::Lens kLenses[] = {
    {scene::LensModel::OpenCv, 64, 36, 40, 41, 30, 19, {-0.2, 0.05, 0.001, -0.002, 0.01}},
    {scene::LensModel::Fisheye, 64, 36, 20, 21, 33, 17, {0.02, -0.01, 0.003, -0.001}},
    {scene::LensModel::Equirectangular, 64, 32},
};

Json ofFrameOrAll(const Json& set, const Json& frame, const char* key) {
  return set.contains(key) ? set[key] : frame.value(key, Json(0));
}

// The intrinsics of a frame by the rules of nerfstudio's data parser: the model is that of all frames only; each other
// value is that of all frames if they have it, and the distortion if they have any of it.
Json nerfstudioLens(const Json& set, const Json& frame) {
  Json lens{{"camera_model", set.value("camera_model", "none, a pinhole")}};
  for (const char* key : {"fl_x", "fl_y", "cx", "cy", "h", "w"}) lens[key] = ofFrameOrAll(set, frame, key);
  bool ofAll = false;
  for (const char* key : {"k1", "k2", "k3", "p1", "p2"}) ofAll = ofAll || set.contains(key);
  for (const char* key : {"k1", "k2", "k3", "k4", "p1", "p2"}) lens[key] = (ofAll ? set : frame).value(key, 0.0);
  return lens;
}

// The intrinsics of a frame by the rules of instant-ngp's loader, which reads all frames' and then the frame's. Values
// are combined only within one of the two: the center with the size, both focal lengths, and is_fisheye with the
// distortion, without which it is ignored.
Json instantNgpLens(const Json& set, const Json& frame) {
  Json lens{{"mode", "pinhole"}, {"params", {0, 0, 0, 0}}, {"center", {0.5, 0.5}}, {"focal", {0, 0}}};
  for (const Json* json : {&set, &frame}) {
    const std::pair<const char*, size_t> kTerms[] = {{"k1", 0}, {"k2", 1}, {"k3", 2}, {"k4", 3}, {"p1", 2}, {"p2", 3}};
    for (const auto& [key, place] : kTerms) {
      if (!json->contains(key)) continue;
      lens["params"][place] = (*json)[key];
      if ((*json)[key] != 0) lens["mode"] = json->value("is_fisheye", false) ? "fisheye" : "opencv";
    }
    if (json->contains("cx")) lens["center"][0] = json->at("cx").get<double>() / json->at("w").get<double>();
    if (json->contains("cy")) lens["center"][1] = json->at("cy").get<double>() / json->at("h").get<double>();
    if (json->contains("latlong")) lens["mode"] = "latlong";
    const double x = json->value("fl_x", 0.0), y = json->value("fl_y", 0.0);
    if (x != 0 || y != 0) lens["focal"] = {x != 0 ? x : y, y != 0 ? y : x};
  }
  return lens;
}

void expectRead(const scene::Lens& lens, const Json& set, const Json& frame) {
  const bool isSphere = lens.model == scene::LensModel::Equirectangular;
  const bool isFisheye = lens.model == scene::LensModel::Fisheye;
  const std::array<double, 8>& d = lens.distortion;
  const Json nerfstudio = nerfstudioLens(set, frame), ngp = instantNgpLens(set, frame);
  EXPECT_EQ(nerfstudio["camera_model"], isSphere ? "EQUIRECTANGULAR" : isFisheye ? "OPENCV_FISHEYE" : "OPENCV");
  EXPECT_EQ(nerfstudio["w"], lens.width);
  EXPECT_EQ(nerfstudio["h"], lens.height);
  const bool isPinhole = d == std::array<double, 8>{};
  EXPECT_EQ(ngp["mode"], isSphere ? "latlong" : isPinhole ? "pinhole" : isFisheye ? "fisheye" : "opencv");
  if (isSphere) return;
  EXPECT_EQ(nerfstudio["fl_x"], lens.fx);
  EXPECT_EQ(nerfstudio["fl_y"], lens.fy);
  EXPECT_EQ(nerfstudio["cx"], lens.cx);
  EXPECT_EQ(nerfstudio["cy"], lens.cy);
  const std::array<double, 6> terms =
      isFisheye ? std::array{d[0], d[1], d[2], d[3], 0.0, 0.0} : std::array{d[0], d[1], d[4], 0.0, d[2], d[3]};
  const char* const kKeys[] = {"k1", "k2", "k3", "k4", "p1", "p2"};
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ(nerfstudio[kKeys[i]], terms[i]) << kKeys[i];
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(ngp["params"][i], d[i]) << i;
  EXPECT_EQ(ngp["focal"], Json({lens.fx, lens.fy}));
  EXPECT_EQ(ngp["center"], Json({lens.cx / lens.width, lens.cy / lens.height}));
}

// Cameras of transforms.json that are read back: by the camera source, and by the rules of the format's readers.
TEST_F(FormatFilesTest, TransformsHoldLenses) {
  const scene::Scene scene = squares();
  Studio studio(device(), scene);
  const std::unique_ptr<Format> transforms = make("transforms", {{"depth", false}, {"write-pictures", false}});
  const auto& [opencv, fisheye, sphere] = kLenses;
  const auto with = [](scene::Lens lens, const std::function<void(scene::Lens&)>& change) {
    change(lens);
    return lens;
  };
  const std::vector<scene::Lens> sets[] = {
      {opencv, opencv},
      {fisheye, fisheye},
      {sphere, sphere},
      {fisheye, with(fisheye, [](auto& lens) { lens.distortion[0] = 0.03; })},
      {fisheye, with(fisheye, [](auto& lens) { lens.cx = 32.5; })},
      {fisheye, with(fisheye, [](auto& lens) { lens.fx = 24, lens.distortion[3] = 0; })},
      {opencv, with(opencv, [](auto& lens) { lens.fx = 38, lens.distortion[4] = 0; })},
      {opencv, with(opencv, [](auto& lens) { lens.model = scene::LensModel::Pinhole, lens.distortion = {}; })},
      {sphere, with(sphere, [](auto& lens) { lens.width = 48, lens.height = 24; })},
  };
  for (const std::vector<scene::Lens>& lenses : sets) {
    SCOPED_TRACE(&lenses - sets);
    std::vector<Json> entries;
    for (const scene::Lens& lens : lenses) {
      scene::Camera camera = render::test::frontPerspective(0.5f, 4);
      camera.lens = lens;
      const auto [width, height] = std::pair(static_cast<uint32_t>(lens.width), static_cast<uint32_t>(lens.height));
      entries.push_back(transforms->writeFrame(studio.frame(camera, width, height, {transforms.get()}), folder).entry);
    }
    transforms->writeSet({entries}, folder);
    const Json set = json("transforms.json");
    for (const char* key : {"camera_model", "fl_x", "w", "k1"})
      if (lenses[0] == lenses[1] && lenses[0].model != scene::LensModel::Equirectangular) {
        EXPECT_TRUE(set.contains(key) && !set["frames"][0].contains(key)) << key;
      }
    const std::vector<CalibratedCamera> cameras = readTransforms(folder / "transforms.json");
    ASSERT_EQ(cameras.size(), lenses.size());
    for (size_t i = 0; i < cameras.size(); ++i) {
      SCOPED_TRACE(i);
      EXPECT_EQ(cameras[i].lens, lenses[i]);
      expectRead(lenses[i], set, set["frames"][i]);
    }
  }
}

// Readers of the format have one model for all frames.
TEST_F(FormatFilesTest, TransformsHaveOneModel) {
  const scene::Scene scene = squares();
  Studio studio(device(), scene);
  const std::unique_ptr<Format> transforms = make("transforms", {{"depth", false}, {"write-pictures", false}});
  const auto frameOf = [&](const char* name, const std::optional<scene::Lens>& lens) {
    scene::Camera camera = render::test::frontPerspective(0.5f, 4);
    camera.name = name;
    camera.lens = lens;
    return studio.frame(camera, 64, 36, {transforms.get()});
  };
  const DataFrame pinhole = frameOf("narrow", {}), opencv = frameOf("bent", kLenses[0]),
                  fisheye = frameOf("wide", kLenses[1]);
  EXPECT_NO_THROW(transforms->checkTogether(pinhole, opencv));
  EXPECT_NO_THROW(transforms->checkTogether(fisheye, fisheye));
  for (const DataFrame* other : {&pinhole, &opencv})
    EXPECT_THAT(errorOf([&] { transforms->checkTogether(fisheye, *other); }),
                testing::HasSubstr("one camera_model for all frames, but that of the camera \"wide\" is OPENCV_FISHEYE "
                                   "and that of \"" +
                                   other->metadata.camera.name + "\" is OPENCV: "));
}

TEST_F(FormatFilesTest, LensesAreRefusedWhereThereAreNone) {
  const scene::Scene scene = squares();
  Studio studio(device(), scene);
  const auto said = [&](const char* name, const scene::Lens& lens) {
    const std::unique_ptr<Format> format = make(name);
    scene::Camera camera = render::test::frontPerspective(0.5f, 4);
    camera.lens = lens;
    const auto [width, height] = std::pair(static_cast<uint32_t>(lens.width), static_cast<uint32_t>(lens.height));
    const DataFrame frame = studio.frame(camera, width, height, {format.get()});
    return errorOf([&] { format->writeFrame(frame, folder); });
  };
  EXPECT_THAT(said("bop", kLenses[0]), testing::HasSubstr("the format bop cannot express cameras with a lens"));
  EXPECT_THAT(said("transforms", {scene::LensModel::CubeMap, 96, 16}), testing::HasSubstr("knows no cube maps"));
  scene::Lens rational = kLenses[0];
  rational.distortion[5] = 0.01;
  EXPECT_THAT(said("transforms", rational), testing::HasSubstr("no k4, k5 and k6"));
}

// The visible corners of boxes: the object's pixels around the position of such a corner are as far from the camera as
// the corner, and have its depth.
int cornersThatShow(const DataFrame& frame, const Object& object, const Json& corners, glm::dvec3 eye) {
  const AovImage& ids = render::test::imageOf(frame.picture, Aov::Id);
  const AovImage& positions = render::test::imageOf(frame.picture, Aov::Position);
  const AovImage& depths = render::test::imageOf(frame.picture, Aov::Depth);
  int shown = 0;
  for (size_t corner = 0; corner < 8; ++corner) {
    const Json& at = corners[corner];
    if (at.is_null()) continue;
    const double x = at[0], y = at[1], depth = at[2];
    if (!(x >= 1 && y >= 1 && x < ids.width - 1.0 && y < ids.height - 1.0)) continue;
    const glm::dvec4 own((corner & 1) != 0 ? object.high.x : object.low.x,
                         (corner & 2) != 0 ? object.high.y : object.low.y,
                         (corner & 4) != 0 ? object.high.z : object.low.z, 1);
    const glm::dvec3 place(object.toWorld * own);
    bool found = false;
    for (int near = 0; near < 9; ++near) {
      const size_t pixel = (static_cast<size_t>(y) + static_cast<size_t>(near / 3) - 1) * ids.width +
                           static_cast<size_t>(x) + static_cast<size_t>(near % 3) - 1;
      if (ids.ids[pixel] != object.id) continue;
      const glm::dvec3 seen(render::test::vec3At(positions, pixel));
      const bool alike = std::abs(depths.values[pixel] - depth) <= 0.02 * depth;
      found = found || (alike && glm::distance(seen, place) <= 0.03 * glm::distance(place, eye));
    }
    shown += found;
  }
  return shown;
}

TEST_F(FormatFilesTest, CornersOfBoxesLieWhereLensesSeeThem) {
  const scene::Scene scene = scene::load("builtin:boxes");
  Studio studio(device(), scene);
  const std::unique_ptr<Format> boxes = make("boxes", {{"whole", false}});
  const std::unique_ptr<Format> outputs = make("npz", {{"outputs", {"position", "depth"}}});
  for (const scene::Lens& lens : {scene::Lens{scene::LensModel::Pinhole, 320, 180, 200, 200, 160, 90},
                                  scene::Lens{scene::LensModel::OpenCv, 320, 180, 200, 200, 160, 90, {-0.1, 0.01}},
                                  scene::Lens{scene::LensModel::Fisheye, 320, 180, 120, 120, 160, 90},
                                  scene::Lens{scene::LensModel::Equirectangular, 640, 320}}) {
    SCOPED_TRACE(scene::infoOf(lens.model).name);
    scene::Camera camera = scene.cameras.front();
    camera.lens = lens;
    const DataFrame frame = studio.frame(camera, static_cast<uint32_t>(lens.width), static_cast<uint32_t>(lens.height),
                                         {boxes.get(), outputs.get()});
    boxes->writeFrame(frame, folder);
    const Json written = json("boxes/000000.json");
    int shown = 0;
    for (const Json& entry : written["objects"]) {
      const auto object = std::ranges::find(frame.objects, entry["id"].get<uint32_t>(), &Object::id);
      ASSERT_NE(object, frame.objects.end());
      shown += cornersThatShow(frame, *object, entry["box"]["corners"],
                               glm::dvec3(render::openCvPose(camera, scene, false)[3]));
    }
    fmt::print("{}: {} corners of {} objects show\n", scene::infoOf(lens.model).name, shown, written["objects"].size());
    EXPECT_GE(shown, 20);
    if (lens.model == scene::LensModel::Pinhole) continue;
    EXPECT_EQ(written["camera"]["model"], scene::infoOf(lens.model).name);
    EXPECT_EQ(written["camera"]["K"].is_null(), lens.model == scene::LensModel::Equirectangular);
  }
}

TEST_F(FormatFilesTest, OrthographicCamerasAreRefusedWhereThereAreNone) {
  const scene::Scene scene = squares();
  Studio studio(device(), scene);
  for (const char* name : {"bop", "transforms"}) {
    const std::unique_ptr<Format> format = make(name);
    const DataFrame frame = studio.frame(squaresCamera(), 16, 16, {format.get()});
    EXPECT_THAT(errorOf([&] { format->writeFrame(frame, folder); }),
                testing::HasSubstr(fmt::format("the format {} cannot express orthographic cameras", name)));
  }
}

// SetTest expects the same of the other formats.
TEST_F(FormatFilesTest, FilesOfPairsAndScansAreStated) {
  const auto expectStated = [&](const Format& format, const DataFrame& frame) {
    std::vector<std::string> stated, written = format.writeFrame(frame, folder).files;
    for (const FormatFile& file : format.files(frame)) stated.push_back(file.name);
    for (const std::string& file : format.writeSet({}, folder)) written.push_back(file);
    EXPECT_THAT(stated, testing::UnorderedElementsAreArray(written));
  };
  DataFrame frame{.name = "a"};
  frame.metadata.ids = std::make_shared<output::IdManifest>();
  labels::Correspondence match{.width = 1, .height = 1};
  match.pixels.resize(1);
  match.depth.resize(1);
  match.visible.resize(1);
  match.flow.resize(1);
  for (const int64_t step : {1, 5}) frame.pairs.push_back({{.step = step}, "b", {}, match});
  for (const char* as : {"npz", "npy", "exr"})
    expectStated(*make("correspondence", {{"as", as}, {"to", {"next", 5}}}), frame);
  const std::unique_ptr<Format> lidar = make("lidar", {{"sensor", "vlp-16"}});
  frame.scans.push_back({lidar->needsExtras().scans.at(0), {}, {}, {}});
  expectStated(*lidar, frame);
}

TEST_F(FormatFilesTest, TheSameFrameGivesTheSameBytes) {
  const scene::Scene scene = squares();
  Studio studio(device(), scene);
  for (const char* name : {"exr", "npz", "cryptomatte", "boxes"}) {
    const std::unique_ptr<Format> format = make(name);
    const DataFrame frame = studio.frame(squaresCamera(), 32, 32, {format.get()});
    const std::string file = format->writeFrame(frame, folder / "a").files.at(0);
    format->writeFrame(frame, folder / "b");
    EXPECT_EQ(readFile(folder / "a" / file), readFile(folder / "b" / file)) << name;
  }
}

TEST_F(FormatFilesTest, FilesHaveExtensionsInAnyCase) {
  const std::unique_ptr<Format> format = make("exr", {{"file", "{name}.EXR"}});
  EXPECT_EQ(format->files({.name = "a"}).at(0).name, "a.EXR");
}

TEST_F(FormatFilesTest, WrongOptionsAreNamed) {
  const auto said = [](const char* name, const Json& options) { return errorOf([&] { make(name, options); }); };
  EXPECT_THAT(said("exr", {{"file", "all.exr"}}), testing::HasSubstr("file with {name} in it"));
  EXPECT_THAT(said("exr", {{"file", "/tmp/{name}.exr"}}), testing::HasSubstr("below the data set's folder"));
  EXPECT_THAT(said("npz", {{"file", "../{name}.npz"}}), testing::HasSubstr("below the data set's folder"));
  for (const auto& [name, key] : std::initializer_list<std::pair<const char*, const char*>>{
           {"bop", "split"}, {"colmap", "folder"}, {"hdf5", "folder"}, {"scannet", "folder"}, {"webdataset", "folder"}})
    for (const char* folder : {"../x", "/x"})
      EXPECT_THAT(said(name, {{key, folder}}),
                  testing::HasSubstr(fmt::format("{} of the format {} takes a folder below the data set's folder, not "
                                                 "\"{}\"",
                                                 key, name, folder)));
  EXPECT_THAT(said("npz", {{"outputs", {"deep"}}}), testing::HasSubstr("there is no AOV \"deep\""));
  EXPECT_THAT(said("flow", {{"as", "gif"}}), testing::HasSubstr("one of flo, kitti"));
  EXPECT_THAT(said("depth-png", {{"scale", 0}}), testing::HasSubstr("a number from 0.001 to 10000"));
  EXPECT_THAT(said("depth-png", {{"unit", "mm"}, {"scale", 2}}), testing::HasSubstr("remove one of them"));
  EXPECT_THAT(said("depth-png", {{"steps", 3}}), testing::HasSubstr("has no option \"steps\"; it has file"));
  EXPECT_THAT(said("coco", {{"categories", {{"(", "a"}}}}), testing::HasSubstr("no regular expression"));
  EXPECT_THAT(said("coco", {{"categories", 3}}), testing::HasSubstr("mesh, node, material"));
}

}  // namespace
}  // namespace latelight::data::test
