// The examples of docs/variations.md are valid and vary a scene.
#include <fstream>
#include <set>

#include "data/variations/variation.h"
#include "data_variations/support.h"

namespace latelight::data::test {
namespace {

TEST(VariationsPageTest, ExamplesVary) {
  const Folder folder;
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  std::filesystem::create_directory("textures");
  folder.write("textures/a.bmp", bitmap(200, 100, 50));
  folder.write("sky.hdr", "is looked for, and read by the renderer");
  std::ifstream file(std::string(LATELIGHT_SOURCE_DIR) + "/docs/variations.md");
  const std::string text{std::istreambuf_iterator<char>(file), {}}, begin = "```json\n";
  std::set<std::string> types;
  for (size_t at = text.find(begin); at != text.npos; at = text.find(begin, at + 1)) {
    const std::string example = text.substr(at + begin.size(), text.find("```", at + begin.size()) - at - begin.size());
    SCOPED_TRACE(example);
    Varied varied(example);
    const Json said = varied.variations.apply(0);
    EXPECT_EQ(said.size(), Json::parse(example).size());
    for (const Json& one : said) types.insert(one["type"].get<std::string>());
  }
  for (const VariationKind& kind : variationKinds()) EXPECT_TRUE(types.contains(std::string(kind.name))) << kind.name;
  std::filesystem::current_path(before);
}

TEST(VariationsSchemaTest, HasEachKind) {
  std::ifstream file(std::string(LATELIGHT_SOURCE_DIR) + "/src/data/variations/schema.json");
  const Json schema = Json::parse(file);
  EXPECT_EQ(schema["items"]["oneOf"].size(), variationKinds().size());
  for (const VariationKind& kind : variationKinds()) {
    const Json& own = schema["$defs"][std::string(kind.name)];
    EXPECT_EQ(own["properties"]["type"]["const"], kind.name);
    EXPECT_EQ(own["description"], kind.description);
  }
}

}  // namespace
}  // namespace latelight::data::test
