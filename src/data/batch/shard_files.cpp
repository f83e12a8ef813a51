#include "data/batch/shard_files.h"

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"

namespace latelight::data {

namespace {

bool hasContents(const std::filesystem::path& folder, const FileRecord& file) try {
  return recordOf(folder, file.name).hash == file.hash;
} catch (const Error&) {
  return false;
}

}  // namespace

void ShardFiles::add(const Manifest& log) {
  for (const auto& [index, frame] : log.frames)
    for (const FileRecord& file : frame.files) {
      const auto [known, isNew] = files_.try_emplace(file.name, Contents{file.hash});
      known->second.isDisputed |= known->second.hash != file.hash;
    }
  for (const std::string& name : log.stale) files_[name].isDisputed = true;
}

std::vector<FinishedFrame> ShardFiles::takeReplaced(std::map<uint64_t, FinishedFrame>& frames) const {
  std::vector<const FinishedFrame*> disputed;
  for (const auto& [index, frame] : frames)
    if (std::ranges::any_of(frame.files, [&](const FileRecord& file) { return dispute(file); }))
      disputed.push_back(&frame);
  std::vector<char> replaced(disputed.size());
  parallelFor(disputed.size(), 16, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) replaced[i] = isReplaced(*disputed[i]);
  });
  std::vector<FinishedFrame> taken;
  for (size_t i = 0; i < disputed.size(); ++i)
    if (replaced[i]) taken.push_back(std::move(frames.extract(disputed[i]->index).mapped()));
  return taken;
}

bool ShardFiles::dispute(const FileRecord& file) const {
  const auto known = files_.find(file.name);
  return known != files_.end() && (known->second.isDisputed || known->second.hash != file.hash);
}

bool ShardFiles::isReplaced(const FinishedFrame& frame) const {
  return std::ranges::any_of(frame.files,
                             [&](const FileRecord& file) { return dispute(file) && !hasContents(folder_, file); });
}

}  // namespace latelight::data
