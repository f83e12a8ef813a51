#include "cuda.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <cstdint>
#include <memory>
#include <string>

namespace latelight::python {

namespace {

// --- the used part of CUDA's driver API (docs.nvidia.com/cuda/cuda-driver-api), whose ABI does not change ------------

using Result = int;
using Context = void*;
using ExternalMemory = void*;
using DevicePointer = unsigned long long;

constexpr Result kSuccess = 0;
constexpr int kOpaqueFd = 1;  // CU_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD

struct Uuid {
  unsigned char bytes[16];
};

union OsHandle {
  int fd;
  struct {
    void* handle;
    const void* name;
  } win32;
};

struct MemoryHandleDesc {
  int type;
  OsHandle handle;
  unsigned long long size;
  unsigned int flags;
  unsigned int reserved[16];
};

struct MemoryBufferDesc {
  unsigned long long offset, size;
  unsigned int flags;
  unsigned int reserved[16];
};

using ExternalSemaphore = void*;
using Stream = void*;
using Event = void*;
constexpr int kTimelineFd = 9;              // CU_EXTERNAL_SEMAPHORE_HANDLE_TYPE_TIMELINE_SEMAPHORE_FD
constexpr unsigned int kNonBlocking = 1;    // CU_STREAM_NON_BLOCKING
constexpr unsigned int kDisableTiming = 2;  // CU_EVENT_DISABLE_TIMING
constexpr int kPointerDeviceOrdinal = 9;    // CU_POINTER_ATTRIBUTE_DEVICE_ORDINAL

struct SemaphoreHandleDesc {
  int type;
  OsHandle handle;
  unsigned int flags;
  unsigned int reserved[16];
};

struct SemaphoreSignalParams {
  struct {
    unsigned long long fence;
    unsigned long long nvSciSync;
    unsigned long long keyedMutex;
    unsigned int reserved[12];
  } params;
  unsigned int flags;
  unsigned int reserved[16];
};

struct Cuda {
  Result (*cuInit)(unsigned int) = nullptr;
  Result (*cuDeviceGetCount)(int*) = nullptr;
  Result (*cuDeviceGetUuid)(Uuid*, int) = nullptr;
  Result (*cuDevicePrimaryCtxRetain)(Context*, int) = nullptr;
  Result (*cuCtxPushCurrent_v2)(Context) = nullptr;
  Result (*cuCtxPopCurrent_v2)(Context*) = nullptr;
  Result (*cuCtxSynchronize)() = nullptr;
  Result (*cuImportExternalMemory)(ExternalMemory*, const MemoryHandleDesc*) = nullptr;
  Result (*cuExternalMemoryGetMappedBuffer)(DevicePointer*, ExternalMemory, const MemoryBufferDesc*) = nullptr;
  Result (*cuDestroyExternalMemory)(ExternalMemory) = nullptr;
  Result (*cuMemFree_v2)(DevicePointer) = nullptr;
  Result (*cuImportExternalSemaphore)(ExternalSemaphore*, const SemaphoreHandleDesc*) = nullptr;
  Result (*cuSignalExternalSemaphoresAsync)(const ExternalSemaphore*, const SemaphoreSignalParams*, unsigned int,
                                            Stream) = nullptr;
  Result (*cuDestroyExternalSemaphore)(ExternalSemaphore) = nullptr;
  Result (*cuStreamCreate)(Stream*, unsigned int) = nullptr;
  Result (*cuStreamDestroy_v2)(Stream) = nullptr;
  Result (*cuStreamWaitEvent)(Stream, Event, unsigned int) = nullptr;
  Result (*cuEventCreate)(Event*, unsigned int) = nullptr;
  Result (*cuEventRecord)(Event, Stream) = nullptr;
  Result (*cuEventDestroy_v2)(Event) = nullptr;
  Result (*cuMemcpyDtoDAsync_v2)(DevicePointer, DevicePointer, size_t, Stream) = nullptr;
  Result (*cuPointerGetAttribute)(void*, int, DevicePointer) = nullptr;
};

void check(Result result, const char* what) {
  if (result != kSuccess)
    throw Error(ExitCode::NoDevice, fmt::format("CUDA can't {} (error {}): take the arrays on the host", what, result));
}

template <typename Function>
void load(void* library, Function& function, const char* name) {
  function = reinterpret_cast<Function>(dlsym(library, name));
  if (!function) throw Error(ExitCode::NoDevice, fmt::format("CUDA's driver has no {}: install a newer one", name));
}

const Cuda& cuda() {
  static const Cuda loaded = [] {
    void* library = dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!library)
      throw Error(ExitCode::NoDevice, "there is no CUDA driver (libcuda.so.1): take the arrays on the host");
    Cuda c;
#define LOAD(name) load(library, c.name, #name);
    LOAD(cuInit)
    LOAD(cuDeviceGetCount)
    LOAD(cuDeviceGetUuid)
    LOAD(cuDevicePrimaryCtxRetain)
    LOAD(cuCtxPushCurrent_v2)
    LOAD(cuCtxPopCurrent_v2)
    LOAD(cuCtxSynchronize)
    LOAD(cuImportExternalMemory)
    LOAD(cuExternalMemoryGetMappedBuffer)
    LOAD(cuDestroyExternalMemory)
    LOAD(cuMemFree_v2)
    LOAD(cuImportExternalSemaphore)
    LOAD(cuSignalExternalSemaphoresAsync)
    LOAD(cuDestroyExternalSemaphore)
    LOAD(cuStreamCreate)
    LOAD(cuStreamDestroy_v2)
    LOAD(cuStreamWaitEvent)
    LOAD(cuEventCreate)
    LOAD(cuEventRecord)
    LOAD(cuEventDestroy_v2)
    LOAD(cuMemcpyDtoDAsync_v2)
    LOAD(cuPointerGetAttribute)
#undef LOAD
    check(c.cuInit(0), "start");
    return c;
  }();
  return loaded;
}

// --- contexts and memory --------------------------------------------------------------------------------------------

int deviceByUuid(const std::string& uuid) {
  int count = 0;
  check(cuda().cuDeviceGetCount(&count), "count its devices");
  for (int device = 0; device < count; ++device) {
    Uuid its{};
    check(cuda().cuDeviceGetUuid(&its, device), "name a device");
    if (fmt::format("{:02x}", fmt::join(its.bytes, "")) == uuid) return device;
  }
  throw Error(ExitCode::NoDevice, fmt::format("CUDA has no device {}: see CUDA_VISIBLE_DEVICES", uuid));
}

// Makes the primary context current, which torch, CuPy and similar libraries use, too, for the lifetime of this object.
class InContext {
 public:
  explicit InContext(Context context) { check(cuda().cuCtxPushCurrent_v2(context), "use its context"); }
  ~InContext() {
    Context popped = nullptr;
    cuda().cuCtxPopCurrent_v2(&popped);
  }
  InContext(const InContext&) = delete;
  InContext& operator=(const InContext&) = delete;
};

// The context is never released, because other libraries release theirs at process exit in an unknown order.
Context primaryContext(int device) {
  Context context = nullptr;
  check(cuda().cuDevicePrimaryCtxRetain(&context, device), "make a context");
  return context;
}

class Imported {
 public:
  explicit Imported(const DeviceArray& array)
      : device_(deviceByUuid(array.deviceUuid())), context_(primaryContext(device_)) {
    const InContext current(context_);
    MemoryHandleDesc handle{};
    handle.type = kOpaqueFd;
    handle.handle.fd = array.exportMemory();
    handle.size = array.memoryBytes();
    const Result imported = cuda().cuImportExternalMemory(&memory_, &handle);
    if (imported != kSuccess) close(handle.handle.fd);  // on success the driver owns it
    check(imported, "import the renderer's memory");
    MemoryBufferDesc buffer{};
    buffer.size = array.memoryBytes();
    const Result mapped = cuda().cuExternalMemoryGetMappedBuffer(&pointer_, memory_, &buffer);
    if (mapped != kSuccess) cuda().cuDestroyExternalMemory(memory_);
    check(mapped, "map the renderer's memory");
  }
  ~Imported() {
    cuda().cuCtxPushCurrent_v2(context_);
    cuda().cuMemFree_v2(pointer_);
    cuda().cuDestroyExternalMemory(memory_);
    Context popped = nullptr;
    cuda().cuCtxPopCurrent_v2(&popped);
  }
  Imported(const Imported&) = delete;
  Imported& operator=(const Imported&) = delete;

