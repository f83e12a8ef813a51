// The format "video": the frames as an mp4 video, encoded by ffmpeg.
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <system_error>

#include "base/error.h"
#include "base/files.h"
#include "base/temporary_file.h"
#include "base/write.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/options.h"
#include "data/formats/picture_file.h"
#include "data/stop.h"

namespace latelight::data {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

bool isInstalled(const char* program) {
  const char* folders = std::getenv("PATH");
  const std::string list = folders ? folders : "";
  for (size_t begin = 0; begin <= list.size();) {
    const size_t end = std::min(list.find(':', begin), list.size());
    if (access((fs::path(list.substr(begin, end - begin)) / program).c_str(), X_OK) == 0) return true;
    begin = end + 1;
  }
  return false;
}

// A running ffmpeg process. It reads pictures from a socket instead of a pipe, so that send() returns an error without
// a signal if the process ends early. Its own process group keeps the terminal from sending it Ctrl-C.
class Ffmpeg {
 public:
  // `output` is the descriptor of the open output file. It becomes the child's standard output, /proc/self/fd/1.
  Ffmpeg(std::vector<std::string> arguments, int output) {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) failed(errno);
    input_ = ends[0];
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes, 0);
    std::vector<char*> texts;
    for (std::string& argument : arguments) texts.push_back(argument.data());
    texts.push_back(nullptr);
    const int error = posix_spawnp(&child_, texts[0], &actions, &attributes, texts.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    if (error == 0) return;
    close(input_);  // the destructor of an object whose constructor fails does not run
    failed(error);
  }
  // Ends a process that is still encoding, because the video is not needed.
  ~Ffmpeg() {
    close(input_);
    if (child_ == 0) return;
    kill(child_, SIGKILL);
    wait();
  }
  Ffmpeg(const Ffmpeg&) = delete;
  Ffmpeg& operator=(const Ffmpeg&) = delete;

  // Returns false if the process has ended.
  bool send(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = ::send(input_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent < 0 && errno == EINTR) continue;
      if (sent <= 0) return false;
      bytes = bytes.subspan(static_cast<size_t>(sent));
    }
    return true;
  }

  // Call after the last picture. Returns true if ffmpeg has encoded the video.
  bool finish() {
    shutdown(input_, SHUT_WR);
    const int status = wait();
    child_ = 0;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }

 private:
  [[noreturn]] static void failed(int error) {
    badUsage("cannot start ffmpeg: {}", std::generic_category().message(error));
  }
  int wait() const {
    int status = 0;
    while (waitpid(child_, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
  }

  int input_ = -1;
  pid_t child_ = 0;
};

class Video : public Format {
 public:
  explicit Video(const Json& json) {
    FormatOptions options("video", json);
    file_ = options.setFile("file", "video.mp4", ".mp4");
    picture_ = PictureFile(options);
    rate_ = options.number("fps", 24, 1e-2, 1e3);
    options.finish();
    if (!isInstalled("ffmpeg")) badUsage("the format video requires ffmpeg: install it (Debian's package is ffmpeg)");
  }

  std::vector<output::Aov> needs() const override { return {}; }
  bool needsDisplay() const override { return picture_.isWritten(); }
  std::vector<FormatFile> files(const DataFrame& frame) const override {
    std::vector<FormatFile> files = picture_.files(frame);
    files.push_back({.name = file_, .ofSet = true});
    return files;
  }

  std::vector<std::string> filesOfOthers(const DataFrame& frame) const override {
    return picture_.isWritten() ? std::vector<std::string>() : std::vector{picture_.file(frame)};
  }

  // ffmpeg would scale images of other sizes to that of the first one. The first cameras of all scenes have one size,
  // because the job states the sizes of cameras.
  void checkTogether(const DataFrame& first, const DataFrame& other) const override {
    const output::FrameOutput &a = first.picture, &b = other.picture;
    if (a.width != b.width || a.height != b.height)
      badUsage(
          "the format video requires images of one size, but those of the cameras \"{}\" and \"{}\" have {}x{} and "
          "{}x{} pixels: give all cameras one size",
          first.metadata.camera.name, other.metadata.camera.name, a.width, a.height, b.width, b.height);
  }

  void writeFiles(const DataFrame& frame, const fs::path& folder, FrameRecord& record) const override {
    record.entry = picture_.write(record, frame, folder);
  }

  std::vector<std::string> writeSet(const SetEntries& set, const fs::path& folder) const override {
    const std::span<const Json> entries = set.frames;
    if (entries.empty()) return {};
    const fs::path path = folder / file_;
    std::error_code ignored;  // errors are reported when the file is opened
    fs::create_directories(path.parent_path(), ignored);
    TemporaryFile file(path, 0666);
    if (file.error() != 0) failToWrite(path, file.error());
    Ffmpeg ffmpeg(arguments(), file.get());
    bool made = true;
    for (const Json& entry : entries) {
      throwIfStopped();
      made = made && ffmpeg.send(readFile(folder / entry.get<std::string>()));
    }
    if (!ffmpeg.finish() || !made) {
      throwIfStopped();  // a signal to all processes of a job, as Slurm sends it, also ends ffmpeg
      badUsage("ffmpeg failed to encode '{}'; check that the disk is not full", path.string());
    }
    if (const int error = file.become(path)) failToWrite(path, error);
    return {file_};
  }

 private:
  // The number of threads is fixed and versions and times are not written, so equal pictures produce equal files. The
  // stream states its color space, because players otherwise guess it from the size: BT.709's matrix and primaries, and
  // sRGB's transfer function, which images for viewing have.
  std::vector<std::string> arguments() const {
    return {"ffmpeg",
            "-nostdin",
            "-loglevel",
            "error",
            "-y",
            "-f",
            "image2pipe",
            "-framerate",
            fmt::format("{}", rate_),
            "-c:v",
            "png",
            "-i",
            "pipe:0",
            "-vf",
            "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv",
            "-c:v",
            "libx264",
            "-pix_fmt",
            "yuv420p",
            "-colorspace",
            "bt709",
            "-color_primaries",
            "bt709",
            "-color_trc",
            "iec61966-2-1",
            "-color_range",
            "tv",
            "-threads",
            "4",
            "-fflags",
            "+bitexact",
            "-flags:v",
            "+bitexact",
            "-map_metadata",
            "-1",
            "-f",
            "mp4",
            "/proc/self/fd/1"};
  }

  std::string file_;
  PictureFile picture_;
  double rate_;
};

}  // namespace

std::unique_ptr<Format> makeVideo(const Json& options) {
  return std::make_unique<Video>(options);
}

}  // namespace latelight::data
