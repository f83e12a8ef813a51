#include "data/batch/writers.h"

#include <system_error>
#include <unordered_set>

#include "base/error.h"
#include "base/parallel.h"
#include "base/threads.h"

namespace latelight::data {

namespace {

// Maximum number of queued frames per thread. A longer queue would only use more memory, whose allocation costs time.
constexpr size_t kWaitingFrames = 4;
constexpr uint64_t kBytesOfPoint = 71;  // of lidar::Points

uint64_t bytesOf(const RenderedFrame& frame) {
  uint64_t bytes = frame.frame.picture.display.size();
  for (const output::AovImage& aov : frame.frame.picture.aovs) bytes += 4 * (aov.values.size() + aov.ids.size());
  for (const FramePair& pair : frame.frame.pairs) bytes += labels::kBytesPerPixel * pair.match.visible.size();
  for (const FrameScan& scan : frame.frame.scans) bytes += kBytesOfPoint * scan.points.size();
  return bytes;
}

}  // namespace

Writers::Writers(const Job& job, ShardLog& log, Progress& progress, size_t threads, uint64_t waiting)
    : job_(job), log_(log), progress_(progress), most_(waiting) {
  try {
    threads_ = startThreads(threads, [this](size_t) { work(); });
  } catch (const std::system_error&) {
    fail(ExitCode::NoDevice, "this process may not start threads that write files: raise `ulimit -u`");
  }
}

Writers::~Writers() {
  {
    const std::lock_guard lock(mutex_);
    done_ = true;
  }
  more_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Writers::push(RenderedFrame frame) {
  const uint64_t bytes = bytesOf(frame);
  std::unique_lock lock(mutex_);
  spaceFreed_.wait(lock, [&] {
    return bytes_ == 0 || (bytes_ + bytes <= most_ && waiting_.size() < kWaitingFrames * threads_.size());
  });
  bytes_ += bytes;
  waiting_.push_back(std::move(frame));
  lock.unlock();
  more_.notify_one();
}

void Writers::work() {
  const SerialScope alone;
  std::unique_lock lock(mutex_);
  for (;;) {
    more_.wait(lock, [&] { return done_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    RenderedFrame frame = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    const uint64_t bytes = bytesOf(frame);
    write(std::move(frame));
    lock.lock();
    bytes_ -= bytes;
    spaceFreed_.notify_all();
  }
}

void Writers::write(RenderedFrame rendered) {
  FinishedFrame& record = rendered.record;
  std::vector<std::string> files;
  try {
    for (const JobFormat& use : job_.formats) {
      FrameRecord written = use.format->writeFrame(rendered.frame, job_.folder);
      files.insert(files.end(), written.files.begin(), written.files.end());
      record.entries.push_back(std::move(written.entry));
    }
    std::unordered_set<std::string> recorded;  // formats may share files
    for (const std::string& file : files)
      if (recorded.insert(file).second) record.files.push_back(recordOf(job_.folder, file));
    log_.finished(record);
  } catch (const std::exception& error) {
    removeFiles(job_.folder, files);  // a frame is either finished or absent
    log_.failed(record.name, error.what());
  }
  progress_.step();
}

}  // namespace latelight::data
