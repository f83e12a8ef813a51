#include "base/files.h"
#include "app/folder.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "base/error.h"
#include "base/write.h"
#include "error_of.h"
#include "small_disk.h"

namespace latelight {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

std::span<const std::byte> bytesOf(std::string_view text) {
  return std::as_bytes(std::span(text));
}
std::string textOf(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

class Files : public testing::Test {
 protected:
  size_t entries() const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }
  app::Folder temporary;
  const fs::path folder = temporary.path();
};

TEST_F(Files, OfAGroupAppearTogetherOrNotAtAll) {
  writeFile(folder / "a", bytesOf("old"));
  fs::create_symlink("/dev/full", folder / "full");
  {
    FileGroup group;
    group.add(folder / "a", bytesOf("new"));
    group.add(folder / "b", bytesOf("new"));
    EXPECT_THAT(errorOf([&] { group.add(folder / "full", bytesOf("new")); }),
                AllOf(HasSubstr("full"), HasSubstr("No space left")));
    EXPECT_EQ(textOf(readFile(folder / "a")), "old");
  }
  EXPECT_EQ(textOf(readFile(folder / "a")), "old");
  EXPECT_EQ(entries(), 2u);

  FileGroup group;
  group.add(folder / "a", bytesOf("new"));
  group.add(folder / "b", bytesOf("new"));
  EXPECT_FALSE(isThere(folder / "b"));
  group.commit();
  for (const char* name : {"a", "b"}) EXPECT_EQ(textOf(readFile(folder / name)), "new") << name;
  EXPECT_EQ(entries(), 3u);
}

// A group may have more files than a process may open.
TEST_F(Files, OfALargeGroupAreAllWritten) {
  FileGroup group;
  for (int i = 0; i < 2000; ++i) group.add(folder / std::to_string(i), bytesOf(std::to_string(i)));
  group.commit();
  EXPECT_EQ(entries(), 2000u);
  EXPECT_EQ(textOf(readFile(folder / "0")), "0");
  EXPECT_EQ(textOf(readFile(folder / "1999")), "1999");
}

TEST_F(Files, ComeBackAsWritten) {
  for (const size_t size : {0, 1, 65535, 65536, 65537, 1 << 20}) {
    std::string text(size, '\0');
    for (size_t i = 0; i < size; ++i) text[i] = static_cast<char>(i * 31 % 251);
    writeFile(folder / "f", bytesOf(text));
    EXPECT_EQ(textOf(readFile(folder / "f")), text) << size;
  }
  EXPECT_EQ(entries(), 1u);
}

TEST_F(Files, ReadsFilesThatDoNotStateTheirSize) {
  EXPECT_THAT(textOf(readFile("/proc/self/status")), HasSubstr("Pid:"));
  // A pipe, as created by a shell's <(command), with more data than it can buffer, so its writer waits for the reader.
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const std::string text(200000, 'x');
  std::jthread writer([&] {
    for (size_t done = 0; done < text.size();) {
      const ssize_t got = write(ends[1], text.data() + done, text.size() - done);
      ASSERT_GT(got, 0);
      done += static_cast<size_t>(got);
    }
    close(ends[1]);
  });
  EXPECT_EQ(readFile("/dev/fd/" + std::to_string(ends[0])).size(), text.size());
  close(ends[0]);
}

TEST_F(Files, SaysWhyAFileCannotBeRead) {
  const fs::path missing = folder / "missing.glb";
  EXPECT_THAT(errorOf([&] { readFile(missing); }, ExitCode::BadInput),
              AllOf(HasSubstr(missing.string()), HasSubstr("No such file")));
  EXPECT_THAT(errorOf([&] { readFile(folder); }, ExitCode::BadInput),
              AllOf(HasSubstr(folder.string()), HasSubstr("folder, not a file")));
  EXPECT_THAT(errorOf([&] { readFile("/dev/zero"); }, ExitCode::BadInput), HasSubstr("not a file"));
}

TEST_F(Files, OfMoreBytesThanMemoryAreAnError) {
  const fs::path huge = folder / "huge";
  std::ofstream(huge).put('x');
  std::error_code error;
  fs::resize_file(huge, uintmax_t{1} << 46, error);  // sparse: needs no space on disk
  if (error) fs::resize_file(huge, (uintmax_t{1} << 44) - 4096, error);
  if (error) GTEST_SKIP() << "this file system has no sparse files of 16 TiB";
  EXPECT_THAT(errorOf([&] { readFile(huge); }, ExitCode::OutOfMemory), HasSubstr("memory"));
}

TEST_F(Files, LeaveNothingWhenTheyCannotBeWritten) {
  const fs::path nowhere = folder / "no" / "such" / "a.png";
  EXPECT_THAT(errorOf([&] { writeFile(nowhere, bytesOf("x")); }),
              AllOf(HasSubstr(nowhere.string()), HasSubstr("make its folder")));
  EXPECT_THAT(errorOf([&] { writeFile(folder, bytesOf("x")); }),
              AllOf(HasSubstr(folder.string()), HasSubstr("a file name")));
  EXPECT_THAT(errorOf([&] { writeFile("", bytesOf("x")); }), HasSubstr("without a name"));
  EXPECT_EQ(entries(), 0u);
}

// Only the owner of a file may change its permissions.
TEST_F(Files, OfAnotherUserAreNotAdvisedToBeMadeWritable) {
  const auto asAnotherUser = [] {
    constexpr uid_t kUser = 54321;
    if (geteuid() == 0 && setuid(kUser) != 0) _exit(2);
    try {
      checkWritable("/etc/passwd");
    } catch (const Error& error) {
      const std::string_view says = error.what();
      _exit(says.find("belongs to another user") != says.npos && says.find("chmod") == says.npos ? 0 : 1);
    }
    _exit(3);
  };
  EXPECT_EXIT(asAnotherUser(), testing::ExitedWithCode(0), "");
}

TEST_F(Files, KeepTheOldOneWhenTheDiskIsFull) {
  writeFile(folder / "f", bytesOf("old"));
  // A limit on file sizes simulates a full disk: the write fails halfway, after the temporary file was created.
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};
    setrlimit(RLIMIT_FSIZE, &limit);
    try {
      writeFile(folder / "f", bytesOf(std::string(5000, 'n')));
      _exit(0);
    } catch (const Error& error) {
      _exit(error.code() == ExitCode::Usage ? 42 : 1);
    }
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(WEXITSTATUS(status), 42);
  EXPECT_EQ(textOf(readFile(folder / "f")), "old");
  EXPECT_EQ(entries(), 1u);
}

