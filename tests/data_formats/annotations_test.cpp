// The formats yolo, voc and kitti against boxes computed by hand: the squares of support.h in a picture of 128 pixels.
#include <gmock/gmock.h>

#include <cstdio>
#include <fstream>
#include <iterator>
#include <sstream>

#include "base/error.h"
#include "base/files.h"
#include "data_formats/support.h"
#include "output/png.h"

namespace latelight::data::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

class AnnotationsTest : public FormatsTest {
 protected:
  // Writes one frame, and the files of the set.
  FrameRecord write(const char* name, const Json& options, bool perspective = false) {
    const scene::Scene scene = squares();
    Studio studio(device(), scene);
    const std::unique_ptr<Format> format = make(name, options);
    const DataFrame frame = studio.frame(squaresCamera(perspective), 128, 128, {format.get()}, 3);
    FrameRecord record = format->writeFrame(frame, folder);
    const std::vector<Json> entries{record.entry};
    for (std::string& file : format->writeSet({entries}, folder)) record.files.push_back(std::move(file));
    return record;
  }
  std::string text(const std::string& file) const {
    std::ifstream in(folder / file);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::vector<std::string> lines(const std::string& file) const {
    std::istringstream in(text(file));
    std::vector<std::string> all;
    for (std::string line; std::getline(in, line);) all.push_back(line);
    return all;
  }
};

// Readers split lines at any white space, Python's also at that of Unicode: here a line separator and a wide space.
TEST_F(AnnotationsTest, KittiCategoriesAreWords) {
  write("kitti", {{"categories", {{"front$", "a\tb\nc\vd\re f\u2028g\u3000\u00e9"}}}}, true);
  EXPECT_THAT(lines("label_2/000003.txt"), ElementsAre(testing::StartsWith("a_b_c_d_e_f_g_\u00e9 0.00 ")));
}

TEST_F(AnnotationsTest, YoloBoxesAreSharesOfThePicture) {
  const FrameRecord record = write("yolo", {{"categories", "node"}});
  EXPECT_THAT(record.files, ElementsAre("images/000003.png", "labels/000003.txt", "data.yaml"));
  EXPECT_THAT(lines("labels/000003.txt"),
              UnorderedElementsAre("0 0.50000000 0.50000000 0.50000000 0.50000000",    // back
                                   "1 0.87500000 0.18750000 0.25000000 0.37500000",    // cut
                                   "2 0.75000000 0.50000000 0.25000000 0.25000000"));  // front
  EXPECT_THAT(lines("data.yaml"),
              ElementsAre("train: \"images\"", "val: \"images\"", "names:", "  0: \"/squares/back\"",
                          "  1: \"/squares/cut\"", "  2: \"/squares/front\""));
}

// Without "path", Ultralytics resolves the folders of images relative to that of the file.
TEST_F(AnnotationsTest, YoloFindsItsPicturesFromAnyFolder) {
  const auto train = [&](const std::string& picture, const std::string& file) {
    write("yolo", {{"picture", picture}, {"file", file}});
    return lines(file).at(0);
  };
  EXPECT_EQ(train("rgb/{name}.png", "data.yaml"), "train: \"rgb\"");
  EXPECT_EQ(train("rgb/{name}.png", "y/data.yaml"), "train: \"../rgb\"");
  EXPECT_EQ(train("y/images/{name}.png", "y/data.yaml"), "train: \"images\"");
  EXPECT_EQ(train("{name}.png", "data.yaml"), "train: \".\"");
  EXPECT_EQ(train("{name}.png", "y/data.yaml"), "train: \"..\"");
}

TEST_F(AnnotationsTest, YoloClassesOfRulesAreInTheirOrder) {
  write("yolo", {{"categories", {{"nothing", "ghost"}, {"front$", "sign"}}}});
  EXPECT_THAT(lines("labels/000003.txt"), ElementsAre(testing::StartsWith("1 0.75")));
  EXPECT_THAT(text("data.yaml"), HasSubstr("  0: \"ghost\"\n  1: \"sign\"\n"));
}

TEST_F(AnnotationsTest, CategoriesAreReadFromAFile) {
  const std::filesystem::path rules = folder / "RULES.JSON";
  std::ofstream(rules) << R"({"nothing": "ghost", "front$": "sign"})";
  write("yolo", {{"categories", rules.string()}});
  EXPECT_THAT(lines("data.yaml"), testing::Contains("  1: \"sign\""));
}

// The first are not printable in YAML, and the others are its line breaks.
TEST_F(AnnotationsTest, YoloNamesAreYaml) {
  write("yolo", {{"categories", {{"front$", "a\x01\x7f\u0080\u009f\uffff \u0085\u2028\u00a0\u00e9"}}}});
  EXPECT_THAT(text("data.yaml"),
              HasSubstr("\n  0: \"a\\u0001\\u007f\\u0080\\u009f\\uffff \\u0085\\u2028\u00a0\u00e9\"\n"));
}

// The points are those of CocoTest.KeypointsOfObjects.
TEST_F(AnnotationsTest, YoloKeypointsAreSharesOfThePicture) {
  write("yolo", {{"categories", {{"front", "sign"}, {"back", "wall"}}},
                 {"keypoints",
                  {{{"name", "upper"}, {"position", {0.5, 0.75, 0}}},
                   {{"name", "side"}, {"position", {0.75, 0, 0}}},
                   {{"name", "far"}, {"position", {3, 0, 0}}}}}});
  const auto expect = [&](const std::string& line, const std::vector<double>& values) {
    std::istringstream in(line);
    double found = 0;
    for (int skipped = 0; skipped < 5; ++skipped) in >> found;  // class and box
    for (const double value : values) {
      ASSERT_TRUE(in >> found) << line;
      EXPECT_NEAR(found, value, 1e-6) << line;
    }
    EXPECT_FALSE(in >> found) << line;
  };
  const std::vector<std::string> all = lines("labels/000003.txt");
  ASSERT_EQ(all.size(), 2u);
  const bool isFirst = all[0].starts_with("0 ");
  expect(all[isFirst ? 0 : 1], {104 / 128.0, 52 / 128.0, 2, 108 / 128.0, 64 / 128.0, 2, 0, 0, 0});
  expect(all[isFirst ? 1 : 0], {80 / 128.0, 40 / 128.0, 2, 88 / 128.0, 64 / 128.0, 1, 0, 0, 0});
  EXPECT_THAT(text("data.yaml"), HasSubstr("val: \"images\"\nkpt_shape: [3, 3]\nnames:\n"));
}

// Ultralytics expects the same number of values in every line.
TEST_F(AnnotationsTest, YoloObjectsWithoutKeypointsHaveZeros) {
  write("yolo", {{"categories", "node"}, {"keypoints", {{{"name", "none"}, {"node", "hand"}}}}});
  for (const std::string& line : lines("labels/000003.txt"))
    EXPECT_THAT(line, testing::EndsWith(" 0.00000000 0.00000000 0"));
}

TEST_F(AnnotationsTest, VocBoxesCountPixelsFromOne) {
  const FrameRecord record = write("voc", {{"categories", {{"front", "a < b"}, {"back", "back"}, {"cut", "cut"}}}});
  EXPECT_THAT(record.files, ElementsAre("images/000003.png", "Annotations/000003.xml"));
  const std::string xml = text("Annotations/000003.xml");
  EXPECT_THAT(xml, HasSubstr("<filename>000003.png</filename>"));
  EXPECT_THAT(xml, HasSubstr("<width>128</width><height>128</height><depth>4</depth>"));
  EXPECT_EQ(output::decodePng(readFile(folder / "images/000003.png"), "").channels.size(), 4u);
  const auto object = [&](const std::string& name) {
    const size_t at = xml.find("<name>" + name + "</name>");
    return at == std::string::npos ? "" : xml.substr(at, xml.find("</object>", at) - at);
  };
  EXPECT_THAT(object("a &lt; b"), HasSubstr("<xmin>81</xmin><ymin>49</ymin><xmax>112</xmax><ymax>80</ymax>"));
  EXPECT_THAT(object("a &lt; b"), HasSubstr("<occluded>0</occluded>"));
  EXPECT_THAT(object("back"), HasSubstr("<occluded>1</occluded>"));  // 7 of 8 pixels are visible
  EXPECT_THAT(object("back"), HasSubstr("<truncated>0</truncated>"));
  EXPECT_THAT(object("cut"), HasSubstr("<truncated>1</truncated>"));
  EXPECT_THAT(object("cut"), HasSubstr("<xmin>97</xmin><ymin>1</ymin><xmax>128</xmax><ymax>48</ymax>"));
}

// Sets without objects, because a mapping does not match, are warned of. Frames without visible objects are not.
TEST_F(AnnotationsTest, MappingsThatMatchNoObjectAreWarnedOf) {
  for (const char* name : {"coco", "yolo", "voc", "kitti"}) {
    const auto warnings = [&](const Json& categories) {
      testing::internal::CaptureStderr();
      write(name, {{"categories", categories}}, true);
      return testing::internal::GetCapturedStderr();
    };
    EXPECT_THAT(warnings({{"^/car", "car"}, {"wheel", "wheel"}}),
                HasSubstr(fmt::format("the format {} has no objects: no visible object matches", name)));
    EXPECT_EQ(warnings({{"^/car", "car"}, {"front", "front"}}), "") << name;
    EXPECT_EQ(warnings("mesh"), "") << name;
  }
}

// XML has no control characters except white space, no U+FFFE and U+FFFF, and only characters of its encoding.
TEST_F(AnnotationsTest, VocNamesAreXml) {
  write("voc", {{"categories", {{"front$", "a&\x01\t\x7f\u00e9\ufffe\uffff\xe6 \U0001f600>"}}}});
  EXPECT_THAT(text("Annotations/000003.xml"),
              HasSubstr("<name>a&amp;  \x7f\u00e9\ufffd\ufffd\ufffd \U0001f600&gt;</name>"));
}

// The camera is 2 m in front of the back square and sees 90 degrees: 64 pixels are 2 m there.
TEST_F(AnnotationsTest, KittiBoxesAreInTheCamerasFrame) {
  const FrameRecord record = write("kitti", {{"categories", {{"back", "back wall"}, {"front", "front"}}}}, true);
  EXPECT_THAT(record.files, ElementsAre("image_2/000003.png", "label_2/000003.txt", "calib/000003.txt"));
  const std::vector<std::string> all = lines("label_2/000003.txt");
  ASSERT_EQ(all.size(), 2u);
  const std::string& back = all[0].starts_with("back") ? all[0] : all[1];
  // Its front points towards the camera: a turn of +90 degrees from +X, since y points down.
  EXPECT_EQ(back,
            "back_wall 0.00 0 1.570796 32 32 95 95 2.000000 2.000000 0.000000 0.000000 1.000000 2.000000 1.570796");
  const std::string& front = all[0].starts_with("back") ? all[1] : all[0];
  EXPECT_THAT(front, HasSubstr(" 1.000000 1.000000 0.000000 1.000000 0.500000 1.500000 1.570796"));
  const std::string calibration = text("calib/000003.txt");
  double fx = 0, fy = 0;  // 64, as precise as the camera's field of view, a float
  ASSERT_EQ(
      std::sscanf(calibration.c_str() + calibration.find("P2:"), "P2: %lf 0 63.5 0 0 %lf 63.5 0 0 0 1 0", &fx, &fy), 2);
  EXPECT_NEAR(fx, 64, 1e-5);
  EXPECT_NEAR(fy, 64, 1e-5);
  // Without a lidar, X forward, Y left and Z up of KITTI's Velodyne are Z, -X and -Y of the camera.
  EXPECT_THAT(calibration, HasSubstr("\nTr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0\n"));
}

TEST_F(AnnotationsTest, KittiRejectsOtherCameras) {
  try {
    write("kitti", Json::object());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::Usage);
    EXPECT_THAT(error.what(), HasSubstr("orthographic"));
  }
}

}  // namespace
}  // namespace latelight::data::test
