// The format "webdataset": tar archives of samples, whose files share a name up to the first period (Aizman, Maltby and
// Breuel 2019, "High Performance I/O For Large Scale Deep Learning"). Each archive has the frames of a range of
// indices, so that the archives are the same for any number of shards. Frames wait in files of their own until the set
// is complete.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "base/error.h"
#include "base/files.h"
#include "base/temporary_file.h"
#include "base/write.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/options.h"
#include "data/formats/tar.h"
#include "output/exr.h"
#include "output/npy.h"

namespace latelight::data {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using output::Aov;

constexpr uint32_t kDefaultFrames = 1000;  // per archive
constexpr size_t kBuffer = 1 << 20;

class OpenFile {
 public:
  explicit OpenFile(const fs::path& path) : path_(path), fd_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (fd_ < 0) failed(errno);
  }
  ~OpenFile() { close(fd_); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  // Copies a range to another file. Returns 0 or the errno of a failed write.
  int copy(TarRange range, int target) const {
    std::vector<std::byte> buffer(std::min<uint64_t>(kBuffer, range.bytes));
    while (range.bytes > 0) {
      const ssize_t bytes =
          pread(fd_, buffer.data(), std::min<uint64_t>(buffer.size(), range.bytes), static_cast<off_t>(range.offset));
      if (bytes < 0 && errno == EINTR) continue;
      if (bytes <= 0) failed(bytes < 0 ? errno : EIO);
      if (const int error = writeAll(target, std::span(buffer).first(static_cast<size_t>(bytes)))) return error;
      range.offset += static_cast<uint64_t>(bytes);
      range.bytes -= static_cast<uint64_t>(bytes);
    }
    return 0;
  }

 private:
  [[noreturn]] void failed(int error) const {
    badInput("can't read '{}': {}", path_.string(), std::generic_category().message(error));
  }
  fs::path path_;
  int fd_;
};

// The source of a frame in a new archive: its own file, or a range of the archive that exists already.
struct Piece {
  fs::path file;
  TarRange range;
};

class WebDataset : public Format {
 public:
  explicit WebDataset(const Json& json) {
    FormatOptions options("webdataset", json);
    outputs_ = options.outputs("outputs", {Aov::Color, Aov::Depth, Aov::Id});
    isExr_ = options.choice("arrays", {"npy", "exr"}) == "exr";
    frames_ = static_cast<uint64_t>(options.number("frames", kDefaultFrames, 1, 1e9));
    folder_ = options.setFolder("folder", "shards");
    options.finish();
  }

  std::vector<Aov> needs() const override {
    std::vector<Aov> aovs = outputs_;
    std::erase(aovs, Aov::Color);
    return aovs;
  }
  bool needsDisplay() const override { return output::contains(outputs_, Aov::Color); }
  std::vector<FormatFile> files(const DataFrame& frame) const override {
    return {{fileOf(frame.index)}, {.name = archiveOf(frame.index), .ofSet = true}};
  }

  void writeFiles(const DataFrame& frame, const fs::path& folder, FrameRecord& record) const override {
    const output::Metadata metadata = metadataOf(frame);
    const std::string key = storedName(frame.name);
    std::vector<std::byte> piece;
    std::vector<std::string> files;
    const auto add = [&](const std::string& ending, std::span<const std::byte> contents) {
      files.push_back(key + "." + ending);
      addTarMember(piece, files.back(), contents);
    };
    for (const Aov aov : outputs_) {
      const std::string name(output::info(aov).name);
      if (aov == Aov::Color) {
        add("rgb.png", frame.picture.displayPng());
      } else if (isExr_) {
        const output::AovImage* const image = &imageOf(frame.picture, aov);
        add(name + ".exr", output::encodeExr({&image, 1}, metadata));
      } else {
        add(name + ".npy", output::encodeNpy(imageOf(frame.picture, aov)));
      }
    }
    const std::string side = output::sideFile(metadata, frame.picture.width, frame.picture.height, outputs_, files);
    add("json", std::as_bytes(std::span(side)));
    const std::string file = fileOf(frame.index);
    writeOf(record, folder, file, piece);
    record.entry = {{"key", key}, {"file", file}, {"archive", archiveOf(frame.index)}};
  }

  std::vector<std::string> writeSet(const SetEntries& set, const fs::path& folder) const override {
    const std::span<const Json> entries = set.frames;
    std::vector<std::string> written;
    for (size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
      const std::string archive = entries[begin]["archive"];
      while (end < entries.size() && entries[end]["archive"] == archive) ++end;
      writeArchive(folder, archive, entries.subspan(begin, end - begin));
      written.push_back(archive);
    }
    return written;
  }

  std::optional<PackedFile> packed(const Json& entry) const override {
    return PackedFile{entry["file"], entry["archive"]};
  }

  // Readers cut a sample's key at the first period of a name.
  std::string storedName(const std::string& frame) const override {
    std::string key = frame;
    std::ranges::replace(key, '.', '_');
    return key;
  }

 private:
  std::string fileOf(uint64_t index) const { return fmt::format("{}/.frames/{:09}.tar", folder_, index); }
  std::string archiveOf(uint64_t index) const { return fmt::format("{}/{:06}.tar", folder_, index / frames_); }

  // Frames that an earlier run has packed come from the archive of that run.
  void writeArchive(const fs::path& folder, const std::string& name, std::span<const Json> entries) const {
    const fs::path path = folder / name;
    std::map<std::string, TarRange> packed;
    std::error_code error;
    std::vector<Piece> pieces;
    for (const Json& entry : entries) {
      const fs::path own = folder / entry["file"].get<std::string>();
      if (const uint64_t bytes = fs::file_size(own, error); !error) {
        pieces.push_back({own, {0, bytes}});
        continue;
      }
      if (!isThere(path)) badInput("'{}' is missing: run the job with --resume", own.string());
      if (packed.empty()) packed = rangesOfTarKeys(path);
      const auto range = packed.find(entry["key"].get<std::string>());
      if (range == packed.end())
        badInput("'{}' lacks the frame \"{}\": remove it, and run the job with --resume", path.string(),
                 entry["key"].get<std::string>());
      pieces.push_back({path, range->second});
    }
    if (isWhole(path, pieces)) return;
    fs::create_directories(path.parent_path(), error);  // errors are reported when the file is opened
    write(path, pieces);
  }

  // Returns true if the archive consists of exactly these pieces.
  static bool isWhole(const fs::path& path, const std::vector<Piece>& pieces) {
    uint64_t end = 0;
    for (const Piece& piece : pieces) {
      if (piece.file != path || piece.range.offset != end) return false;
      end += piece.range.bytes;
    }
    std::error_code error;
    return fs::file_size(path, error) == end + kTarEndBytes && !error;
  }

  static void write(const fs::path& path, const std::vector<Piece>& pieces) {
    TemporaryFile file(path, 0666);
    const auto check = [&](int error) {
      if (error != 0) failToWrite(path, error);
    };
    check(file.error());
    for (const Piece& piece : pieces) check(OpenFile(piece.file).copy(piece.range, file.get()));
    const std::vector<std::byte> end(kTarEndBytes);
    check(writeAll(file.get(), end));
    check(file.become(path));
  }

  std::vector<Aov> outputs_;
  bool isExr_ = false;
  uint64_t frames_ = kDefaultFrames;
  std::string folder_;
};

}  // namespace

std::unique_ptr<Format> makeWebDataset(const Json& options) {
  return std::make_unique<WebDataset>(options);
}

}  // namespace latelight::data
