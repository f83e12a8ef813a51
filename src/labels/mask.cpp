#include "labels/mask.h"

#include <algorithm>
#include <span>

namespace latelight::labels {

namespace {

// Calls each(begin, end) for the runs inside the mask, with pixel numbers in column order.
template <typename F>
void forEachRun(const Mask& mask, F&& each) {
  uint64_t at = 0;
  for (size_t i = 0; i < mask.runs.size(); ++i) {
    const uint64_t end = at + mask.runs[i];
    if (i % 2 == 1 && end > at) each(at, end);
    at = end;
  }
}

// Builds the masks of all ids in one traversal of the picture in column order. Columns are copied from it several at a
// time, as many as fit into a cache line, because every line of the picture would be read once per column otherwise.
class MaskBuilder {
 public:
  explicit MaskBuilder(const output::AovImage& ids) : ids_(ids) {}

  std::map<uint32_t, Mask> build() {
    std::vector<uint32_t> columns(size_t{kColumns} * ids_.height);
    for (uint32_t x = 0; x < ids_.width; x += kColumns) {
      const uint32_t count = std::min(kColumns, ids_.width - x);
      const uint32_t* row = &ids_.ids[x];
      for (size_t y = 0; y < ids_.height; ++y, row += ids_.width)
        for (size_t i = 0; i < count; ++i) columns[i * ids_.height + y] = row[i];
      add({columns.data(), size_t{count} * ids_.height});
    }
    append(current_, begin_, at_);
    std::map<uint32_t, Mask> finished;
    for (auto& [id, growing] : masks_) {
      if (growing.end < at_) growing.mask.runs.push_back(static_cast<uint32_t>(at_ - growing.end));
      finished.emplace(id, std::move(growing.mask));
    }
    return finished;
  }

 private:
  static constexpr uint32_t kColumns = 16;

  struct Growing {
    Mask mask;
    uint64_t end = 0;  // end of its last run, as a pixel number
  };

  // Adds the pixels that follow.
  void add(std::span<const uint32_t> ids) {
    for (auto id = ids.begin(); id != ids.end();) {
      const auto end = std::find_if(id, ids.end(), [current = current_](uint32_t other) { return other != current; });
      at_ += end - id;
      id = end;
      if (id == ids.end()) return;
      append(current_, begin_, at_);
      current_ = *id;
      begin_ = at_;
    }
  }

  void append(uint32_t id, uint64_t begin, uint64_t end) {
    if (id == 0 || begin == end) return;
    Growing& growing = masks_[id];
    growing.mask.width = ids_.width;
    growing.mask.height = ids_.height;
    growing.mask.runs.push_back(static_cast<uint32_t>(begin - growing.end));
    growing.mask.runs.push_back(static_cast<uint32_t>(end - begin));
    growing.end = end;
  }

  const output::AovImage& ids_;
  std::map<uint32_t, Growing> masks_;
  uint32_t current_ = 0;         // id of the run
  uint64_t begin_ = 0, at_ = 0;  // of the run, and the next pixel
};

}  // namespace

uint64_t Mask::area() const {
  uint64_t area = 0;
  for (size_t i = 1; i < runs.size(); i += 2) area += runs[i];
  return area;
}

PixelBox Mask::box() const {
  uint64_t left = width, right = 0, top = height, bottom = 0;
  forEachRun(*this, [&](uint64_t begin, uint64_t end) {
    const uint64_t last = end - 1;
    left = std::min(left, begin / height);
    right = std::max(right, last / height);
    const bool oneColumn = begin / height == last / height;
    top = std::min(top, oneColumn ? begin % height : 0);
    bottom = std::max(bottom, oneColumn ? last % height : height - 1);
  });
  if (left > right || top > bottom) return {};
  return {static_cast<int64_t>(left), static_cast<int64_t>(top), static_cast<int64_t>(right - left + 1),
          static_cast<int64_t>(bottom - top + 1)};
}

std::vector<uint8_t> Mask::pixels() const {
  std::vector<uint8_t> pixels(size_t{width} * height, 0);
  forEachRun(*this, [&](uint64_t begin, uint64_t end) {
    for (uint64_t i = begin; i < end; ++i) pixels[i % height * width + i / height] = 255;
  });
  return pixels;
}

// The compressed run-length encoding of COCO. From the fourth run on, each length is stored as the difference to the
// length two runs before it. A number is split into groups of five bits, lowest first; a sixth bit marks that more
// groups follow. Each group becomes one printable character.
std::string Mask::counts() const {
  std::string text;
  for (size_t i = 0; i < runs.size(); ++i) {
    int64_t value = int64_t{runs[i]} - (i > 2 ? int64_t{runs[i - 2]} : 0);
    for (bool more = true; more;) {
      const int64_t bits = value & 31;
      value >>= 5;  // keeps the sign
      more = value != ((bits & 16) != 0 ? -1 : 0);
      text += static_cast<char>(48 + bits + (more ? 32 : 0));
    }
  }
  return text;
}

std::map<uint32_t, Mask> masksOf(const output::AovImage& ids) {
  return MaskBuilder(ids).build();
}

}  // namespace latelight::labels
