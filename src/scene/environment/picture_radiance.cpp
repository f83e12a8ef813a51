// Decodes Radiance RGBE images (.hdr).
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>

#include "base/error.h"
#include "scene/environment/picture_io.h"

namespace latelight::scene {
namespace {

using Rgbe = std::array<uint8_t, 4>;

struct Header {
  uint32_t width = 0, height = 0;
  bool bottomUp = false, rightToLeft = false;
};

class Reader {
 public:
  Reader(std::span<const std::byte> bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  std::string_view line() {
    const char* begin = reinterpret_cast<const char*>(bytes_.data()) + next_;
    const void* end = std::memchr(begin, '\n', bytes_.size() - next_);
    if (!end) badInput("'{}' ends within its Radiance header; the file is damaged, download it again", name_);
    std::string_view text(begin, static_cast<const char*>(end) - begin);
    next_ += text.size() + 1;
    if (text.ends_with('\r')) text.remove_suffix(1);
    return text;
  }

  void startRow(uint32_t row) { row_ = row; }
  size_t left() const { return bytes_.size() - next_; }
  // Call only after need(), which ensures that the bytes exist.
  const uint8_t* here() const { return reinterpret_cast<const uint8_t*>(bytes_.data()) + next_; }
  void skip(size_t count) { next_ += count; }
  const uint8_t* take(size_t count) {
    if (left() < count) badInput("'{}' is truncated: its data end in row {}; download it again", name_, row_);
    const uint8_t* at = here();
    next_ += count;
    return at;
  }
  [[noreturn]] void damaged() const {
    badInput("'{}' is damaged: a run in row {} is longer than the row; download it again", name_, row_);
  }

 private:
  std::span<const std::byte> bytes_;
  const std::string& name_;
  size_t next_ = 0;
  uint32_t row_ = 0;
};

std::string_view word(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  const std::string_view found = text.substr(0, text.find(' '));
  text.remove_prefix(found.size());
  return found;
}

std::optional<uint32_t> extent(std::string_view text) {
  uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value == 0) return std::nullopt;
  return value;
}

// Parses "-Y 512 +X 1024": 512 rows from the top, each from the left.
Header parseResolution(std::string_view line, const std::string& name) {
  std::string_view rest = line;
  const std::string_view yAxis = word(rest), height = word(rest), xAxis = word(rest), width = word(rest);
  if (yAxis.ends_with('X') && xAxis.ends_with('Y')) {
    badInput("'{}' stores its image by columns ('{}'); save it by rows", name, line);
  }
  Header header;
  header.width = extent(width).value_or(0);
  header.height = extent(height).value_or(0);
  header.bottomUp = yAxis == "+Y";
  header.rightToLeft = xAxis == "-X";
  const bool axes = (yAxis == "-Y" || header.bottomUp) && (xAxis == "+X" || header.rightToLeft);
  if (!axes || header.width == 0 || header.height == 0) {
    badInput("'{}' has a Radiance header without a valid size ('{}'); the file is damaged, download it again", name,
             line.substr(0, 40));
  }
  checkPictureSize(header.width, header.height, name);
  return header;
}

Header readHeader(Reader& reader, const std::string& name) {
  reader.line();  // #?RADIANCE, #?RGBE
  for (;;) {
    const std::string_view line = reader.line();
    if (line.empty()) break;
    if (line.starts_with("FORMAT=") && line != "FORMAT=32-bit_rle_rgbe") {
      badInput("'{}' has the Radiance format '{}', which is not supported; save it as 32-bit_rle_rgbe", name,
               line.substr(7, 40));
    }
  }
  return parseResolution(reader.line(), name);
}

// New run-length encoding (Radiance 1991): each channel of the row separately; a count above 128 repeats one byte.
void readNewRow(Reader& reader, std::vector<Rgbe>& row) {
  reader.skip(4);
  for (size_t channel = 0; channel < 4; ++channel) {
    for (size_t x = 0; x < row.size();) {
      const uint8_t code = *reader.take(1);
      const size_t count = code > 128 ? code - 128 : code;
      if (count == 0 || count > row.size() - x) reader.damaged();
      const bool run = code > 128;
      const uint8_t* bytes = reader.take(run ? 1 : count);
      for (size_t i = 0; i < count; ++i) row[x++][channel] = bytes[run ? 0 : i];
    }
  }
}

// Flat pixels with old run-length encoding: a pixel 1 1 1 n repeats the previous one n times, and consecutive pixels of
// this form are the higher bytes of the count. No real pixel has this form, because one of its mantissas is at least
// 128.
void readOldRow(Reader& reader, std::vector<Rgbe>& row) {
  unsigned shift = 0;
  for (size_t x = 0; x < row.size();) {
    Rgbe pixel;
    std::memcpy(pixel.data(), reader.take(4), 4);
    if (pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1) {
      if (x == 0 || shift > 24) reader.damaged();
      const size_t count = size_t{pixel[3]} << shift;
      if (count > row.size() - x) reader.damaged();
      std::fill_n(row.begin() + static_cast<ptrdiff_t>(x), count, row[x - 1]);
      x += count;
      shift += 8;
    } else {
      row[x++] = pixel;
      shift = 0;
    }
  }
}

void readRow(Reader& reader, std::vector<Rgbe>& row) {
  const size_t width = row.size();
  if (width >= 8 && width < 32768 && reader.left() >= 4) {
    const uint8_t* first = reader.here();
    if (first[0] == 2 && first[1] == 2 && (size_t{first[2]} << 8 | first[3]) == width) return readNewRow(reader, row);
  }
  readOldRow(reader, row);
}

// Returns 2^(e - 136) per exponent; exponent 0 is black. The largest, 2^119, is a float.
std::array<float, 256> exponentScales() {
  std::array<float, 256> scales{};
  for (int e = 1; e < 256; ++e) scales[static_cast<size_t>(e)] = std::ldexp(1.0f, e - 136);
  return scales;
}

void convertRow(const std::vector<Rgbe>& row, bool rightToLeft, const std::array<float, 256>& scales, float* to) {
  for (size_t x = 0; x < row.size(); ++x) {
    const Rgbe& pixel = row[rightToLeft ? row.size() - 1 - x : x];
    const float scale = scales[pixel[3]];
    to[4 * x + 0] = pixel[0] * scale;
    to[4 * x + 1] = pixel[1] * scale;
    to[4 * x + 2] = pixel[2] * scale;
    to[4 * x + 3] = 1.0f;
  }
}

}  // namespace

FloatImage decodeRadiance(std::span<const std::byte> bytes, const std::string& name) {
  Reader reader(bytes, name);
  const Header header = readHeader(reader, name);
  // Check the minimum number of bytes of a row (old runs: a pixel and its count) and read one row first, so that an
  // invalid size fails before the image is allocated.
  if (reader.left() < header.height * std::min<uint64_t>(8, uint64_t{4} * header.width)) {
    badInput("'{}' is truncated: {} bytes can't hold {} x {} pixels; fetch it again", name, bytes.size(), header.width,
             header.height);
  }
  std::vector<Rgbe> row(header.width);
  Reader ahead = reader;
  readRow(ahead, row);
  FloatImage image(header.width, header.height);
  const std::array<float, 256> scales = exponentScales();
  for (uint32_t y = 0; y < header.height; ++y) {
    reader.startRow(y);
    readRow(reader, row);
    convertRow(row, header.rightToLeft, scales, image.at(0, header.bottomUp ? header.height - 1 - y : y));
  }
  return image;
}

}  // namespace latelight::scene
