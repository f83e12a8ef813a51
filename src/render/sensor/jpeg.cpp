#include <turbojpeg.h>

#include <memory>

#include "base/error.h"
#include "render/sensor/sensor.h"

namespace latelight::render {

void addJpegArtifacts(std::vector<uint8_t>& rgba, uint32_t width, uint32_t height, uint32_t quality) {
  const std::unique_ptr<void, int (*)(void*)> encoder(tjInitCompress(), tjDestroy),
      decoder(tjInitDecompress(), tjDestroy);
  unsigned char* file = nullptr;
  unsigned long bytes = 0;
  const auto w = static_cast<int>(width), h = static_cast<int>(height);
  const bool isEncoded = encoder && decoder &&
                         tjCompress2(encoder.get(), rgba.data(), w, 0, h, TJPF_RGBX, &file, &bytes, TJSAMP_420,
                                     static_cast<int>(quality), TJFLAG_ACCURATEDCT) == 0;
  const std::unique_ptr<unsigned char, void (*)(unsigned char*)> owner(file, tjFree);
  if (!isEncoded) fail(ExitCode::Internal, "a picture could not be compressed: {}", tjGetErrorStr2(encoder.get()));
  std::vector<uint8_t> decoded(rgba.size());
  if (tjDecompress2(decoder.get(), file, bytes, decoded.data(), w, 0, h, TJPF_RGBX, TJFLAG_ACCURATEDCT) != 0)
    fail(ExitCode::Internal, "a picture could not be decompressed: {}", tjGetErrorStr2(decoder.get()));
  for (size_t i = 0; i < rgba.size(); ++i)
    if (i % 4 < 3) rgba[i] = decoded[i];
}

}  // namespace latelight::render
