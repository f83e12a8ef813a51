#include "scene/mesh_files/ply_rows.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "base/error.h"
#include "base/log.h"
#include "base/parallel.h"
#include "scene/mesh_files/text.h"

namespace latelight::scene::mesh_files {
namespace {

constexpr size_t kRowsPerTask = 16384;

template <typename T>
T fromBytes(const char* at, bool bigEndian) {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), at, sizeof(T));
  if (bigEndian != (std::endian::native == std::endian::big)) std::ranges::reverse(bytes);
  return std::bit_cast<T>(bytes);
}

double fromBytes(PlyType type, const char* at, bool bigEndian) {
  switch (type) {
    case PlyType::Int8:
      return fromBytes<int8_t>(at, bigEndian);
    case PlyType::Uint8:
      return fromBytes<uint8_t>(at, bigEndian);
    case PlyType::Int16:
      return fromBytes<int16_t>(at, bigEndian);
    case PlyType::Uint16:
      return fromBytes<uint16_t>(at, bigEndian);
    case PlyType::Int32:
      return fromBytes<int32_t>(at, bigEndian);
    case PlyType::Uint32:
      return fromBytes<uint32_t>(at, bigEndian);
    case PlyType::Float:
      return fromBytes<float>(at, bigEndian);
    case PlyType::Double:
      return fromBytes<double>(at, bigEndian);
    case PlyType::None:
      break;
  }
  return 0;
}

}  // namespace

void PlyRows::endsEarly() const {
  badInput("the file ends in row {} of the {} rows of its element \"{}\": copy it again", row_, element_->count,
           printable(element_->name));
}

void PlyRows::begin(const PlyElement& element) {
  element_ = &element;
  row_ = 0;
  values_.assign(element.properties.size(), 0);
  lists_.assign(element.properties.size(), {});
  uint64_t bytes = 0;  // the minimum per row
  for (const PlyProperty& p : element.properties)
    bytes += encoding_ == PlyEncoding::Ascii ? 2 : sizeOf(p.isList() ? p.countType : p.type);
  if (element.count > 0 && bytes == 0)
    badInput("its element \"{}\" has {} rows but no properties", printable(element.name), element.count);
  if (element.count > 0 && element.count > (file_.size() - at_ + 1) / bytes)
    badInput("its element \"{}\" should have {} rows, but only {} bytes follow: copy it again", printable(element.name),
             element.count, file_.size() - at_);
}

double PlyRows::readText(PlyType type) {
  while (at_ < file_.size() && (isBlank(file_[at_]) || file_[at_] == '\n')) ++at_;
  if (at_ == file_.size()) endsEarly();
  const char *begin = file_.data() + at_, *end = file_.data() + file_.size();
  const auto endsNumber = [&](const char* at) { return at == end || isBlank(*at) || *at == '\n'; };
  if (isInteger(type)) {
    int64_t integer = 0;
    const auto result = std::from_chars(begin, end, integer);
    if (result.ec == std::errc() && endsNumber(result.ptr)) {
      at_ = static_cast<size_t>(result.ptr - file_.data());
      return static_cast<double>(integer);
    }
  }
  float value = 0;
  double exact = 0;
  const char* after = nullptr;
  if (isInteger(type) || type == PlyType::Double) {  // floats cannot hold all integers
    const auto result = std::from_chars(begin + (*begin == '+'), end, exact);
    after = result.ec == std::errc() ? result.ptr : nullptr;
  }
  if (!after) after = parseFloat(begin, end, value), exact = value;
  if (!after || !endsNumber(after))
    badInput("line {} has \"{}\" instead of a number, in row {} of its element \"{}\"", lineAt(file_, at_),
             printable(Words(file_.substr(at_, 40)).word()), row_, printable(element_->name));
  at_ = static_cast<size_t>(after - file_.data());
  return exact;
}

double PlyRows::read(PlyType type) {
  if (encoding_ == PlyEncoding::Ascii) return readText(type);
  const size_t size = sizeOf(type);
  if (file_.size() - at_ < size) endsEarly();
  const double value = fromBytes(type, file_.data() + at_, encoding_ == PlyEncoding::BigEndian);
  at_ += size;
  return value;
}

