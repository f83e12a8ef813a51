#include "shared_renderer.h"

#include <set>

#include "bindings.h"
#include "interpreter.h"
#include "values.h"

namespace latelight::python {

namespace {

// Returns all existing renderers. The GIL guards the set.
std::set<SharedRenderer*>& allRenderers() {
  static auto* const renderers = new std::set<SharedRenderer*>;
  return *renderers;
}

// Copies arrays in CUDA's memory to the renderer's, on the device.
void copyTensors(SharedRenderer& shared, Renderer& renderer, GivenWorlds& given, uintptr_t stream) {
  uint64_t bytes = 0;
  const auto padded = [](uint64_t count) { return (count + 255) / 256 * 256; };
  for (const GivenWorlds::Input& input : given.tensors) bytes += padded(input.tensor.bytes);
  CudaInputs& cuda = shared.cudaInputs();
  const std::shared_ptr<const DeviceArray> memory = renderer.inputArray(bytes);
  uint64_t offset = 0;
  for (GivenWorlds::Input& input : given.tensors) {
    const Tensor& tensor = input.tensor;
    const int device = tensor.device >= 0 ? tensor.device : cuda.deviceOf(tensor.pointer);
    if (device != cuda.device())
      badValue("{} is on cuda:{}, and the renderer's device is cuda:{}: pass arrays of the same device", input.name,
               device, cuda.device());
    cuda.copy(*memory, offset, tensor.pointer, tensor.bytes, stream, tensor.writer);
    input.array->device = memory;
    input.array->offset = offset;
    offset += padded(tensor.bytes);
  }
}

}  // namespace

SharedRenderer::SharedRenderer(std::shared_ptr<SharedScene> scene, std::unique_ptr<Renderer> renderer)
    : scene_(std::move(scene)), renderer_(std::move(renderer)) {
  renderer_->whileWaiting(raiseSignals);
  allRenderers().insert(this);
}

SharedRenderer::~SharedRenderer() {
  allRenderers().erase(this);
  const WithoutGil others;  // the destructor waits for its device
  renderer_.reset();
}

CudaInputs& SharedRenderer::cudaInputs() {
  if (!cudaInputs_)
    cudaInputs_ =
        std::make_unique<CudaInputs>(renderer_->deviceUuid(), [&] { return renderer_->exportInputSemaphore(); });
  return *cudaInputs_;
}

uintptr_t readerOf(SharedRenderer& renderer, WorldCall& call) {
  if (call.stream == 0) call.stream = renderer.use([&](Renderer&) { return renderer.cudaInputs().stream(); });
  return call.stream;
}

WorldCall worldCall(const std::shared_ptr<SharedRenderer>& renderer, nb::handle count, nb::handle cameras,
                    nb::dict& keywords) {
  WorldCall call;
  const nb::object callers = keywords.attr("pop")("stream", nb::none());
  call.stream = callers.is_none() ? 0 : streamOf(callers);
  const auto reader = [&] { return readerOf(*renderer, call); };
  const auto vertices = [&](Handle<Mesh> mesh) {
    return renderer->scene()->read([&](const Scene& s) { return s.mesh(mesh).vertices; });
  };
  call.given = worldsOf(count, cameras, keywords, reader, vertices);
  return call;
}

Worlds& completed(WorldCall& call, SharedRenderer& shared, Renderer& renderer) {
  Worlds& worlds = call.given->worlds;
  if (!call.given->tensors.empty()) copyTensors(shared, renderer, *call.given, call.stream);
  if (call.stream != 0) worlds.arrays.ready = shared.cudaInputs().signal(call.stream);
  return worlds;
}

// Ignores errors: an error that a device reports only here would have been raised when its images are taken.
void finishRenderers() {
  const std::set<SharedRenderer*> all = allRenderers();  // another thread may drop renderers meanwhile
  for (SharedRenderer* renderer : all) {
    try {
      renderer->use([](Renderer& r) { r.finish(); });
    } catch (const Error&) {
    }
  }
}

}  // namespace latelight::python