// The write that reaches the limit is short, and the next one has the reason.
TEST_F(Files, AFileSizeLimitIsTheReason) {
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};
    setrlimit(RLIMIT_FSIZE, &limit);
    const int fd = open((folder / "f").c_str(), O_WRONLY | O_CREAT, 0600);
    _exit(writeAll(fd, bytesOf(std::string(5000, 'n'))));
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(WEXITSTATUS(status), EFBIG);
  EXPECT_EQ(textOf(readFile(folder / "f")), std::string(1000, 'n'));
  EXPECT_THAT(errorOf([&] { failToWrite("f", EFBIG); }),
              AllOf(HasSubstr("can't write 'f'"), HasSubstr("file size limit")));
}

TEST_F(Files, AppearWhole) {
  const std::string a(300000, 'a'), b(300000, 'b');
  writeFile(folder / "f", bytesOf(a));
  std::atomic<bool> stop = false;
  std::jthread writer([&] {
    for (int i = 0; i < 100; ++i) writeFile(folder / "f", bytesOf(i % 2 ? a : b));
    stop = true;
  });
  while (!stop) {
    const std::string text = textOf(readFile(folder / "f"));
    ASSERT_TRUE(text == a || text == b);
  }
}

TEST_F(Files, AreWrittenThroughLinksAndIntoPipes) {
  writeFile(folder / "target", bytesOf("old"));
  fs::create_symlink("target", folder / "link");
  writeFile(folder / "link", bytesOf("new"));
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(textOf(readFile(folder / "target")), "new");

  writeFile("/dev/null", bytesOf("x"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(Files, KeepTheModeOfWhatTheyReplace) {
  const fs::path path = folder / "f";
  const auto modeOf = [&] { return static_cast<int>(fs::status(path).permissions()); };
  const mode_t mask = umask(027);
  writeFile(path, bytesOf("new"));
  EXPECT_EQ(modeOf(), 0640);
  for (const int mode : {0600, 0644, 0666, 0755, 0200, 0020}) {
    ASSERT_EQ(chmod(path.c_str(), static_cast<mode_t>(mode)), 0);
    if (access(path.c_str(), W_OK) == 0) writeFile(path, bytesOf("again"));
    EXPECT_EQ(modeOf(), mode);
  }
  umask(mask);
}

TEST_F(Files, KeepTheOwnerOfWhatTheyReplace) {
  if (geteuid() != 0) GTEST_SKIP() << "Only root may give files to others.";
  writeFile(folder / "f", bytesOf("old"));
  ASSERT_EQ(chown((folder / "f").c_str(), 1234, 2345), 0);
  writeFile(folder / "f", bytesOf("new"));
  struct stat status {};
  ASSERT_EQ(stat((folder / "f").c_str(), &status), 0);
  EXPECT_EQ(status.st_uid, 1234u);
  EXPECT_EQ(status.st_gid, 2345u);
}

// Even for root, who may write to them.
TEST_F(Files, ThatAreReadOnlyAreNotReplaced) {
  writeFile(folder / "f", bytesOf("old"));
  ASSERT_EQ(chmod((folder / "f").c_str(), 0444), 0);
  for (const auto& call : std::vector<std::function<void()>>{[&] { writeFile(folder / "f", bytesOf("new")); },
                                                             [&] { checkWritable(folder / "f"); }})
    EXPECT_THAT(errorOf(call), HasSubstr("read-only"));
  EXPECT_EQ(textOf(readFile(folder / "f")), "old");
  EXPECT_EQ(entries(), 1u);
}

// Permissions cannot be changed there.
TEST_F(Files, OnReadOnlyDisksAreReportedAsSuch) {
  const test::SmallDisk disk(64u << 10);
  if (!disk) GTEST_SKIP() << "This user may not mount a disk.";
  const fs::path file = disk.path() / "f";
  writeFile(file, bytesOf("old"));
  ASSERT_EQ(mount("tmpfs", disk.path().c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, nullptr), 0);
  for (const auto& call :
       std::vector<std::function<void()>>{[&] { writeFile(file, bytesOf("new")); }, [&] { checkWritable(file); }}) {
    const std::string text = errorOf(call);
    EXPECT_THAT(text, HasSubstr("the file system is read-only"));
    EXPECT_THAT(text, testing::Not(HasSubstr("chmod")));
  }
}

TEST_F(Files, AreNotWrittenWhereLinksLeadNowhere) {
  fs::create_symlink("b", folder / "a");
  fs::create_symlink("a", folder / "b");
  fs::create_symlink("missing", folder / "dangling");
  for (const auto& write :
       std::vector<std::function<void(const fs::path&)>>{[&](const fs::path& path) { writeFile(path, bytesOf("x")); },
                                                         [&](const fs::path& path) { checkWritable(path); }}) {
    EXPECT_THAT(errorOf([&] { write(folder / "a"); }), HasSubstr("circle"));
    EXPECT_THAT(errorOf([&] { write(folder / "dangling"); }),
                AllOf(HasSubstr("link to 'missing'"), HasSubstr("does not exist")));
  }
  EXPECT_TRUE(fs::is_symlink(folder / "dangling"));
  EXPECT_EQ(entries(), 3u);
}

TEST_F(Files, AreWrittenIntoPipesThatSomebodyReads) {
  const fs::path pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(errorOf([&] { writeFile(pipe, bytesOf("x")); }), HasSubstr("without a reader"));
  checkWritable(pipe);  // the reader may come later
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  writeFile(pipe, bytesOf("picture"));
  char text[16];
  EXPECT_EQ(read(reader, text, sizeof(text)), 7);
  // More than a pipe buffers, and a reader that closes it.
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  std::jthread leaving([&] {
    while (read(reader, text, 1) < 1) std::this_thread::yield();
    close(reader);
  });
  EXPECT_THAT(errorOf([&] { writeFile(pipe, bytesOf(std::string(1 << 20, 'x'))); }), HasSubstr("Broken pipe"));
  std::signal(SIGPIPE, before);
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST_F(Files, CheckLeavesNothing) {
  checkWritable(folder / "new");
  checkWritable("-");
  EXPECT_EQ(entries(), 0u);
  EXPECT_THAT(errorOf([&] { checkWritable(folder / "no" / "a"); }), HasSubstr("make its folder"));
  EXPECT_THAT(errorOf([] { checkWritable("/proc/a.png"); }), HasSubstr("/proc/a.png"));
}

TEST_F(Files, DashIsStandardOutput) {
  testing::internal::CaptureStdout();
  writeFile("-", bytesOf("picture"));
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "picture");
}

TEST_F(Files, TakeLongNames) {
  const fs::path path = folder / std::string(255, 'n');
  writeFile(path, bytesOf("x"));
  EXPECT_EQ(textOf(readFile(path)), "x");
}

class Cache : public Files {
 protected:
  Cache() {
    unsetenv("LATELIGHT_NO_CACHE");
    setenv("XDG_CACHE_HOME", folder.c_str(), 1);
  }
};

TEST_F(Cache, IsWhereXdgSays) {
  EXPECT_EQ(cacheFolder(), folder / "latelight");
  EXPECT_TRUE(fs::is_directory(folder / "latelight"));
  EXPECT_EQ(fs::status(folder / "latelight").permissions() & fs::perms::others_all, fs::perms::none);

  setenv("XDG_CACHE_HOME", (folder / "deep" / "er").c_str(), 1);
  EXPECT_EQ(cacheFolder(), folder / "deep" / "er" / "latelight");

  setenv("XDG_CACHE_HOME", "relative", 1);
  setenv("HOME", folder.c_str(), 1);
  EXPECT_EQ(cacheFolder(), folder / ".cache" / "latelight");

  unsetenv("HOME");
  EXPECT_EQ(cacheFolder(), std::nullopt);
}

TEST_F(Cache, GivesBackWhatWasStored) {
  EXPECT_EQ(loadCache("e"), std::nullopt);
  for (const std::string text : {"", "one", "another"}) {
    storeCache("e", bytesOf(text));
    const auto entry = loadCache("e");
    ASSERT_TRUE(entry);
    EXPECT_EQ(textOf(*entry), text);
  }
}

TEST_F(Cache, ForgetsDamagedEntries) {
  storeCache("e", bytesOf("a pipeline cache"));
  const fs::path path = folder / "latelight" / "e";
  const std::vector<std::byte> good = readFile(path);
  for (size_t i = 0; i < good.size(); ++i) {
    std::vector<std::byte> bad = good;
    bad[i] ^= std::byte{0x10};
    writeFile(path, bad);
    EXPECT_EQ(loadCache("e"), std::nullopt) << "byte " << i << " flipped";
    writeFile(path, std::span(good).first(i));
    EXPECT_EQ(loadCache("e"), std::nullopt) << "cut to " << i;
  }
}

// The writer does not wait for either, and does not replace the target of a link.
TEST_F(Cache, ReplacesPipesAndLinks) {
  storeCache("e", bytesOf("x"));
  const fs::path path = folder / "latelight" / "e";
  fs::remove(path);
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  EXPECT_EQ(loadCache("e"), std::nullopt);
  storeCache("e", bytesOf("after a pipe"));
  EXPECT_EQ(textOf(loadCache("e").value()), "after a pipe");
  writeFile(folder / "another's", bytesOf("theirs"));
  fs::remove(path);
  fs::create_symlink(folder / "another's", path);
  storeCache("e", bytesOf("after a link"));
  EXPECT_EQ(textOf(loadCache("e").value()), "after a link");
  EXPECT_EQ(textOf(readFile(folder / "another's")), "theirs");
}

TEST_F(Cache, IsNeverRequired) {
  setenv("LATELIGHT_NO_CACHE", "1", 1);
  EXPECT_EQ(cacheFolder(), std::nullopt);
  storeCache("e", bytesOf("x"));
  EXPECT_EQ(loadCache("e"), std::nullopt);
  EXPECT_EQ(entries(), 0u);

  unsetenv("LATELIGHT_NO_CACHE");
  setenv("XDG_CACHE_HOME", "/dev/null/nowhere", 1);
  EXPECT_EQ(cacheFolder(), std::nullopt);
  storeCache("e", bytesOf("x"));
  EXPECT_EQ(loadCache("e"), std::nullopt);
}

}  // namespace
}  // namespace latelight