void PlyRows::readList(const PlyProperty& property, std::vector<double>& list) {
  const double count = read(property.countType);
  const size_t size = encoding_ == PlyEncoding::Ascii ? 2 : sizeOf(property.type);
  if (count < 0 || count != std::floor(count))
    badInput("a list of {} entries is in row {} of its element \"{}\"", count, row_, printable(element_->name));
  if (count > double((file_.size() - at_ + 1) / size)) endsEarly();
  list.resize(static_cast<size_t>(count));
  for (double& value : list) value = read(property.type);
}

void PlyRows::next() {
  ++row_;
  for (size_t i = 0; i < element_->properties.size(); ++i) {
    const PlyProperty& property = element_->properties[i];
    if (property.isList())
      readList(property, lists_[i]);
    else
      values_[i] = read(property.type);
  }
}

size_t PlyRows::rowBytes(uint32_t entries) const {
  if (encoding_ == PlyEncoding::Ascii) return 0;
  size_t bytes = 0;
  for (const PlyProperty& p : element_->properties)
    bytes += p.isList() ? sizeOf(p.countType) + entries * sizeOf(p.type) : sizeOf(p.type);
  return bytes;
}

// Returns the position of every kRowsPerTask-th line, and of the end of the element's last line. Returns nothing if
// there are fewer lines than rows.
std::vector<size_t> PlyRows::taskStarts() const {
  constexpr size_t kBlock = size_t{1} << 20;
  const std::string_view text = file_.substr(at_);
  const size_t blocks = (text.size() + kBlock - 1) / kBlock;
  std::vector<uint64_t> lines(blocks + 1);  // before each block
  parallelFor(blocks, 1, [&](size_t begin, size_t end) {
    for (size_t block = begin; block < end; ++block)
      lines[block + 1] = static_cast<uint64_t>(std::ranges::count(text.substr(block * kBlock, kBlock), '\n'));
  });
  for (size_t block = 0; block < blocks; ++block) lines[block + 1] += lines[block];
  const uint64_t rows = element_->count;
  if (lines[blocks] + (text.ends_with('\n') ? 0 : 1) < rows) return {};
  std::vector<size_t> starts((rows + kRowsPerTask - 1) / kRowsPerTask + 1, file_.size());
  starts[0] = at_;
  parallelFor(blocks, 1, [&](size_t begin, size_t end) {
    for (size_t block = begin; block < end; ++block) {
      const size_t last = std::min((block + 1) * kBlock, text.size());
      size_t at = block * kBlock;
      for (uint64_t line = lines[block] + 1; line <= std::min(lines[block + 1], rows); ++line) {
        at = text.substr(0, last).find('\n', at) + 1;
        if (line == rows)
          starts.back() = at_ + at;
        else if (line % kRowsPerTask == 0)
          starts[line / kRowsPerTask] = at_ + at;
      }
    }
  });
  return starts;
}

bool PlyRows::forEachLine(const std::function<bool(const PlyRows& rows, uint64_t i)>& body) {
  const bool isAtLine = at_ == 0 || file_[at_ - 1] == '\n';
  if (encoding_ != PlyEncoding::Ascii || element_->count < kRowsPerTask || !isAtLine) return false;
  const std::vector<size_t> starts = taskStarts();
  std::atomic<bool> areLines = !starts.empty();
  if (!areLines) return false;
  const auto readTask = [&](size_t task) {
    PlyRows rows = *this;
    rows.at_ = starts[task];
    for (uint64_t i = task * kRowsPerTask; i < std::min<uint64_t>((task + 1) * kRowsPerTask, element_->count); ++i) {
      rows.next();
      while (rows.at_ < file_.size() && isBlank(file_[rows.at_])) ++rows.at_;
      if (rows.at_ < file_.size() && file_[rows.at_++] != '\n') return false;  // more than one row in a line
      if (!body(rows, i)) return false;
    }
    return rows.at_ == starts[task + 1];  // no row is longer than a line
  };
  parallelFor(starts.size() - 1, 1, [&](size_t begin, size_t end) {
    for (size_t task = begin; task < end && areLines; ++task) {
      try {
        if (!readTask(task)) areLines = false;
      } catch (const Error&) {
        areLines = false;  // reading row by row reports it
      }
    }
  });
  if (!areLines) return false;
  at_ = starts.back();
  row_ = element_->count;
  return true;
}

