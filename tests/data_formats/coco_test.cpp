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
    EXPECT_EQ(format->writeSet(entries, folder), std::vector<std::string>{"annotations/instances.json"});
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
