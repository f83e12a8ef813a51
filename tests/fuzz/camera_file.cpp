// Camera files of other programs. The first byte selects the format; COLMAP's two files are separated by a byte 0xff.
#include <algorithm>

#include "data/cameras/bop.h"
#include "data/cameras/colmap.h"
#include "data/cameras/transforms.h"
#include "data/cameras/tum.h"
#include "fuzz/fuzz.h"

using namespace latelight;

namespace {

using Bytes = std::span<const std::byte>;

std::filesystem::path writeColmap(Bytes bytes, const char* cameras, const char* images) {
  const size_t at = size_t(std::ranges::find(bytes, std::byte{0xff}) - bytes.begin());
  fuzz::writeInput(cameras, bytes.first(at));
  fuzz::writeInput(images, bytes.subspan(std::min(at + 1, bytes.size())));
  return fuzz::folder();
}

void readCameras(uint8_t format, Bytes bytes) {
  switch (format % 5) {
    case 0:
      data::readColmapText(writeColmap(bytes, "cameras.txt", "images.txt"));
      break;
    case 1:
      data::readColmapBinary(writeColmap(bytes, "cameras.bin", "images.bin"));
      break;
    case 2:
      data::readTum(fuzz::writeInput("trajectory.txt", bytes));
      break;
    case 3:
      data::readBop(fuzz::writeInput("scene_camera.json", bytes), {640, 480});
      break;
    default:
      data::readTransforms(fuzz::writeInput("transforms.json", bytes), {640, 480});
      break;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::start();
  if (size == 0) return 0;
  fuzz::expectErrors({ExitCode::BadInput, ExitCode::Usage},
                     [&] { readCameras(data[0], fuzz::bytesOf(data, size).subspan(1)); });
  return 0;
}
