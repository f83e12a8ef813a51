// The files that a scene file may refer to, and those that it may not.
#include "base/allowed_folders.h"
#include "app/folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <thread>

#include "base/error.h"

namespace latelight {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

// Creates a folder "scene" with "scene.gltf", "a.bin" and "deep/b.bin", and next to it "secret.bin" and "other/c.bin".
class AllowedFoldersTest : public testing::Test {
 protected:
  AllowedFoldersTest() {
    for (const char* folder : {"scene/deep", "other"}) fs::create_directories(root / folder);
    for (const char* file : {"scene/scene.gltf", "scene/a.bin", "scene/deep/b.bin", "secret.bin", "other/c.bin"})
      std::ofstream(root / file) << file;
  }

  std::string read(const fs::path& name) const { return readFor(root / "scene/scene.gltf", name); }
  std::string readFor(const fs::path& owner, const fs::path& name, std::vector<std::string> allowed = {}) const {
    const std::vector<std::byte> bytes = AllowedFolders(owner, allowed).read(name);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  std::string refusal(const fs::path& name, std::vector<std::string> allowed = {}) const {
    try {
      readFor(root / "scene/scene.gltf", name, std::move(allowed));
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::BadInput);
      return error.what();
    }
    ADD_FAILURE() << name << " was read";
    return "";
  }
  void link(const char* to, const char* name) const { fs::create_symlink(to, root / name); }

  app::Folder folder;
  const fs::path root = fs::canonical(folder.path());
};

TEST_F(AllowedFoldersTest, HoldWhatLiesInAndBelow) {
  EXPECT_EQ(read("a.bin"), "scene/a.bin");
  EXPECT_EQ(read("deep/b.bin"), "scene/deep/b.bin");
  EXPECT_EQ(read("deep/../a.bin"), "scene/a.bin");
  EXPECT_EQ(read("../scene/a.bin"), "scene/a.bin");
  EXPECT_EQ(read(root / "scene/a.bin"), "scene/a.bin");
}

TEST_F(AllowedFoldersTest, TellWhichFilesAreReadOrMissing) {
  std::vector<fs::path> files;
  const AllowedFolders folders(root / "scene/scene.gltf", {}, [&](const fs::path& file) { files.push_back(file); });
  const fs::path scene = fs::canonical(root / "scene");
  EXPECT_TRUE(folders.exists("deep/b.bin"));
  EXPECT_FALSE(folders.exists("later.bin"));
  folders.read("a.bin");
  EXPECT_ANY_THROW(folders.read("none.bin"));
  EXPECT_THAT(files,
              testing::ElementsAre(scene / "deep/b.bin", scene / "later.bin", scene / "a.bin", scene / "none.bin"));
}

TEST_F(AllowedFoldersTest, RefuseWhatLiesOutside) {
  for (const fs::path& name : {fs::path("../secret.bin"), root / "secret.bin", fs::path("/etc/passwd"),
                               fs::path("deep/../../secret.bin"), fs::path("../other/c.bin")})
    EXPECT_THAT(refusal(name),
                AllOf(HasSubstr(name.string()), HasSubstr("outside the scene's folder"), HasSubstr("--allow-outside")));
  EXPECT_THAT(refusal("nowhere.bin"), HasSubstr("nowhere.bin, which does not exist"));
  // A folder whose name begins with the same letters is a different one.
  fs::create_directories(root / "scene2");
  std::ofstream(root / "scene2/d.bin") << "d";
  EXPECT_THAT(refusal("../scene2/d.bin"), HasSubstr("outside"));
}

TEST_F(AllowedFoldersTest, FollowLinksToTheirEnd) {
  link("a.bin", "scene/inside.bin");
  link("../secret.bin", "scene/outside.bin");
  link("../other", "scene/folder");
  link("circle.bin", "scene/circle.bin");
  EXPECT_EQ(read("inside.bin"), "scene/a.bin");
  EXPECT_THAT(refusal("outside.bin"), AllOf(HasSubstr("outside.bin"), HasSubstr((root / "secret.bin").string())));
  EXPECT_THAT(refusal("folder/c.bin"), HasSubstr((root / "other/c.bin").string()));
  EXPECT_THAT(refusal("circle.bin"), HasSubstr("cannot be found"));
}

// Scenes are often reached through symbolic links, to the scene file or to all of its files.
TEST_F(AllowedFoldersTest, ASceneThatIsALinkHasTwoFolders) {
  fs::create_directories(root / "links");
  link("../scene/scene.gltf", "links/scene.gltf");
  std::ofstream(root / "links/near.bin") << "near";
  EXPECT_EQ(readFor(root / "links/scene.gltf", "near.bin"), "near");
  EXPECT_EQ(readFor(root / "links/scene.gltf", "a.bin"), "scene/a.bin");
  link("../scene/a.bin", "links/a.bin");
  EXPECT_EQ(readFor(root / "links/scene.gltf", "a.bin"), "scene/a.bin");
  EXPECT_THROW(readFor(root / "links/scene.gltf", "../secret.bin"), Error);
}

TEST_F(AllowedFoldersTest, AllowedFoldersAreHeldToo) {
  const std::string other = (root / "other").string();
  EXPECT_EQ(readFor(root / "scene/scene.gltf", "../other/c.bin", {other}), "other/c.bin");
  EXPECT_EQ(readFor(root / "scene/scene.gltf", "../secret.bin", {other, root.string()}), "secret.bin");
  EXPECT_THAT(refusal("../secret.bin", {other}), HasSubstr("outside"));
  EXPECT_THROW(readFor("scene.gltf", "a.bin", {(root / "secret.bin").string()}), Error);
  try {
    AllowedFolders(root / "scene/scene.gltf", std::vector<std::string>{(root / "none").string()});
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::Usage);
  }
}

