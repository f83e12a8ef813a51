// EXT_meshopt_compression: decodes bufferViews that meshoptimizer's codecs have compressed.
#include <meshoptimizer.h>

#include <string>

#include "base/error.h"
#include "base/parallel.h"
#include "scene/gltf/document.h"

namespace latelight::scene::gltf {
using nlohmann::json;
namespace {

enum class Mode { Attributes, Triangles, Indices };
enum class Filter { None, Octahedral, Quaternion, Exponential };

struct Stream {
  size_t view;
  Bytes encoded;
  size_t count, stride;
  Mode mode;
  Filter filter;
  std::byte* target;
};

Mode readMode(const std::string& mode, const std::string& name) {
  if (mode == "ATTRIBUTES") return Mode::Attributes;
  if (mode == "TRIANGLES") return Mode::Triangles;
  if (mode == "INDICES") return Mode::Indices;
  badInput("{} has the unknown mode \"{}\"", name, mode);
}

Filter readFilter(const std::string& filter, const std::string& name) {
  if (filter == "NONE") return Filter::None;
  if (filter == "OCTAHEDRAL") return Filter::Octahedral;
  if (filter == "QUATERNION") return Filter::Quaternion;
  if (filter == "EXPONENTIAL") return Filter::Exponential;
  badInput("{} has the unknown filter \"{}\"", name, filter);
}

// Checks the layout, because the decoders only assert it.
void checkLayout(const Stream& s, const std::string& name) {
  bool layout = s.mode == Mode::Attributes ? s.stride % 4 == 0 : s.stride == 2 || s.stride == 4;
  bool filter = s.filter == Filter::None || s.filter == Filter::Exponential ||
                (s.filter == Filter::Octahedral && (s.stride == 4 || s.stride == 8)) ||
                (s.filter == Filter::Quaternion && s.stride == 8);
  if (s.filter != Filter::None && s.mode != Mode::Attributes) filter = false;
  if (!layout || !filter) badInput("{} has a byteStride of {}, which its mode or filter does not have", name, s.stride);
  if (s.mode == Mode::Triangles && s.count % 3 != 0) badInput("{} has {} indices, not a multiple of 3", name, s.count);
}

Stream readStream(Document& document, const json& view, size_t index, const std::vector<Bytes>& buffers) {
  std::string name = fmt::format("bufferViews[{}].extensions.EXT_meshopt_compression", index);
  const json& object = view["extensions"]["EXT_meshopt_compression"];
  Stream stream{.view = index,
                .count = object["count"].get<size_t>(),
                .stride = object["byteStride"].get<size_t>(),
                .mode = readMode(object["mode"].get<std::string>(), name),
                .filter = readFilter(object.value("filter", std::string("NONE")), name)};
  checkLayout(stream, name);
  Bytes buffer = buffers[object["buffer"].get<size_t>()];
  size_t offset = object.value("byteOffset", size_t{0}), length = object["byteLength"].get<size_t>();
  if (offset + length > buffer.size()) badInput("{} reaches past the end of its buffer", name);
  stream.encoded = buffer.subspan(offset, length);

  size_t bytes = stream.count * stream.stride;
  if (view["byteLength"].get<size_t>() > bytes) badInput("{} has fewer bytes than its bufferView", name);
  document.budget.charge(bytes, name);
  document.decoded.push_back(std::make_unique_for_overwrite<std::byte[]>(bytes));
  stream.target = document.decoded.back().get();
  document.views[index].bytes = Bytes(stream.target, bytes);
  return stream;
}

void decode(const Stream& s) {
  auto encoded = reinterpret_cast<const unsigned char*>(s.encoded.data());
  int result = 0;
  switch (s.mode) {
    case Mode::Attributes:
      result = meshopt_decodeVertexBuffer(s.target, s.count, s.stride, encoded, s.encoded.size());
      break;
    case Mode::Triangles:
      result = meshopt_decodeIndexBuffer(s.target, s.count, s.stride, encoded, s.encoded.size());
      break;
    case Mode::Indices:
      result = meshopt_decodeIndexSequence(s.target, s.count, s.stride, encoded, s.encoded.size());
      break;
  }
  if (result != 0)
    badInput("bufferViews[{}] cannot be decompressed: its EXT_meshopt_compression data are invalid", s.view);
  if (s.filter == Filter::Octahedral) meshopt_decodeFilterOct(s.target, s.count, s.stride);
  if (s.filter == Filter::Quaternion) meshopt_decodeFilterQuat(s.target, s.count, s.stride);
  if (s.filter == Filter::Exponential) meshopt_decodeFilterExp(s.target, s.count, s.stride);
}

}  // namespace

void decodeMeshopt(Document& document, const json& root, const std::vector<Bytes>& buffers) {
  auto views = root.find("bufferViews");
  if (views == root.end()) return;
  std::vector<Stream> streams;
  for (size_t i = 0; i < views->size(); ++i) {
    const json& view = (*views)[i];
    if (view.contains(json::json_pointer("/extensions/EXT_meshopt_compression")))
      streams.push_back(readStream(document, view, i, buffers));
  }
  parallelFor(streams.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) decode(streams[i]);
  });
}

}  // namespace latelight::scene::gltf
