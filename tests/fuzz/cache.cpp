// Files of the cache. The first byte selects an environment's entry or a table's. The checksum is made valid, because a
// file that another program wrote may have a valid one.
#include <vector>

#include "base/files.h"
#include "fuzz/fuzz.h"
#include "scene/environment/environment_cache.h"
#include "scene/environment/table_cache.h"

using namespace latelight;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::start();
  if (size == 0) return 0;
  const std::span<const std::byte> entry = fuzz::bytesOf(data, size).subspan(1);
  constexpr uint64_t kKey = 0x0123456789abcdef;
  switch (data[0] % 3) {
    case 0: {
      storeCache(scene::environmentCacheName(kKey), entry);
      const auto environment = scene::restoreEnvironment(kKey);
      if (environment && environment->specular.size() != scene::kSpecularRoughness.size())
        fuzz::report("an environment without all of its levels");
      break;
    }
    case 1:
      storeCache("table", entry);
      scene::cachedTable<float>("table", 8, [] { return std::vector<float>(8); });
      break;
    default:
      fuzz::writeInput("raw", entry);
      std::filesystem::create_directories(fuzz::folder() / "latelight");
      std::filesystem::rename(fuzz::folder() / "raw", fuzz::folder() / "latelight" / "raw");
      loadCache("raw");
      break;
  }
  return 0;
}
