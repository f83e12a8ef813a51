// What is in files of single frames, by closed forms and by hand.
#include <cmath>
#include <cstring>

#include "data_formats/support.h"
#include "output/png.h"
#include "output/support.h"
#include "scene/edit.h"

namespace latelight::data::test {
namespace {

using output::Aov;
using output::AovImage;
using output::ReadImage;
using output::sentence;

class FormatFilesTest : public FormatsTest {
 protected:
  // Of one frame with one output of these values.
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
  const std::vector<float> metres{1.2344f, 1.2346f, 65.535f, 65.54f, 0.0004f, 0.0006f, inf, 255.998f, 256};
  EXPECT_EQ(channel(png("depth-png", {}, Aov::Depth, metres), 0),
            (std::vector<double>{1234, 1235, 65535, 0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(channel(png("depth-png", {{"unit", "kitti"}}, Aov::Depth, metres), 0),
            (std::vector<double>{316, 316, 16777, 16778, 0, 0, 0, 65535, 0}));
  EXPECT_EQ(channel(png("depth-png", {{"scale", 0.1}}, Aov::Depth, metres), 0),
            (std::vector<double>{12344, 12346, 0, 0, 4, 6, 0, 0, 0}));
}

TEST_F(FormatFilesTest, KittiFlowIsRoundedAndSaysWhatItHolds) {
  const ReadImage flow =
      png("flow", {{"as", "kitti"}}, Aov::Motion, {9, 9, 0, 0, 9, 9, 1.5f, -2.25f, 9, 9, 0.01f, -0.01f, 9, 9, 600, 0});
  EXPECT_EQ(channel(flow, 0), (std::vector<double>{32768, 32864, 32769, 0}));
  EXPECT_EQ(channel(flow, 1), (std::vector<double>{32768, 32624, 32767, 0}));
  EXPECT_EQ(channel(flow, 2), (std::vector<double>{1, 1, 1, 0}));
}

// A plane at depth z that moves by t parallel to the picture flows by f t / z at every pixel.
TEST_F(FormatFilesTest, FlowOfAPlane) {
  const scene::Scene scene = squares();
  Studio studio(device(), scene);
  const scene::Camera camera = squaresCamera(true);
  render::Moment moment;
  moment.previousCameras = moment.nextCameras = {camera};
  moment.nextCameras[0].toWorld[3] += glm::vec4(-0.25f, 0, -0.125f, 0);  // left and down: all goes right and up
  const std::unique_ptr<Format> forward = make("flow"), backward = make("flow", {{"to", "previous"}});
  const DataFrame frame = studio.frame(camera, 64, 64, {forward.get()}, 0, moment);
  const std::string file = forward->writeFrame(frame, folder).files.at(0);
  EXPECT_EQ(file, "flow/000000.flo");
  const std::vector<std::byte> bytes = readFile(folder / file);
  ASSERT_EQ(bytes.size(), 12u + 64 * 64 * 8);
  float magic, flow[2];
  std::memcpy(&magic, bytes.data(), 4);
  EXPECT_EQ(magic, 202021.25f);
  const size_t pixel = 32 * 64 + 20;  // of the back square, 2 m away: 32 px / m there
  std::memcpy(flow, bytes.data() + 12 + 8 * pixel, 8);
  EXPECT_NEAR(flow[0], 32.0 / 2 * 0.25, 1e-4);
  EXPECT_NEAR(flow[1], -32.0 / 2 * 0.125, 1e-4);
  const std::vector<std::byte> before = readFile(folder / backward->writeFrame(frame, folder).files.at(0));
  std::memcpy(flow, before.data() + 12 + 8 * pixel, 8);
  EXPECT_NEAR(flow[0], 0, 1e-6);
  EXPECT_NEAR(flow[1], 0, 1e-6);
}

TEST_F(FormatFilesTest, TheSameFrameGivesTheSameBytes) {
  const scene::Scene scene = squares();
  Studio studio(device(), scene);
  for (const char* name : {"exr", "npz", "depth-png"}) {
    const std::unique_ptr<Format> format = make(name);
    const DataFrame frame = studio.frame(squaresCamera(), 32, 32, {format.get()});
    const std::string file = format->writeFrame(frame, folder / "a").files.at(0);
    format->writeFrame(frame, folder / "b");
    EXPECT_EQ(readFile(folder / "a" / file), readFile(folder / "b" / file)) << name;
  }
}

TEST_F(FormatFilesTest, WrongOptionsAreNamed) {
  const auto said = [](const char* name, const Json& options) {
    return sentence(ExitCode::Usage, [&] { make(name, options); });
  };
  EXPECT_THAT(said("exr", {{"file", "all.exr"}}), testing::HasSubstr("file with {name} in it"));
  EXPECT_THAT(said("exr", {{"file", "/tmp/{name}.exr"}}), testing::HasSubstr("below the data set's folder"));
  EXPECT_THAT(said("npz", {{"file", "../{name}.npz"}}), testing::HasSubstr("below the data set's folder"));
  EXPECT_THAT(said("npz", {{"outputs", {"deep"}}}), testing::HasSubstr("there is no AOV \"deep\""));
  EXPECT_THAT(said("flow", {{"as", "gif"}}), testing::HasSubstr("one of flo, kitti"));
  EXPECT_THAT(said("depth-png", {{"scale", 0}}), testing::HasSubstr("a number from 0.001 to 10000"));
  EXPECT_THAT(said("depth-png", {{"steps", 3}}), testing::HasSubstr("has no option \"steps\"; it has file"));
  EXPECT_THAT(said("coco", {{"categories", {{"(", "a"}}}}), testing::HasSubstr("no regular expression"));
  EXPECT_THAT(said("coco", {{"categories", 3}}), testing::HasSubstr("mesh, node, material"));
}

}  // namespace
}  // namespace latelight::data::test
