#include "data/batch/set.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <functional>
#include <system_error>
#include <unordered_map>

#include "base/error.h"
#include "base/files.h"
#include "base/parallel.h"
#include "data/batch/shard_files.h"
#include "data/batch/shard_log.h"
#include "data/json_text.h"

namespace latelight::data {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

Json readState(const fs::path& path) {
  const std::vector<std::byte> bytes = readFile(path);
  try {
    return parsed(bytes);
  } catch (const Json::exception&) {
    badInput("'{}' is damaged; run the job again with --resume", path.string());
  }
}

void requireSet(const SetFolder& set) {
  if (!isThere(set.plan())) badInput("'{}' holds no data set", set.path().string());
}

using PathAndManifest = std::pair<fs::path, Manifest>;

// Returns the manifest and all shard logs of the set, each with its path.
std::vector<PathAndManifest> manifestsOf(const SetFolder& set) {
  std::vector<PathAndManifest> all;
  if (isThere(set.manifest())) all.emplace_back(set.manifest(), readManifest(set.manifest()));
  for (const fs::path& shard : set.shards()) all.emplace_back(shard, readShardLog(shard));
  return all;
}

// Returns the files of the logs among these manifests. The manifest of the whole set is older than all logs. A log that
// is the only manifest does not dispute its own frames.
ShardFiles shardFilesOf(const SetFolder& set, const std::vector<PathAndManifest>& all) {
  ShardFiles files(set.path());
  for (const auto& [path, manifest] : all)
    if (all.size() > 1 && path != set.manifest()) files.add(manifest);
  return files;
}

// Returns true if the set is not merged and all existing shard logs are of other shards of this job.
bool isOfOthers(const SetFolder& set, const Job& job, const Shard& shard) {
  const std::string count = fmt::format("-of-{}.jsonl", shard.count);
  const auto isOther = [&](const fs::path& path) {
    return path != set.shard(shard) && path.filename().string().ends_with(count);
  };
  return !isThere(set.manifest()) && std::ranges::all_of(set.shards(), isOther) &&
         (set.shards().empty() || readState(set.job()) == job.document);
}

bool isRecorded(const SetFolder& set, const FileRecord& file) {
  std::error_code error;
  return fs::file_size(set.path() / file.name, error) == file.bytes && !error;
}

bool isFinished(const SetFolder& set, const Plan& plan, const FinishedFrame& frame) {
  return frame.index < plan.frames() && plan.at(frame.index) && frame.settings == plan.settings(frame.index) &&
         std::ranges::all_of(frame.files, [&](const FileRecord& file) { return isRecorded(set, file); }) &&
         std::ranges::all_of(frame.archives, [&](const FileRecord& file) { return isRecorded(set, file); });
}

void addFiles(const FinishedFrame& frame, std::set<std::string>& names) {
  for (const FileRecord& file : frame.files) names.insert(file.name);
}

// Adds to the stale files those of other shards' frames, rendered by other plans, that this shard's missing frames
// will replace: a plan with other scenes or cameras may give a file to a frame of another shard.
void addReplaced(const Job& job, const Plan& plan, const Shard& shard, const std::set<std::string>& filesOfOthers,
                 Manifest& found) {
  if (filesOfOthers.empty()) return;
  const auto [first, end] = shard.range(plan.frames());
  for (uint64_t index = first; index < end; ++index) {
    if (!plan.at(index) || found.frames.contains(index)) continue;
    const DataFrame frame = plan.frame(index);
    for (const JobFormat& use : job.formats)
      for (const FormatFile& file : use.format->files(frame)) {
        const bool isFolder = file.name.ends_with('/');
        for (auto other = filesOfOthers.lower_bound(file.name); other != filesOfOthers.end(); ++other) {
          if (isFolder ? !other->starts_with(file.name) : *other != file.name) break;
          found.stale.insert(*other);
        }
      }
  }
}

// Returns one sentence per symbolic link below the set's folder that does not lead to anything in it. A process that
// followed such a link would replace or remove files that are not of the set. The folder itself may be a link.
std::vector<std::string> wrongLinks(const SetFolder& set) {
  constexpr auto kSkip = fs::directory_options::skip_permission_denied;
  std::vector<std::string> sentences;
  std::error_code error;
  const fs::path folder = fs::canonical(set.path(), error);
  if (error) return {};
  for (fs::recursive_directory_iterator entry(folder, kSkip, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code unresolved;  // the link is dangling or circular
    if (!entry->is_symlink(unresolved)) continue;
    const fs::path target = fs::canonical(entry->path(), unresolved);
    if (!unresolved && *target.lexically_relative(folder).begin() != "..") continue;
    sentences.push_back(
        fmt::format("'{}' is a link that does not lead to a file of the data set: remove it, and run the job with "
                    "--resume",
                    (set.path() / entry->path().lexically_relative(folder)).string()));
  }
  std::ranges::sort(sentences);
  return sentences;
}

void requireOwnFiles(const SetFolder& set) {
  const std::vector<std::string> wrong = wrongLinks(set);
  if (!wrong.empty()) badUsage("{}", wrong.front());
}

// Throws if the set's folders cannot be created, or written if they exist.
void requireWritable(const SetFolder& set) {
  std::error_code error;
  const bool isNew = !fs::exists(fs::status(set.state(), error));
  if (!error || error == std::errc::no_such_file_or_directory) {
    fs::path folder = fs::absolute(set.state(), error);
    while (folder.has_relative_path() && !isThere(folder)) folder = folder.parent_path();
    if (access(folder.c_str(), W_OK | X_OK) == 0) return;
    error.assign(errno, std::generic_category());
  }
  badUsage("can't {} the folder '{}': {}; make it writable, or choose another", isNew ? "create" : "write to",
           set.state().string(), error.message());
}

// Creates the formats of a stored job document. They do not depend on the output folder, which it lacks.
std::vector<JobFormat> formatsOf(const Json& job) {
  std::vector<JobFormat> all;
  for (const Json& spec : job.value("formats", Json::array({"files"}))) all.push_back(makeFormat(spec, "formats"));
  return all;
}

// Moves the records of a frame's packed file to the archive that holds it. Returns the file's name. `setFiles`: the
// files that the format has written for the set, by name.
std::optional<std::string> moveToArchive(const Format& format, const Json& entry,
                                         const std::unordered_map<std::string, FileRecord>& setFiles,
                                         FinishedFrame& frame) {
  const std::optional<PackedFile> packed = format.packed(entry);
  if (!packed) return std::nullopt;
  std::erase_if(frame.files, [&](const FileRecord& file) { return file.name == packed->file; });
  frame.archives.push_back(setFiles.at(packed->archive));
  return packed->file;
}

// Throws if the plan, and with it the frames, are of another job than the stored one: a process may be killed after it
// has stored its job and before it has stored its plan. Plans of version 0.2.0 do not name their job.
void checkJob(const SetFolder& set, const Manifest& manifest, const Json& job, const Json& plan, size_t formats) {
  const auto hasFormats = [&](const auto& frame) { return frame.second.entries.size() == formats; };
  const uint64_t hash = hashOfJob(job);
  if (plan.value("document", hash) != hash || !std::ranges::all_of(manifest.frames, hasFormats))
    badInput("'{}' has frames of another job than '{}': run the job again with --resume", set.path().string(),
             set.job().string());
}

// Throws if an archive of the set, from which writeSet() may copy frames, was changed after it was written: its new
// hash would hide the damage.
void checkArchives(const SetFolder& set, const Manifest& manifest) {
  std::set<std::pair<std::string, uint64_t>> checked;
  for (const auto& [index, frame] : manifest.frames)
    for (const FileRecord& archive : frame.archives) {
      if (!checked.emplace(archive.name, archive.hash).second || !isThere(set.path() / archive.name)) continue;
      if (recordOf(set.path(), archive.name).hash != archive.hash)
        badInput("'{}' is not as it was written: remove it, and run the job with --resume",
                 (set.path() / archive.name).string());
    }
}

// Returns the entries of the scenes of a stored plan for one of the job's formats.
std::vector<Json> sceneEntriesOf(const Json& plan, size_t format) {
  const auto scenes = plan.find("scenes");
  if (scenes == plan.end()) return {};
  std::vector<Json> all;
  for (const Json& scene : *scenes)
    if (const auto entries = scene.find("entries"); entries != scene.end() && format < entries->size())
      all.push_back((*entries)[format]);
  return all;
}

// Removes files, and the folders below the set's own that become empty.
template <typename Names>
void removeFiles(const SetFolder& set, const Names& names) {
  std::set<fs::path, std::greater<>> folders;  // in descending order, a folder follows those in it
  std::error_code ignored;
  for (const std::string& name : names) {
    fs::remove(set.path() / name, ignored);
    for (fs::path folder = fs::path(name).parent_path(); !folder.empty(); folder = folder.parent_path())
      folders.insert(folder);
  }
  for (const fs::path& folder : folders)
    if (fs::is_empty(set.path() / folder, ignored)) fs::remove(set.path() / folder, ignored);
}

// Removes the packed files of frames that are in archives. A run of another job that was interrupted has written them,
// and formats prefer them to the archives.
void removeReplacedPackedFiles(const SetFolder& set, const Manifest& manifest, const std::vector<JobFormat>& formats) {
  std::vector<std::string> names;
  for (const auto& [index, frame] : manifest.frames)
    for (size_t i = 0; i < formats.size(); ++i) {
      const std::optional<PackedFile> packed = formats[i].format->packed(frame.entries[i]);
      const auto isPacked = [&](const FileRecord& file) { return file.name == packed->file; };
      if (packed && std::ranges::none_of(frame.files, isPacked)) names.push_back(packed->file);
    }
  removeFiles(set, names);
}

// Returns the names of the frames' files that are now in archives and no longer required.
std::vector<std::string> writeSetFiles(const SetFolder& set, Manifest& manifest) {
  checkArchives(set, manifest);
  manifest.setFiles.clear();
  const Json job = readState(set.job()), plan = readState(set.plan());
  const std::vector<JobFormat> formats = formatsOf(job);
  checkJob(set, manifest, job, plan, formats.size());
  removeReplacedPackedFiles(set, manifest, formats);
  for (auto& [index, frame] : manifest.frames) frame.archives.clear();
  std::vector<std::string> packedFiles;
  for (size_t i = 0; i < formats.size(); ++i) {
    std::vector<Json> entries;  // moved from the frames and back, because they may be large
    for (auto& [index, frame] : manifest.frames) entries.push_back(std::move(frame.entries.at(i)));
    const std::vector<Json> scenes = sceneEntriesOf(plan, i);
    std::unordered_map<std::string, FileRecord> setFiles;
    for (const std::string& name : formats[i].format->writeSet({entries, scenes}, set.path()))
      setFiles[name] = manifest.setFiles.emplace_back(recordOf(set.path(), name));
    auto entry = entries.begin();
    for (auto& [index, frame] : manifest.frames) {
      frame.entries[i] = std::move(*entry++);
      if (auto file = moveToArchive(*formats[i].format, frame.entries[i], setFiles, frame))
        packedFiles.push_back(*std::move(file));
    }
  }
  removeRepeated(manifest.setFiles);
  for (auto& [index, frame] : manifest.frames) removeRepeated(frame.archives);
  return packedFiles;
}

void removeStale(const SetFolder& set, const SetStatus& status) {
  std::set<std::string> stale = status.manifest.stale;
  stale.insert(status.otherFiles.begin(), status.otherFiles.end());
  for (const auto& [index, frame] : status.manifest.frames)
    for (const FileRecord& file : frame.files) stale.erase(file.name);
  for (const FileRecord& file : status.manifest.setFiles) stale.erase(file.name);
  removeFiles(set, stale);
}

void join(const SetFolder& set, SetStatus& status) {
  const std::vector<std::string> packedFiles = writeSetFiles(set, status.manifest);
  removeStale(set, status);
  status.manifest.stale.clear();
  // A log is newer than the manifest, so none of another job may outlast the manifest that replaces its frames.
  std::error_code ignored;
  for (const fs::path& log : status.otherLogs) fs::remove(log, ignored);
  writeManifest(set.manifest(), status.manifest);
  removeFiles(set, packedFiles);
  for (const fs::path& shard : set.shards()) fs::remove(shard, ignored);
}

}  // namespace

std::vector<fs::path> SetFolder::shards() const {
  std::vector<fs::path> all;
  std::error_code error;
  for (fs::directory_iterator entry(state(), error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with("shard-") && name.ends_with(".jsonl")) all.push_back(entry->path());
  }
  std::ranges::sort(all);
  return all;
}

void SetFolder::log(const std::string& line) const {
  char host[256] = "";
  gethostname(host, sizeof host - 1);
  const auto time =
      std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch());
  const std::string text = fmt::format("{} {} {}: {}\n", time.count(), host, getpid(), line);
  const int fd = open((state() / "log").c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (fd < 0) return;
  [[maybe_unused]] const ssize_t written = ::write(fd, text.data(), text.size());
  close(fd);
}

SetLock::SetLock(const fs::path& manifest, bool wait) {
  const fs::path path = fs::path(manifest).replace_extension(".lock");
  fd_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (fd_ < 0)
    badUsage("can't write to '{}': {}; make its folder writable, or choose another", path.string(),
             std::strerror(errno));
  // On file systems without locks, no lock is held.
  if (flock(fd_, wait ? LOCK_EX : LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  close(fd_);
  badUsage("another process is working on '{}'; wait for it, or end it", manifest.string());
}

SetLock::~SetLock() {
  close(fd_);
}

void checkSet(const SetFolder& set, const Job& job, const Shard& shard, bool resume) {
  const std::string name = set.path().string();
  if (name.find_first_of("{}") != std::string::npos) badUsage("the folder \"{}\" has a brace in its name", name);
  std::error_code error;
  // The order of these tests matters, because another shard may create the set between them.
  const bool isFile = fs::exists(set.path(), error) && !fs::is_directory(set.path(), error);
  const bool hasFiles = isFile || (fs::exists(set.path(), error) && !fs::is_empty(set.path(), error));
  const bool isSet = fs::exists(set.state(), error) || fs::exists(set.manifest(), error);
  if (hasFiles && !isSet) badUsage("'{}' is not an empty folder; choose another for the data set", name);
  if (isSet && !resume && !isOfOthers(set, job, shard))
    badUsage("'{}' already contains a data set: add --resume to complete it, or choose another folder", name);
  if (resume) requireOwnFiles(set);
  requireWritable(set);
}

bool openSet(const SetFolder& set, const Job& job, const Shard& shard, bool resume) {
  checkSet(set, job, shard, resume);
  std::error_code error;
  const bool isNew = fs::create_directories(set.state(), error);
  if (error) badUsage("can't create the folder '{}': {}", set.state().string(), error.message());
  return isNew;
}

// Other shards may have opened the set since. The folder itself is removed only if it is empty.
void removeNewSet(const SetFolder& set, const Shard& shard) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(set.state(), ignored))
    if (entry.path() != set.lock(shard) && entry.path() != set.partsLock()) return;
  fs::remove(set.lock(shard), ignored);
  fs::remove(set.partsLock(), ignored);
  if (fs::remove(set.state(), ignored)) fs::remove(set.path(), ignored);
}

void saveJob(const SetFolder& set, const Job& job, const Plan& plan) {
  const std::string text = dumped(job.document) + "\n";
  writeFile(set.job(), std::as_bytes(std::span(text)));
  plan.save(set.plan());
}

Manifest findFinished(const SetFolder& set, const Job& job, const Plan& plan, const Shard& shard) {
  Manifest found{.plan = plan.hash()};
  const auto [first, end] = shard.range(plan.frames());
  const bool isLast = shard.index + 1 == shard.count;
  std::vector<PathAndManifest> manifests = manifestsOf(set);
  const ShardFiles shardFiles = shardFilesOf(set, manifests);
  std::set<std::string> filesOfOthers;
  for (auto& [path, there] : manifests) {
    if (path == set.shard(shard)) found.stale.merge(there.stale);
    std::map<uint64_t, FinishedFrame> finished;
    for (auto& [index, frame] : there.frames) {
      const bool ours = index >= first && (index < end || (isLast && index >= plan.frames()));
      if (ours && isFinished(set, plan, frame))
        finished.emplace(index, std::move(frame));
      else if (ours)
        addFiles(frame, found.stale);
      else if (there.plan != found.plan)
        addFiles(frame, filesOfOthers);
    }
    for (const FinishedFrame& frame : shardFiles.takeReplaced(finished)) addFiles(frame, found.stale);
    for (auto& [index, frame] : finished) found.frames.insert_or_assign(index, std::move(frame));
  }
  addReplaced(job, plan, shard, filesOfOthers, found);
  for (const auto& [index, frame] : found.frames)
    for (const FileRecord& file : frame.files) found.stale.erase(file.name);
  return found;
}

SetStatus readStatus(const SetFolder& set) {
  requireSet(set);
  const Json plan = readState(set.plan());
  SetStatus status{.frames = plan.value("frames", uint64_t{0}), .manifest = {.plan = plan.value("hash", uint64_t{0})}};
  Manifest& all = status.manifest;
  std::vector<PathAndManifest> manifests = manifestsOf(set);
  const ShardFiles shardFiles = shardFilesOf(set, manifests);
  status.isMerged = manifests.size() == 1;
  for (auto& [path, there] : manifests) {
    const bool current = there.plan == all.plan;
    status.isMerged = status.isMerged && current && path == set.manifest();
    if (!current && path != set.manifest()) status.otherLogs.push_back(path);
    if (current) shardFiles.takeReplaced(there.frames);
    for (auto& [index, frame] : there.frames)
      if (current)
        all.frames.insert_or_assign(index, std::move(frame));
      else
        addFiles(frame, status.otherFiles);
    for (const FileRecord& file : there.setFiles)
      current ? all.setFiles.push_back(file) : void(status.otherFiles.insert(file.name));
    if (current) all.failed.merge(there.failed);
    all.stale.merge(there.stale);
  }
  for (const auto& [index, frame] : all.frames) all.failed.erase(frame.name);
  return status;
}

std::vector<std::string> verifySet(const SetFolder& set, const SetStatus& status) {
  std::vector<FileRecord> files = status.manifest.setFiles;
  std::set<std::string> archives;  // those that the set has, and those of frames of a set that is not yet complete
  for (const FileRecord& file : files) archives.insert(file.name);
  for (const auto& [index, frame] : status.manifest.frames) {
    files.insert(files.end(), frame.files.begin(), frame.files.end());
    for (const FileRecord& archive : frame.archives)
      if (archives.insert(archive.name).second) files.push_back(archive);
  }
  std::vector<std::string> wrong(files.size());
  parallelFor(files.size(), 16, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) try {
        const FileRecord now = recordOf(set.path(), files[i].name);
        if (now.hash != files[i].hash || now.bytes != files[i].bytes)
          wrong[i] = fmt::format("'{}' is not as it was written", files[i].name);
      } catch (const Error& error) {
        wrong[i] = error.what();
      }
  });
  std::erase(wrong, "");
  const std::vector<std::string> links = wrongLinks(set);
  wrong.insert(wrong.end(), links.begin(), links.end());
  return wrong;
}

void mergeSet(const SetFolder& set, bool allowMissing) {
  requireSet(set);
  requireOwnFiles(set);
  for (const fs::path& shard : set.shards()) const SetLock atWork(shard);
  const SetLock lock(set.state() / "merge", true);
  SetStatus status = readStatus(set);
  if (status.missing() > 0 && !allowMissing)
    fail(ExitCode::SomeFramesFailed,
         "{} of the {} frames are missing in '{}': run the job again with --resume, or merge with --allow-missing",
         status.missing(), status.frames, set.path().string());
  join(set, status);
}

void mergeIfComplete(const SetFolder& set) {
  const SetLock lock(set.state() / "merge", true);
  SetStatus status = readStatus(set);
  if (status.missing() == 0) join(set, status);
}

}  // namespace latelight::data
