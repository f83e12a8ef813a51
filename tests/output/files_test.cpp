#include "output/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "output/png.h"
#include "support.h"

namespace latelight::output {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class Output : public InFolder {
 protected:
  OutputRequest request(const std::string& name, std::vector<Aov> aovs = {Aov::Color}) const {
    return {at(name), std::move(aovs), std::nullopt};
  }
  // Checks the path, then writes the file.
  std::vector<std::string> write(const OutputRequest& request, const Metadata& metadata = {}) {
    checkOutput(request);
    std::vector<std::string> written;
    for (const fs::path& path : writeOutput(request, frame, metadata)) {
      written.push_back(path.lexically_relative(folder).string());
    }
    return written;
  }
  FrameOutput frame = frameOfNumbers(9, 5);
};

TEST_F(Output, TakesItsFormatFromTheEnding) {
  EXPECT_EQ(formatOf("a.png"), Format::Png);
  EXPECT_EQ(formatOf("a.b/c.EXR"), Format::Exr);
  EXPECT_EQ(formatOf("{scene}.npy"), Format::Npy);
  EXPECT_EQ(formatOf("-"), Format::Png);
  for (const char* name : {"a.jpg", "a", "", ".png", "png", "a.png/"}) {
    EXPECT_THAT(errorOf([&] { formatOf(name); }), AllOf(HasSubstr(".png"), HasSubstr(".exr"), HasSubstr(".npy")))
        << name;
  }
}

TEST_F(Output, OfColorAloneIsOneFile) {
  EXPECT_THAT(write(request("a.png")), ElementsAre("a.png"));
  EXPECT_THAT(write(request("a.exr")), ElementsAre("a.exr"));
  EXPECT_THAT(write(request("a.npy")), ElementsAre("a.npy"));
  EXPECT_THAT(names(), ElementsAre("a.exr", "a.npy", "a.png"));
}

TEST_F(Output, OfSeveralAovsIsOneExrOrAFileEach) {
  const std::vector<Aov> aovs{Aov::Color, Aov::Depth, Aov::Id};
  EXPECT_THAT(write(request("a.exr", aovs)), ElementsAre("a.exr", "a.json"));
  EXPECT_THAT(write(request("b.png", aovs)), ElementsAre("b.png", "b.depth.png", "b.id.png", "b.json"));
  EXPECT_THAT(write(request("c-{aov}.npy", aovs)),
              ElementsAre("c-color.npy", "c-depth.npy", "c-id.npy", "c-meta.json"));
  EXPECT_THAT(write(request("d-{aov}.exr", aovs)),
              ElementsAre("d-color.exr", "d-depth.exr", "d-id.exr", "d-meta.json"));
  EXPECT_EQ(readImage(at("a.exr")).channels.size(), 6u);
  EXPECT_EQ(readImage(at("d-depth.exr")).channels.size(), 1u);
}

TEST_F(Output, OfOneDataAovKeepsItsName) {
  EXPECT_THAT(write(request("a.npy", {Aov::Depth})), ElementsAre("a.npy", "a.json"));
}

TEST_F(Output, HasASideFileWhereAskedFor) {
  OutputRequest color = request("a.png");
  color.sideFile = true;
  EXPECT_THAT(write(color), ElementsAre("a.png", "a.json"));
  OutputRequest depth = request("b.exr", {Aov::Depth});
  depth.sideFile = false;
  EXPECT_THAT(write(depth), ElementsAre("b.exr"));
}

TEST_F(Output, FillsInBraces) {
  Metadata metadata;
  metadata.scene = "hall";
  metadata.frame = 12;
  metadata.camera.name = "../left/eye";
  EXPECT_THAT(write(request("{scene}.{frame}.{camera}.png"), metadata), ElementsAre("hall.0012._._left_eye.png"));
  EXPECT_THAT(write(request("{scene}-{camera}.png")), ElementsAre("scene-camera.png"));
}

TEST_F(Output, MakesTheFoldersThatBracesName) {
  EXPECT_THAT(write(request("{aov}/{frame}.png", {Aov::Depth, Aov::Ao})),
              ElementsAre("depth/0000.png", "ao/0000.png", "meta/0000.json"));
  const std::vector<std::byte> bytes = readFile(at("meta/0000.json"));
  const auto json = nlohmann::json::parse(reinterpret_cast<const char*>(bytes.data()),
                                          reinterpret_cast<const char*>(bytes.data()) + bytes.size());
  EXPECT_EQ(json["aovs"]["depth"]["file"], "../depth/0000.png");
}

TEST_F(Output, OfColorInPngIsTheDisplayPicture) {
  EXPECT_TRUE(usesDisplay(request("a.png")));
  EXPECT_FALSE(usesDisplay(request("a.exr")));
  frame.aovs.clear();
  write(request("a.png"));
  const ReadImage back = readImage(at("a.png"));
  for (size_t i = 0; i < frame.display.size(); ++i) {
    ASSERT_EQ(back.channels[i % 4].values[i / 4], frame.display[i] / 255.0);
  }
}

TEST_F(Output, IsCheckedBeforeRendering) {
  const auto says = [&](const std::string& name, std::vector<Aov> aovs = {Aov::Color}) {
    return errorOf([&] { checkOutput(request(name, std::move(aovs))); });
  };
  EXPECT_THAT(says("a.bmp"), HasSubstr(".png, .exr or .npy"));
  EXPECT_THAT(says("{view}.png"), AllOf(HasSubstr("{view}"), HasSubstr("{aov}, {frame}, {camera}, {scene}")));
  EXPECT_THAT(says("{scene.png"), HasSubstr("unmatched"));
  EXPECT_THAT(says("scene}.png"), HasSubstr("unmatched"));
  EXPECT_THAT(says("a.png", {Aov::Color, Aov::Position}), AllOf(HasSubstr("position"), HasSubstr(".exr or .npy")));
  EXPECT_THAT(says("a.png", {}), HasSubstr("at least one"));
  EXPECT_THAT(says("no/such/a.png"), AllOf(HasSubstr("does not exist"), HasSubstr("no/such")));
  EXPECT_THAT(says("no/{aov}/a.png"), HasSubstr("does not exist"));
  fs::create_directory(folder / "a.png");
  EXPECT_THAT(says("a.png"), HasSubstr("is a folder"));
  EXPECT_THAT(errorOf([] { checkOutput({"-", {Aov::Position}, std::nullopt}); }), HasSubstr("position"));
  EXPECT_THAT(errorOf([] {
                checkOutput({"-", {Aov::Color, Aov::Depth, Aov::Id}, std::nullopt});
              }),
              AllOf(HasSubstr("one PNG file"), HasSubstr("3 outputs")));
  checkOutput(request("ok.png"));
  EXPECT_THAT(names(), ElementsAre("a.png/"));
}

TEST_F(Output, ToAFolderThatIsClosedIsRefusedBeforeRendering) {
  if (geteuid() == 0) {
    // Permissions do not restrict root, but the kernel's own folder does, on writing.
    EXPECT_THAT(errorOf([&] {
                  writeOutput({"/proc/a.png", {Aov::Color}, std::nullopt}, frame, {});
                }),
                HasSubstr("/proc/a.png"));
    return;
  }
  fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_THAT(errorOf([&] { checkOutput(request("a.png")); }), HasSubstr("Permission denied"));
  fs::permissions(folder, fs::perms::owner_all);
}

TEST_F(Output, LeavesNothingBehindOnAFullDisk) {
  fs::create_symlink("/dev/full", at("full.exr"));
  const OutputRequest full = request("full.exr", {Aov::Color, Aov::Depth});
  checkOutput(full);
  EXPECT_THAT(errorOf([&] { writeOutput(full, frame, {}); }), AllOf(HasSubstr("full.exr"), HasSubstr("No space left")));
  EXPECT_THAT(names(), ElementsAre("full.exr"));
}

// The color of another picture must not be left next to the depth of the old one.
TEST_F(Output, OfSeveralFilesIsReplacedTogether) {
  write(request("a.png"));
  const std::vector<std::byte> old = readFile(at("a.png"));
  fs::create_symlink("/dev/full", at("a.depth.png"));
  frame = frameOfNumbers(12, 7);
  EXPECT_THAT(errorOf([&] {
                writeOutput(request("a.png", {Aov::Color, Aov::Depth}), frame, {});
              }),
              AllOf(HasSubstr("a.depth.png"), HasSubstr("No space left")));
  EXPECT_EQ(readFile(at("a.png")), old);
  EXPECT_THAT(names(), ElementsAre("a.depth.png", "a.png"));
}

TEST_F(Output, KeepsTheOldFileWhenItsFolderGoes) {
  EXPECT_THAT(errorOf([&] { writeOutput(request("gone/a.exr"), frame, {}); }), HasSubstr("gone/a.exr"));
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(Output, IsTheSameEveryTime) {
  for (const char* ending : {"png", "exr", "npy"}) {
    std::vector<Aov> aovs = allAovs();
    if (std::string_view(ending) == "png")
      std::erase_if(aovs, [](Aov aov) { return info(aov).png == PngCoding::None; });
    const auto first = write(request(std::string("one-{aov}.") + ending, aovs));
    const auto second = write(request(std::string("two-{aov}.") + ending, aovs));
    ASSERT_EQ(first.size(), second.size());
    for (size_t i = 0; i + 1 < first.size(); ++i)
      EXPECT_EQ(readFile(at(first[i])), readFile(at(second[i]))) << first[i];
  }
}

// While it exists, standard output goes to a file.
class Redirected {
 public:
  explicit Redirected(const std::string& path) : saved_(dup(STDOUT_FILENO)) {
    const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(fd, STDOUT_FILENO);
    close(fd);
  }
  ~Redirected() {
    dup2(saved_, STDOUT_FILENO);
    close(saved_);
  }

 private:
  int saved_;
};

TEST_F(Output, ToStandardOutputIsAPng) {
  {
    const Redirected redirected(at("stdout"));
    EXPECT_THAT(writeOutput({"-", {Aov::Depth}, true}, frame, {}), IsEmpty());
  }
  EXPECT_EQ(readFile(at("stdout")), encodePng(frame.aovs[static_cast<size_t>(Aov::Depth)]));
  EXPECT_THAT(names(), ElementsAre("stdout"));
}

TEST_F(Output, OfAPictureIsPng) {
  writePicture(at("p.png"), {2, 1, {10, 20, 30, 255, 1, 2, 3, 4}});
  const ReadImage back = readImage(at("p.png"));
  EXPECT_EQ(back.find("A")->values, (std::vector<double>{1, 4 / 255.0}));
}

}  // namespace
}  // namespace latelight::output