  CudaPointer place() const { return {reinterpret_cast<void*>(pointer_), device_}; }
  void waitForReaders() const {
    const InContext current(context_);
    check(cuda().cuCtxSynchronize(), "finish its work");
  }

 private:
  int device_;
  Context context_;
  ExternalMemory memory_ = nullptr;
  DevicePointer pointer_ = 0;
};

}  // namespace

CudaInputs::CudaInputs(const std::string& deviceUuid, const std::function<int()>& exportSemaphore)
    : device_(deviceByUuid(deviceUuid)), context_(primaryContext(device_)) {
  const InContext current(context_);
  SemaphoreHandleDesc handle{};
  handle.type = kTimelineFd;
  handle.handle.fd = exportSemaphore();
  const Result imported = cuda().cuImportExternalSemaphore(&semaphore_, &handle);
  if (imported != kSuccess) close(handle.handle.fd);  // on success the driver owns it
  check(imported, "import the renderer's semaphore");
  check(cuda().cuStreamCreate(&stream_, kNonBlocking), "make a stream");
  check(cuda().cuEventCreate(&event_, kDisableTiming), "make an event");
  check(cuda().cuEventCreate(&signaled_, kDisableTiming), "make an event");
}

CudaInputs::~CudaInputs() {
  cuda().cuCtxPushCurrent_v2(context_);
  for (Event event : {event_, signaled_})
    if (event) cuda().cuEventDestroy_v2(event);
  if (stream_) cuda().cuStreamDestroy_v2(stream_);
  if (semaphore_) cuda().cuDestroyExternalSemaphore(semaphore_);
  Context popped = nullptr;
  cuda().cuCtxPopCurrent_v2(&popped);
}

