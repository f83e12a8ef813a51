#include "output/used_files.h"

#include <sys/stat.h>

#include <vector>

#include "support.h"

namespace latelight::output {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class Used : public InFolder {
 protected:
  void touch(const std::string& name) const { writeFile(at(name), {}); }
  void check(std::vector<fs::path> inputs, std::vector<fs::path> outputs) const {
    UsedFiles(inputs).checkOutputs(outputs);
  }
  std::string refusal(std::vector<fs::path> inputs, std::vector<fs::path> outputs) const {
    return errorOf([&] { check(inputs, outputs); });
  }
};

TEST_F(Used, InputsAreNotOutputsWhateverTheirNames) {
  fs::create_directory(at("sub"));
  touch("in.glb");
  fs::create_symlink("in.glb", at("link.glb"));
  fs::create_symlink(".", at("here"));
  fs::create_hard_link(at("in.glb"), at("second.glb"));
  for (const char* name : {"in.glb", "./in.glb", "sub/../in.glb", "link.glb", "here/in.glb", "second.glb"})
    EXPECT_THAT(refusal({at("in.glb")}, {at(name)}), AllOf(HasSubstr(name), HasSubstr("this command reads it")))
        << name;
  EXPECT_THAT(refusal({at("link.glb")}, {at("in.glb")}), HasSubstr("in.glb"));
  // A file that the scene refers to, but that does not exist.
  EXPECT_THAT(refusal({at("sub/missing.png")}, {at("sub/missing.png")}), HasSubstr("missing.png"));
  check({at("in.glb")}, {at("out.png"), at("sub/in.glb")});
}

TEST_F(Used, TwoOutputsAreTwoFiles) {
  fs::create_directory(at("sub"));
  EXPECT_THAT(refusal({}, {at("a.png"), at("a.png")}), AllOf(HasSubstr("two outputs"), HasSubstr("a.png")));
  EXPECT_THAT(refusal({}, {at("a.png"), at("sub/../a.png")}), HasSubstr("the same file"));
  touch("old.png");
  fs::create_symlink("old.png", at("link.png"));
  EXPECT_THAT(refusal({}, {at("link.png"), at("old.png")}), HasSubstr("the same file"));
  ASSERT_EQ(mkfifo(at("pipe").c_str(), 0600), 0);
  EXPECT_THAT(refusal({}, {at("pipe"), at("pipe")}), HasSubstr("two outputs"));
  // Writing replaces each name of a file separately, so hard links are separate outputs.
  fs::create_hard_link(at("old.png"), at("second.png"));
  check({}, {at("old.png"), at("second.png"), at("sub/old.png")});
  // In folders that do not exist yet.
  EXPECT_THAT(refusal({}, {at("new/a.png"), at("sub/../new/a.png")}), HasSubstr("the same file"));
}

TEST_F(Used, DevicesAndStandardOutputAreNoFiles) {
  fs::create_symlink("/dev/null", at("null.png"));
  EXPECT_NO_THROW(check({}, {"-", "-", "", "", at("null.png"), "/dev/null"}));
}

TEST_F(Used, EachCallIsOfItsOwn) {
  const std::vector<fs::path> inputs, outputs{at("a.png")};
  UsedFiles used(inputs);
  EXPECT_NO_THROW(used.checkOutputs(outputs));
  EXPECT_NO_THROW(used.checkOutputs(outputs));
}

}  // namespace
}  // namespace latelight::output