void PlyRows::forEach(const std::function<void(const PlyRows& rows, uint64_t i)>& body) {
  if (forEachLine([&](const PlyRows& rows, uint64_t i) { return body(rows, i), true; })) return;
  const bool hasLists = std::ranges::any_of(element_->properties, &PlyProperty::isList);
  const size_t stride = hasLists ? 0 : rowBytes(0);
  if (stride == 0 || (file_.size() - at_) / stride < element_->count) {
    for (uint64_t i = 0; i < element_->count; ++i) next(), body(*this, i);
    return;
  }
  parallelFor(element_->count, kRowsPerTask, [&](size_t begin, size_t end) {
    PlyRows rows = *this;
    rows.at_ += begin * stride;
    for (uint64_t i = begin; i < end; ++i) rows.next(), body(rows, i);
  });
  at_ += element_->count * stride;
  row_ = element_->count;
}

// Reads `corners`, three per row. `offset`: from a row's first byte to the first entry of its list.
template <typename T>
bool PlyRows::readCorners(size_t offset, size_t stride, uint64_t limit, std::vector<uint32_t>& corners) const {
  const bool bigEndian = encoding_ == PlyEncoding::BigEndian;
  std::atomic<bool> areValid = true;
  parallelFor(element_->count, kRowsPerTask, [&](size_t begin, size_t end) {
    bool valid = true;
    for (size_t row = begin; row < end; ++row) {
      const char* entries = file_.data() + at_ + row * stride + offset;
      for (size_t i = 0; i < 3; ++i) {
        const T entry = fromBytes<T>(entries + i * sizeof(T), bigEndian);
        valid = valid && entry >= 0 && static_cast<uint64_t>(entry) < limit;
        corners[3 * row + i] = static_cast<uint32_t>(entry);
      }
    }
    if (!valid) areValid = false;
  });
  return areValid;
}

std::optional<std::vector<uint32_t>> PlyRows::readTriangles(int list, uint64_t limit) {
  const std::vector<PlyProperty>& properties = element_->properties;
  const PlyProperty& property = properties[static_cast<size_t>(list)];
  if (encoding_ == PlyEncoding::Ascii) {
    constexpr size_t kMinRowBytes = 8;  // "3 0 1 2" and the end of the line
    const bool fits = (file_.size() - at_ + 1) / kMinRowBytes >= element_->count;
    if (element_->count < kRowsPerTask || !fits) return std::nullopt;
    std::vector<uint32_t> corners(3 * element_->count);
    const auto store = [&](const PlyRows& rows, uint64_t row) {
      const std::vector<double>& face = rows.list(list);
      if (face.size() != 3) return false;
      for (size_t i = 0; i < 3; ++i) {
        if (!(face[i] >= 0 && face[i] < double(limit)) || face[i] != std::floor(face[i])) return false;
        corners[3 * row + i] = static_cast<uint32_t>(face[i]);
      }
      return true;
    };
    return forEachLine(store) ? std::optional(std::move(corners)) : std::nullopt;
  }
  const size_t stride = rowBytes(3);
  if (stride == 0 || std::ranges::count_if(properties, &PlyProperty::isList) != 1) return std::nullopt;
  if (property.type != PlyType::Int32 && property.type != PlyType::Uint32) return std::nullopt;
  if ((file_.size() - at_) / stride < element_->count) return std::nullopt;
  size_t offset = 0;
  for (int i = 0; i < list; ++i) offset += sizeOf(properties[static_cast<size_t>(i)].type);
  const bool bigEndian = encoding_ == PlyEncoding::BigEndian;
  std::atomic<bool> areTriangles = true;  // if each row begins where it would after triangles, and has three entries
  parallelFor(element_->count, kRowsPerTask, [&](size_t begin, size_t end) {
    for (size_t row = begin; row < end && areTriangles; ++row)
      if (fromBytes(property.countType, file_.data() + at_ + row * stride + offset, bigEndian) != 3)
        areTriangles = false;
  });
  if (!areTriangles) return std::nullopt;
  std::vector<uint32_t> corners(3 * element_->count);
  offset += sizeOf(property.countType);
  const bool areValid = property.type == PlyType::Int32 ? readCorners<int32_t>(offset, stride, limit, corners)
                                                        : readCorners<uint32_t>(offset, stride, limit, corners);
  if (!areValid) return std::nullopt;
  at_ += element_->count * stride;
  row_ = element_->count;
  return corners;
}

}  // namespace latelight::scene::mesh_files