TEST_F(AllowedFoldersTest, AreOfFilesAloneEvenWhereAllIsAllowed) {
  ASSERT_EQ(mkfifo((root / "scene/pipe").c_str(), 0600), 0);
  link("/dev/zero", "scene/zero");
  link("/proc/self/environ", "scene/environ");
  const int socketFile = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
  const std::string path = (root / "scene/socket").string();
  ASSERT_LT(path.size(), sizeof(address.sun_path));
  path.copy(address.sun_path, path.size());
  ASSERT_EQ(bind(socketFile, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  close(socketFile);
  for (const char* name : {"pipe", "zero", "environ", "socket", "deep", "/dev/zero", "/proc/self/environ",
                           "/proc/version", "/sys/kernel/mm/transparent_hugepage/enabled"}) {
    if (!fs::exists(root / "scene" / name)) continue;  // containers may have no /sys
    EXPECT_THAT(refusal(name, {"/"}), AllOf(HasSubstr(name), HasSubstr("not a regular file"))) << name;
  }
}

// A path that is a valid file when it is checked and a link when it is opened.
TEST_F(AllowedFoldersTest, AreNotDeceivedByWhatChanges) {
  std::atomic<bool> done = false;
  std::thread swapper([&] {
    for (bool good = false; !done; good = !good) {
      std::error_code ignored;
      fs::remove(root / "scene/next", ignored);
      if (good)
        fs::copy_file(root / "scene/a.bin", root / "scene/next", ignored);
      else
        fs::create_symlink("../secret.bin", root / "scene/next", ignored);
      fs::rename(root / "scene/next", root / "scene/swapped", ignored);
    }
  });
  unsigned secrets = 0;
  for (int i = 0; i < 3000; ++i) {
    try {
      secrets += read("swapped") == "secret.bin";
    } catch (const Error&) {
    }
  }
  done = true;
  swapper.join();
  EXPECT_EQ(secrets, 0u);
}

}  // namespace
}  // namespace latelight
