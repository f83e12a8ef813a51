#include "output/npy.h"

#include <Imath/half.h>
#include <fmt/ranges.h>

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>

#include "base/error.h"
#include "output/decode.h"

namespace latelight::output {
namespace {

static_assert(std::endian::native == std::endian::little, "values are written as they lie in memory");

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr size_t kAlignment = 64;  // alignment of the data in the file, so that it can be memory-mapped

struct Header {
  std::string descr;
  bool fortranOrder = false;
  std::vector<uint64_t> shape;
  size_t dataBegin = 0;
};

// Reads the header, a Python dictionary literal with three keys.
class HeaderReader {
 public:
  HeaderReader(std::span<const std::byte> bytes, const std::filesystem::path& path)
      : bytes_(reinterpret_cast<const char*>(bytes.data()), bytes.size()), path_(path) {}

  Header read() {
    const size_t begin = find();
    Header header;
    header.dataBegin = begin + text_.size();
    const std::string_view descr = valueOf("'descr':");
    if (descr.size() < 2 || descr[0] != '\'') broken("its type is not a simple one");
    header.descr = descr.substr(1, descr.find('\'', 1) - 1);
    header.fortranOrder = valueOf("'fortran_order':").starts_with("True");
    readShape(valueOf("'shape':"), header);
    return header;
  }

  [[noreturn]] void broken(std::string_view why) const {
    badInput("can't read '{}' as NPY: {}; give an array of shape (H, W) or (H, W, channels), in C order",
             path_.string(), why);
  }

 private:
  // Returns the offset of the header text, and sets text_.
  size_t find() {
    if (bytes_.size() < 12) broken("it ends in its header");
    const size_t lengthBytes = bytes_[6] == 1 ? 2 : 4;
    if (bytes_[6] < 1 || bytes_[6] > 3) broken("its version is unknown");
    uint32_t length = 0;
    std::memcpy(&length, bytes_.data() + 8, lengthBytes);
    const size_t begin = 8 + lengthBytes;
    if (length > bytes_.size() - begin) broken("it ends in its header");
    text_ = bytes_.substr(begin, length);
    return begin;
  }

  std::string_view valueOf(std::string_view key) const {
    const size_t at = text_.find(key);
    const size_t begin = at == std::string_view::npos ? at : text_.find_first_not_of(' ', at + key.size());
    if (begin == std::string_view::npos) broken(fmt::format("its header has no {}", key.substr(0, key.size() - 1)));
    return text_.substr(begin);
  }

  void readShape(std::string_view text, Header& header) const {
    const size_t end = text.find(')');
    if (!text.starts_with('(') || end == std::string_view::npos) broken("its shape is not a tuple");
    const char* at = text.data() + 1;
    const char* stop = text.data() + end;
    while (at != stop) {
      if (*at == ' ' || *at == ',') {
        ++at;
        continue;
      }
      uint64_t size = 0;
      const auto [next, error] = std::from_chars(at, stop, size);
      if (error != std::errc()) broken("its shape has invalid sizes");
      header.shape.push_back(size);
      at = next;
    }
  }

  std::string_view bytes_, text_;
  const std::filesystem::path& path_;
};

template <typename T>
double load(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof(T));
  return static_cast<double>(value);
}

struct Type {
  std::string_view descr;
  ChannelType type;
  size_t bytes;
  double (*load)(const std::byte*);
};
constexpr std::array kTypes{
    Type{"<f2", ChannelType::Half, 2, load<half>},        Type{"<f4", ChannelType::Float, 4, load<float>},
    Type{"<f8", ChannelType::Double, 8, load<double>},    Type{"|b1", ChannelType::Integer, 1, load<uint8_t>},
    Type{"|u1", ChannelType::Integer, 1, load<uint8_t>},  Type{"|i1", ChannelType::Integer, 1, load<int8_t>},
    Type{"<u2", ChannelType::Integer, 2, load<uint16_t>}, Type{"<i2", ChannelType::Integer, 2, load<int16_t>},
    Type{"<u4", ChannelType::Integer, 4, load<uint32_t>}, Type{"<i4", ChannelType::Integer, 4, load<int32_t>},
    Type{"<u8", ChannelType::Integer, 8, load<uint64_t>}, Type{"<i8", ChannelType::Integer, 8, load<int64_t>},
};

const Type* findType(std::string_view descr) {
  for (const Type& type : kTypes)
    if (type.descr == descr) return &type;
  return nullptr;
}

}  // namespace

std::vector<std::byte> encodeNpy(std::string_view type, std::span<const uint64_t> shape,
                                 std::span<const std::byte> data) {
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}{}), }}", type,
                                 fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
  constexpr size_t kBefore = 10;  // magic, version, length
  const size_t total = (kBefore + text.size() + 1 + kAlignment - 1) / kAlignment * kAlignment;
  text.append(total - kBefore - text.size() - 1, ' ');
  text += '\n';

  std::string header(kMagic);
  const char version[] = {1, 0};
  const char length[] = {static_cast<char>(text.size() & 0xff), static_cast<char>(text.size() >> 8)};
  header.append(version, 2).append(length, 2).append(text);
  std::vector<std::byte> out(header.size() + data.size());
  std::memcpy(out.data(), header.data(), header.size());
  std::memcpy(out.data() + header.size(), data.data(), data.size());
  return out;
}

std::vector<std::byte> encodeNpy(const AovImage& image) {
  const bool ids = holdsIntegers(image.aov);
  std::vector<uint64_t> shape{image.height, image.width};
  if (const uint32_t channels = info(image.aov).channels; channels > 1) shape.push_back(channels);
  if (ids) return encodeNpy("<u4", shape, std::as_bytes(std::span(image.ids)));
  return encodeNpy("<f4", shape, std::as_bytes(std::span(image.values)));
}

ReadImage decodeNpy(std::span<const std::byte> bytes, const std::filesystem::path& path) {
  HeaderReader reader(bytes, path);
  const Header header = reader.read();
  const Type* type = findType(header.descr);
  if (!type) reader.broken(fmt::format("its type is '{}'", header.descr));
  if (header.fortranOrder) reader.broken("it is in Fortran order");
  const std::vector<uint64_t>& shape = header.shape;
  if (shape.size() != 2 && shape.size() != 3) reader.broken(fmt::format("it has {} dimensions", shape.size()));
  constexpr uint64_t kMax = uint64_t{1} << 20;  // so that products stay below 2^63
  const uint64_t channels = shape.size() == 3 ? shape[2] : 1;
  if (shape[0] > kMax || shape[1] > kMax || channels > kMax) reader.broken("it is larger than any image");
  if (shape[0] * shape[1] * channels == 0) reader.broken("it is empty");
  const uint64_t values = shape[0] * shape[1] * channels;
  const std::span<const std::byte> data = bytes.subspan(header.dataBegin);
  if (values > data.size() / type->bytes) reader.broken("it ends before its last value");

  ReadImage image = makeReadImage(shape[1], shape[0], usualChannels(channels), type->type, path);
  const std::byte* at = data.data();
  for (uint64_t i = 0; i < values; ++i, at += type->bytes) {
    const double value = type->load(at);
    // Larger integers round to doubles, so that different ones would compare as equal.
    if (type->type == ChannelType::Integer && std::abs(value) >= 0x1p53) {
      badInput("'{}' holds an integer of 2^53 or more at pixel {},{}; use integers below 2^53, such as 32-bit ids",
               path.string(), i / channels % shape[1], i / channels / shape[1]);
    }
    image.channels[i % channels].values[i / channels] = value;
  }
  return image;
}

}  // namespace latelight::output