uintptr_t CudaInputs::stream() const {
  return reinterpret_cast<uintptr_t>(stream_);
}

int CudaInputs::deviceOf(uintptr_t pointer) const {
  const InContext current(context_);
  int device = -1;
  check(cuda().cuPointerGetAttribute(&device, kPointerDeviceOrdinal, pointer), "find the device of an array");
  return device;
}

void CudaInputs::copy(const DeviceArray& to, uint64_t offset, uintptr_t from, uint64_t bytes, uintptr_t stream,
                      uintptr_t writer) {
  const CudaPointer target = cudaInputPointerOf(to);
  const InContext current(context_);
  const auto on = reinterpret_cast<Stream>(stream);
  if (writer != 0 && writer != stream) {
    check(cuda().cuEventRecord(event_, reinterpret_cast<Stream>(writer)), "record an event");
    check(cuda().cuStreamWaitEvent(on, event_, 0), "wait for a stream");
  }
  check(cuda().cuMemcpyDtoDAsync_v2(reinterpret_cast<uintptr_t>(target.pointer) + offset, from, bytes, on),
        "copy an array");
  copied_ += bytes;
}

// Signals follow one another, also those of different streams: a timeline never goes back, and a later value would
// tell the renderer that the copies of an earlier call are done.
uint64_t CudaInputs::signal(uintptr_t stream) {
  const InContext current(context_);
  const auto on = reinterpret_cast<Stream>(stream);
  if (value_ > 0) check(cuda().cuStreamWaitEvent(on, signaled_, 0), "wait for a stream");
  SemaphoreSignalParams params{};
  params.params.fence = value_ + 1;
  check(cuda().cuSignalExternalSemaphoresAsync(&semaphore_, &params, 1, on), "signal the renderer");
  ++value_;
  check(cuda().cuEventRecord(signaled_, on), "record an event");
  return value_;
}

CudaPointer cudaInputPointerOf(const DeviceArray& array) {
  if (!array.attached()) array.attach(std::make_shared<Imported>(array));
  return static_cast<const Imported*>(array.attached().get())->place();
}

CudaPointer cudaPointerOf(const DeviceArray& array) {
  if (!array.attached()) {
    const auto imported = std::make_shared<Imported>(array);
    // The memory calls this only while it holds `imported`.
    array.beforeReuse([imported = imported.get()] { imported->waitForReaders(); });
    array.attach(imported);
  }
  return static_cast<const Imported*>(array.attached().get())->place();
}

}  // namespace latelight::python
