// A viewing session on its own thread.
#include "view/session_thread.h"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <string>
#include <string_view>

#include "app/folder.h"
#include "models/models.h"

namespace latelight::view {
namespace {

// Waits for a state that meets a condition. Returns false after half an hour.
class News {
 public:
  void wake() {
    std::lock_guard lock(mutex_);
    ++number_;
    changed_.notify_all();
  }
  template <typename Condition>
  bool wait(SessionThread& thread, const Condition& condition) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(30);
    uint64_t number = 0;
    while (true) {
      if (const SessionThread::News news = thread.take(); news.state && condition(*news.state)) return true;
      std::unique_lock lock(mutex_);
      if (!changed_.wait_until(lock, end, [&] { return number_ != number; })) return false;
      number = number_;
    }
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  uint64_t number_ = 0;
};

// No picture follows a file that cannot be read.
TEST(SessionThreadTest, TellsThatAFileCannotBeRead) {
  const app::Folder folder;
  const std::string file = folder.at("scene.glb");
  std::filesystem::copy_file(models::modelPath("punctual.glb"), file);
  News news;
  SessionThread thread({.scene = file, .device = "cpu", .width = 32, .height = 24}, [&] { news.wake(); });
  folder.write("broken", std::string_view("no scene"));
  std::filesystem::rename(folder.at("broken"), file);
  EXPECT_TRUE(news.wait(thread, [](const State& state) { return state.error.find("scene.glb") != std::string::npos; }));
  std::filesystem::copy_file(models::modelPath("punctual.glb"), folder.at("good"));
  std::filesystem::rename(folder.at("good"), file);
  EXPECT_TRUE(news.wait(thread, [](const State& state) { return state.error.empty(); }));
}

}  // namespace
}  // namespace latelight::view
