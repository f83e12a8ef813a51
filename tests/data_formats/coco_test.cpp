// COCO annotations against results computed by hand; pycocotools reads a whole set in read_set.py.
#include <gmock/gmock.h>

#include <chrono>

#include "base/error.h"
#include "data/formats/path_rules.h"
#include "data_formats/support.h"

namespace latelight::data::test {
namespace {

class CocoTest : public FormatsTest {
 protected:
  Json written(const Json& options) {
    const scene::Scene scene = squares();
    Studio studio(device(), scene);
    const std::unique_ptr<Format> format = make("coco", options);
    std::vector<Json> entries;
    for (uint64_t i = 0; i < 2; ++i) {
      const DataFrame frame = studio.frame(squaresCamera(), 128, 128, {format.get()}, i);
      FrameRecord record = format->writeFrame(frame, folder);
      EXPECT_EQ(record.files, std::vector{fmt::format("images/{:06}.png", i)});
      entries.push_back(std::move(record.entry));
    }
    EXPECT_EQ(format->writeSet({entries}, folder), std::vector<std::string>{"annotations/instances.json"});
    return json("annotations/instances.json");
  }
};

TEST_F(CocoTest, BoxesAndAreasOfSquares) {
  const Json set = written({{"categories", "node"}});
  ASSERT_EQ(set["images"].size(), 2u);
  EXPECT_EQ(set["images"][1], Json({{"id", 1}, {"file_name", "images/000001.png"}, {"width", 128}, {"height", 128}}));
  ASSERT_EQ(set["categories"].size(), 3u);
  EXPECT_EQ(set["categories"][0]["name"], "/squares/back");
  ASSERT_EQ(set["annotations"].size(), 6u);
  std::set<int> ids;
  for (const Json& annotation : set["annotations"]) {
    ids.insert(annotation["id"].get<int>());
    if (annotation["category_id"] == 1) {
      EXPECT_EQ(annotation["area"], 64 * 64 - 16 * 32);
      EXPECT_EQ(annotation["bbox"], Json({32, 32, 64, 64}));
    } else if (annotation["category_id"] == 2) {
      EXPECT_EQ(annotation["area"], 32 * 48);
      EXPECT_EQ(annotation["bbox"], Json({96, 0, 32, 48}));
    } else {
      EXPECT_EQ(annotation["area"], 32 * 32);
      EXPECT_EQ(annotation["bbox"], Json({80, 48, 32, 32}));
    }
  }
  EXPECT_EQ(ids, (std::set{1, 2, 3, 4, 5, 6}));
}

TEST_F(CocoTest, CategoriesOfAMapping) {
  const Json set = written({{"categories", {{"nothing", "ghost"}, {"front$", "sign"}, {"ba", "wall"}}}});
  ASSERT_EQ(set["categories"].size(), 3u);  // includes the ghost, which no object belongs to
  EXPECT_EQ(set["categories"][1]["name"], "sign");
  ASSERT_EQ(set["annotations"].size(), 4u);  // "cut" belongs to none of them
  for (const Json& annotation : set["annotations"])
    EXPECT_EQ(annotation["category_id"], annotation["node"] == "/squares/front" ? 2 : 3);
}

// Those of the scene come first. Frames may have others, if the scene changed since they were rendered.
TEST_F(CocoTest, CategoriesOfScenesAndFrames) {
  const std::unique_ptr<Format> format = make("coco");
  const auto entry = [](const char* category) { return Json{{"id", 0}, {"objects", {{{"category", category}}}}}; };
  const std::vector<Json> frames{entry("b"), entry("a"), entry("c")}, scenes{{"d", "b"}, nullptr, {"c", "b"}};
  format->writeSet({frames, scenes}, folder);
  std::vector<std::string> names;
  const Json set = json("annotations/instances.json");
  for (const Json& category : set["categories"]) names.push_back(category["name"]);
  EXPECT_EQ(names, (std::vector<std::string>{"b", "c", "d", "a"}));
}

std::string saidOfOptions(const Json& options) try {
  make("coco", options);
  return "";
} catch (const Error& error) {
  EXPECT_EQ(error.code(), ExitCode::Usage);
  return error.what();
}

const Json& annotationOf(const Json& set, const char* node) {
  for (const Json& annotation : set["annotations"])
    if (annotation["node"] == node) return annotation;
  throw std::logic_error("there is no annotation");
}

// The front square covers 16 x 32 of the back one's 64 x 64 pixels, and the cut one's left half is in the picture.
TEST_F(CocoTest, AmodalMasks) {
  const Json set = written({{"amodal", true}});
  const Json& back = annotationOf(set, "/squares/back");
  EXPECT_EQ(back["amodal_area"], 64 * 64);
  EXPECT_EQ(back["amodal_bbox"], Json({32, 32, 64, 64}));
  EXPECT_EQ(back["visibility"], 0.875);
  EXPECT_EQ(back["amodal_segmentation"]["size"], Json({128, 128}));
  EXPECT_NE(back["amodal_segmentation"]["counts"], back["segmentation"]["counts"]);
  const Json& front = annotationOf(set, "/squares/front");
  EXPECT_EQ(front["amodal_segmentation"], front["segmentation"]);
  EXPECT_EQ(front["visibility"], 1);
  EXPECT_EQ(annotationOf(set, "/squares/cut")["visibility"], 0.375);
}

// 32 pixels per meter; the front square has half the size.
TEST_F(CocoTest, KeypointsThatNoObjectHasAreWarnedOf) {
  const auto warnings = [&](const std::string& node) {
    testing::internal::CaptureStderr();
    written({{"categories", "node"}, {"keypoints", {{{"name", "tip"}, {"node", node}}}}});
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_THAT(warnings("hand"), testing::HasSubstr("no visible object has a node of the keypoints"));
  EXPECT_EQ(warnings(""), "");
}

TEST_F(CocoTest, KeypointsOfObjects) {
  const Json set = written({{"categories", "node"},
                            {"keypoints",
                             {{{"name", "upper"}, {"position", {0.5, 0.75, 0}}},
                              {{"name", "side"}, {"position", {0.75, 0, 0}}},
                              {{"name", "far"}, {"position", {3, 0, 0}}},
                              {{"name", "none"}, {"node", "hand"}}}},
                            {"skeleton", Json::array({Json::array({"side", "upper"})})}});
  const auto expect = [&](const char* node, const std::vector<double>& values, int count) {
    const Json& annotation = annotationOf(set, node);
    ASSERT_EQ(annotation["keypoints"].size(), values.size());
    for (size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(annotation["keypoints"][i], values[i], 1e-4) << node << i;
    EXPECT_EQ(annotation["num_keypoints"], count);
  };
  expect("/squares/back", {80, 40, 2, 88, 64, 1, 0, 0, 0, 0, 0, 0}, 2);
  expect("/squares/front", {104, 52, 2, 108, 64, 2, 0, 0, 0, 0, 0, 0}, 2);
  for (const Json& category : set["categories"]) {
    EXPECT_EQ(category["keypoints"], Json({"upper", "side", "far", "none"}));
    EXPECT_EQ(category["skeleton"], Json::array({Json::array({2, 1})}));
  }
  EXPECT_EQ(saidOfOptions({{"keypoints", Json::array()}}),
            "keypoints of the format coco must be a list of at least one keypoint");
  EXPECT_EQ(saidOfOptions({{"keypoints", {{{"name", "a"}}, {{"name", "a"}}}}}),
            "keypoints of the format coco has two keypoints named \"a\"");
  EXPECT_EQ(saidOfOptions({{"keypoints", {{{"name", "a"}}}}, {"skeleton", Json::array({Json::array({"a", "b"})})}}),
            "skeleton of the format coco names \"b\", which is not among its keypoints");
  EXPECT_EQ(saidOfOptions({{"skeleton", "a"}}),
            "skeleton of the format coco takes a list of pairs of keypoints' names");
}

std::string saidOf(const Json& categories) try {
  make("coco", {{"categories", categories}});
  return "";
} catch (const Error& error) {
  EXPECT_EQ(error.code(), ExitCode::Usage);
  return error.what();
}

// Names come from scene files of any origin. A backtracking matcher would take exponential time for one of these, and a
// recursive one would overflow the stack.
TEST_F(CocoTest, NoNameIsTooMuchForAnExpression) {
  const auto start = std::chrono::steady_clock::now();
  for (const char* expression : {"/.*wheel", "(a|b)*c", "(a+)+$x", "a*a*a*b", "(a*)*b"}) {
    PathRules rules;
    rules.add(expression, "categories");
    EXPECT_FALSE(rules.find(std::string(1'000'000, 'a'))) << expression;
  }
  PathRules rules;
  rules.add("^/.*wheel$", "categories");
  rules.add("a", "categories");
  EXPECT_EQ(rules.find("/" + std::string(1'000'000, 'a') + "wheel"), 0u);
  EXPECT_EQ(rules.find("/" + std::string(1'000'000, 'a')), 1u);
  EXPECT_EQ(rules.find("/\xff\xfe"), std::nullopt) << "names need not be UTF-8";
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

TEST_F(CocoTest, RefusesExpressionsInOneSentence) {
  for (const std::string& wrong : {std::string("("), std::string("a{2000}"), std::string("(?=a)"),
                                   std::string("(a)\\1"), std::string(5'000, '(') + std::string(4'000, ')')}) {
    const std::string said = saidOf({{wrong, "w"}});
    EXPECT_THAT(said, testing::HasSubstr("categories of the format coco has \"" + wrong.substr(0, 100)));
    EXPECT_THAT(said, testing::HasSubstr("no regular expression in RE2's syntax"));
    EXPECT_LT(said.size(), 1000u);
  }
  // Nested expressions need no stack, and the accepted length is limited.
  EXPECT_EQ(saidOf({{std::string(5'000, '(') + std::string(5'000, ')'), "w"}}), "");
  EXPECT_THAT(saidOf({{std::string(16'000, '(') + std::string(16'000, ')'), "w"}}),
              testing::HasSubstr("which is longer than 10000 bytes"));
  EXPECT_EQ(saidOf({{"/Car/.*[Ww]heel", "wheel"}, {"^/Car", "car"}, {R"(\d+$)", "number"}}), "");
}

TEST_F(CocoTest, CategoriesOfMeshesAndMaterials) {
  EXPECT_EQ(written({{"categories", "material"}})["categories"][1]["name"], "red");
  EXPECT_EQ(written({})["categories"].size(), 1u);  // instances of one mesh
}

}  // namespace
}  // namespace latelight::data::test
