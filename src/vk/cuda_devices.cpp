// Asks CUDA's driver (docs.nvidia.com/cuda/cuda-driver-api), because its default order, FASTEST_FIRST, is a heuristic
// that is not documented.
#include "vk/cuda_devices.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace latelight::vk {

namespace {

struct Uuid {
  unsigned char bytes[16];
};

constexpr int kNoDevice = 100;  // CUDA_ERROR_NO_DEVICE, also where CUDA_VISIBLE_DEVICES excludes every device

// The used functions, whose ABI does not change. Each returns 0 on success.
struct CudaDriver {
  int (*init)(unsigned flags) = nullptr;
  int (*count)(int* devices) = nullptr;
  int (*uuid)(Uuid* uuid, int device) = nullptr;
};

std::optional<CudaDriver> loadCuda() {
  void* library = dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);
  if (!library) return std::nullopt;
  CudaDriver driver;
  driver.init = reinterpret_cast<decltype(driver.init)>(dlsym(library, "cuInit"));
  driver.count = reinterpret_cast<decltype(driver.count)>(dlsym(library, "cuDeviceGetCount"));
  driver.uuid = reinterpret_cast<decltype(driver.uuid)>(dlsym(library, "cuDeviceGetUuid"));
  if (!driver.init || !driver.count || !driver.uuid) return std::nullopt;
  return driver;
}

}  // namespace

std::optional<std::vector<std::string>> cudaDevices() {
  const std::optional<CudaDriver> driver = loadCuda();
  if (!driver) return std::nullopt;
  const int started = driver->init(0);
  if (started == kNoDevice) return std::vector<std::string>{};
  int count = 0;
  if (started != 0 || driver->count(&count) != 0) return std::nullopt;
  std::vector<std::string> uuids;
  for (int device = 0; device < count; ++device) {
    Uuid uuid{};
    if (driver->uuid(&uuid, device) != 0) return std::nullopt;
    uuids.push_back(fmt::format("{:02x}", fmt::join(uuid.bytes, "")));
  }
  return uuids;
}

}  // namespace latelight::vk
