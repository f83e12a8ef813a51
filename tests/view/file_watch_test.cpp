#include "view/file_watch.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string_view>
#include <thread>

#include "app/folder.h"

namespace latelight::view {
namespace {

using namespace std::chrono_literals;

// Files with times that the test states, since those of the file system may be too coarse to differ.
class FileWatchTest : public testing::Test {
 protected:
  void write(std::string_view name, std::chrono::seconds time) {
    folder.write(name, std::string_view("text"));
    std::filesystem::last_write_time(folder.at(name), std::filesystem::file_time_type() + time);
  }
  // After as many checks as a change requires.
  static bool changes(FileWatch& watch) {
    bool changed = false;
    for (int check = 0; check < 3; ++check) {
      std::this_thread::sleep_for(std::chrono::duration<double>(1.1 * FileWatch::kSeconds));
      changed |= watch.changed();
    }
    return changed;
  }

  const app::Folder folder;
};

TEST_F(FileWatchTest, NoticesChangesFromItsFirstCallOn) {
  write("a", 1s);
  FileWatch watch;
  watch.add(folder.at("a"));
  write("a", 2s);
  watch.add(folder.at("a"));
  EXPECT_TRUE(changes(watch));
  EXPECT_FALSE(changes(watch));
}

TEST_F(FileWatchTest, NoticesFilesThatAppearButNotThatOneIsDeleted) {
  write("a", 1s);
  FileWatch watch;
  for (const char* name : {"a", "b"}) watch.add(folder.at(name));
  EXPECT_FALSE(changes(watch));
  std::filesystem::remove(folder.at("a"));
  EXPECT_FALSE(changes(watch));
  write("b", 2s);
  EXPECT_TRUE(changes(watch)) << "although the other file does not exist";
  write("a", 1s);
  EXPECT_TRUE(changes(watch));
}

// Another attempt to read the same files saw a file missing.
TEST_F(FileWatchTest, FilesThatWereMissingForAnotherWatchAreNewOnceTheyExist) {
  write("a", 1s);
  FileWatch watch, other;
  watch.add(folder.at("a"));
  std::filesystem::remove(folder.at("a"));
  for (const char* name : {"a", "b"}) other.add(folder.at(name));
  watch.add(other);
  EXPECT_FALSE(changes(watch));
  write("a", 1s);
  EXPECT_TRUE(changes(watch));
  write("b", 1s);
  EXPECT_TRUE(changes(watch));
}

}  // namespace
}  // namespace latelight::view
