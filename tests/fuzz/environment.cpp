// Environment images: Radiance .hdr and OpenEXR.
#include "fuzz/fuzz.h"
#include "scene/environment/picture.h"

using namespace latelight;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::start();
  fuzz::expectErrors({ExitCode::BadInput}, [&] {
    scene::FloatImage image = scene::decodePicture(fuzz::bytesOf(data, size), "an environment");
    scene::clampRadiance(image);
    const auto texels = image.pixels.size() / 4;
    if (texels > 0 && texels < 1 << 16) scene::resizeEquirectangular(image, 8, 4);
  });
  return 0;
}
