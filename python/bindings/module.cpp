// Defines the module latelight._core.
#include <cstring>

#include "bindings.h"
#include "lidar.h"

#include <latelight/latelight.h>

#include "interpreter.h"
#include "options.h"
#include "values.h"

namespace latelight::python {

namespace {

// The caller has checked the indices and the sum of the counts.
nb::object trianglesOf(const nb::ndarray<const float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>& points,
                       const nb::ndarray<const int64_t, nb::shape<-1>, nb::c_contig, nb::device::cpu>& indices,
                       const nb::ndarray<const int64_t, nb::shape<-1>, nb::c_contig, nb::device::cpu>& counts) {
  std::vector<int64_t> corners;
  std::vector<std::array<float, 3>> polygon;
  int64_t first = 0;
  for (size_t i = 0; i < counts.shape(0); first += counts.data()[i++]) {
    if (counts.data()[i] == 3) {
      corners.insert(corners.end(), {first, first + 1, first + 2});
      continue;
    }
    polygon.clear();
    for (int64_t corner = 0; corner < counts.data()[i]; ++corner) {
      const float* p = points.data() + 3 * indices.data()[first + corner];
      polygon.push_back({p[0], p[1], p[2]});
    }
    for (const auto& triangle : triangulate(polygon))
      for (const uint32_t corner : triangle) corners.push_back(first + corner);
  }
  const size_t triangles = corners.size() / 3;
  return owned(std::move(corners), {triangles, 3});
}

}  // namespace

NB_MODULE(_core, module) {
  module.doc() = "Latelight's renderer: what the package `latelight` gives.";
  bindErrors();
  bindCamera(module);
  bindElements(module);
  bindScene(module);
  bindDeviceArray(module);
  bindRenderer(module);
  bindLidar(module);
  bindInterpreter(module, &finishRenderers);
  module.def("version", &version, "The library's version, as in \"0.1.0\".");
  module.def(
      "encode_png",
      [](const nb::ndarray<const uint8_t, nb::shape<-1, -1, 4>, nb::c_contig, nb::device::cpu>& rgba) {
        const std::vector<uint8_t> pixels(rgba.data(), rgba.data() + rgba.size());
        const auto file = encodePng(static_cast<uint32_t>(rgba.shape(1)), static_cast<uint32_t>(rgba.shape(0)), pixels);
        return nb::bytes(file.data(), file.size());
      },
      nb::arg("rgba"), "A picture (H, W, 4), sRGB, straight alpha, as a PNG file.");
  module.def(
      "read_environment",
      [](nb::handle file) {
        EnvironmentData data = readEnvironment(pathOf(file, "file"));
        std::vector<float> values(3 * data.radiance.size());
        std::memcpy(values.data(), data.radiance.data(), sizeof(float) * values.size());
        return owned(std::move(values), {data.height, data.width, 3});
      },
      argument("file"),
      nb::sig("def read_environment(file: str | os.PathLike[str]) -> numpy.typing.NDArray[typing.Any]"),
      "The radiance (H, W, 3) of a .hdr or .exr file, as floats with the file's values.");
  module.def(
      "triangulate", &trianglesOf, nb::arg("points"), nb::arg("indices"), nb::arg("counts"),
      "The triangles (T, 3) of polygons with these counts of corners, as indices of `indices`, which are those of "
      "points.");
  module.def("_check_world_keywords", &checkWorldKeywords, nb::arg("keywords"));  // for add_pixels()
  module.def(
      "set_memory_limit",
      [](nb::handle bytes) { setMemoryLimit(static_cast<uint64_t>(integerOf(bytes, "bytes", 0, INT64_MAX))); },
      argument("bytes"), nb::sig("def set_memory_limit(bytes: int) -> None"),
      "Bytes of the machine's memory that scenes, pictures and CPU devices may take; more raises OutOfMemoryError "
      "before\nit is taken. 0, as at first: three quarters of what is free.");
}

}  // namespace latelight::python
