// Decodes JPEG images with libjpeg-turbo.
#include <turbojpeg.h>

#include <memory>
#include <string_view>

#include "base/error.h"
#include "base/log.h"
#include "scene/textures/codecs.h"

namespace latelight::scene {
namespace {

using JpegDecoder = std::unique_ptr<void, int (*)(tjhandle)>;

struct Header {
  JpegDecoder decoder{nullptr, tjDestroy};
  ImageSize size;
  int colorspace = 0;
};

Header readHeader(std::span<const std::byte> encoded, const std::string& name) {
  Header header;
  header.decoder.reset(tjInitDecompress());
  if (!header.decoder) fail(ExitCode::Internal, "The JPEG decoder could not start: {}", tjGetErrorStr2(nullptr));
  int width = 0, height = 0, subsampling = 0;
  if (tjDecompressHeader3(header.decoder.get(), bytesOf(encoded), encoded.size(), &width, &height, &subsampling,
                          &header.colorspace) != 0)
    badInput("{} is an invalid JPEG image: {}", name, tjGetErrorStr2(header.decoder.get()));
  header.size = {uint32_t(width), uint32_t(height)};
  return header;
}

// Returns true if a marker ends the image (EOI; ITU T.81, annex B). The decoder inserts a missing one, and reports only
// its last warning, which may be another one than that of the insertion.
bool hasEnd(std::span<const std::byte> encoded) {
  constexpr unsigned kPrefix = 0xff, kStuffing = 0x00, kFirstRestart = 0xd0, kStart = 0xd8, kEnd = 0xd9;
  for (size_t at = 0; at + 1 < encoded.size();) {
    const auto marker = unsigned(encoded[at + 1]);
    if (unsigned(encoded[at]) != kPrefix || marker == kPrefix || marker == kStuffing) {
      ++at;  // entropy-coded data, or fill bytes before a marker
    } else if (marker == kEnd) {
      return true;
    } else if (marker >= kFirstRestart && marker <= kStart) {
      at += 2;
    } else {  // a segment with its length, which may contain images of its own, such as thumbnails
      if (at + 3 >= encoded.size()) return false;
      at += 2 + 256 * size_t(encoded[at + 2]) + size_t(encoded[at + 3]);
    }
  }
  return false;
}

// After warnings the image is usable, unless the data ended early and the rest of it is gray.
void decompress(const Header& header, std::span<const std::byte> encoded, const std::string& name, TJPF format,
                std::byte* pixels) {
  // LIMITSCANS: a small progressive file could otherwise require hours of work.
  if (tjDecompress2(header.decoder.get(), bytesOf(encoded), encoded.size(), reinterpret_cast<unsigned char*>(pixels),
                    int(header.size.width), 0, int(header.size.height), format, TJFLAG_LIMITSCANS) == 0)
    return;
  std::string_view reason = tjGetErrorStr2(header.decoder.get());
  if (tjGetErrorCode(header.decoder.get()) == TJERR_FATAL) badInput("{} is an invalid JPEG image: {}", name, reason);
  // "Premature end of JPEG file" and "Corrupt JPEG data: premature end of data segment"
  if (!hasEnd(encoded) || reason.find("remature end") != std::string_view::npos)
    badInput("{} is an invalid JPEG image: it is truncated ({})", name, reason);
  warn("{} is a damaged JPEG image, of which the intact part is used: {}", name, reason);
}

ImageSize sizeOfJpeg(std::span<const std::byte> encoded, const std::string& name) {
  return readHeader(encoded, name).size;
}

// Adobe's four-channel JPEGs store inverted inks, which the decoder passes through: 255 is no ink.
void decodeInks(const Header& header, std::span<const std::byte> encoded, const std::string& name, std::byte* rgba) {
  decompress(header, encoded, name, TJPF_CMYK, rgba);
  size_t pixels = size_t(header.size.width) * header.size.height;
  for (std::byte* p = rgba; p != rgba + pixels * 4; p += 4) {
    unsigned black = unsigned(p[3]);
    for (int c = 0; c < 3; ++c) p[c] = std::byte((unsigned(p[c]) * black + 127) / 255);
    p[3] = std::byte{255};
  }
}

void decodeJpeg(std::span<const std::byte> encoded, const std::string& name, ImageSize, std::byte* rgba) {
  Header header = readHeader(encoded, name);
  if (header.colorspace == TJCS_CMYK || header.colorspace == TJCS_YCCK)
    decodeInks(header, encoded, name, rgba);
  else
    decompress(header, encoded, name, TJPF_RGBA, rgba);
}

}  // namespace

const Codec kJpegCodec{sizeOfJpeg, decodeJpeg};

}  // namespace latelight::scene
