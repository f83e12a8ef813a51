// Rays from the host through a scene: the surface that each hits first.
#pragma once

#include <functional>
#include <future>
#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/huge_pages.h"
#include "base/parallel.h"
#include "render/base/pass.h"
#include "render/outputs/exported.h"
#include "render/rays/cast_push.h"
#include "render/submit/result.h"

namespace latelight::render {

// Rays in the coordinate frame of Settings::axes, with any length of direction. A ray whose direction is zero, or which
// has a value that is not a finite number, hits nothing.
struct CastRays {
  std::span<const glm::dvec3> origins, directions;               // as many of both
  double maxDistance = std::numeric_limits<double>::infinity();  // meters
  std::span<const glm::vec3> floatOrigins{}, floatDirections{};  // in place of `origins` and `directions`
};

// A ray's value in an array of hits.
template <typename Element, int channels>
using HitValue = std::conditional_t<channels == 1, Element, glm::vec<channels, Element>>;

// Where hits are stored, one value per ray, as in CastHits. Null: not needed.
struct CastTargets {
#define HIT_ARRAY(name, element, channels) HitValue<element, channels>* name = nullptr;
#include "render/rays/hits.def"
};

// One value per ray. Rays that hit nothing have an infinite distance and zeros, as the background in data outputs.
struct CastHits {
#define HIT_ARRAY(name, element, channels) std::vector<HitValue<element, channels>> name;
#include "render/rays/hits.def"
};

// An array of hits: its name, the member of CastPush that has its address, and its elements per ray.
struct HitInfo {
  std::string_view name;
  uint64_t shared::CastPush::*address;
  uint32_t channels;
  bool integers;  // 32 bits, as floats have
};
std::span<const HitInfo> hitInfos();  // in the order of hits.def

// Calls `visit` for every array of hits, with its description and its member of each of the structs.
template <typename Visit, typename... Structs>
void forEachHitArray(const Visit& visit, Structs&... structs) {
  const HitInfo* info = hitInfos().data();
#define HIT_ARRAY(name, element, channels) visit(*info++, structs.name...);
#include "render/rays/hits.def"
}

// All arrays of a struct of hits, which are cleared in the background. Each array on its own thread, because the system
// clears the memory of large ones page by page.
template <typename Targets, typename Hits>
class HitMemory {
 public:
  HitMemory(Hits& hits, size_t count) {
    std::vector<std::function<void()>> clear;
    const auto add = [&](const HitInfo&, auto& values, auto& target) {
      values.reserve(count);
      adviseHugePages(values.data(), count * sizeof(values[0]));
      clear.push_back([&values, count] { values.resize(count); });
      target = values.data();
    };
    forEachHitArray(add, hits, targets_);
    cleared_ = inBackground([clear = std::move(clear)] {
      parallelFor(clear.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) clear[i]();
      });
    });
  }
  const Targets& targets() const { return targets_; }
  void wait() { cleared_.get(); }  // call it once, before anything is stored

 private:
  Targets targets_;
  std::future<void> cleared_;
};

// Rays in flight, as returned by Renderer::submitCast().
class CastTicket {
 public:
  struct Call;
  explicit CastTicket(std::unique_ptr<Call> call);
  CastTicket(CastTicket&&) noexcept;
  CastTicket& operator=(CastTicket&&) noexcept;
  ~CastTicket();
  bool done() const;  // take() would not wait for the device
  // Waits, and stores the hits that are not stored yet. May be called once, while the renderer lives.
  RenderStatistics take();

 private:
  std::unique_ptr<Call> call_;
};

struct CastResult {
  CastHits hits;
  RenderStatistics statistics;
  uint64_t bvhBytes = 0;  // device memory of the scene's BVHs
};

inline constexpr uint64_t kMaxWorldRays = uint64_t{1} << 31;  // of all worlds of a call, which a shader numbers

// Rays through worlds in memory of the device, and where their hits are needed.
struct WorldCast {
  VkDeviceAddress origins = 0, directions = 0;                   // [worlds][rays][3]
  bool doubles = false;                                          // elements, otherwise floats
  uint64_t rays = 0;                                             // per world
  double maxDistance = std::numeric_limits<double>::infinity();  // meters
  struct Target {
    const HitInfo* array;
    std::byte* host = nullptr;                 // of a caller, who has the hits here once the ticket is taken; or
    std::shared_ptr<ExportedMemory> memory{};  // of the device; if a caller gives none, submitCast() takes memory
  };
  std::vector<Target> hits{};
  std::vector<std::shared_ptr<const void>> memory{};  // that holds the origins and the directions
};

// The arrays of the caller that are to be filled.
std::vector<WorldCast::Target> worldTargets(const CastTargets& targets);

// The hits of rays through worlds.
struct WorldHits {
  uint32_t worlds = 0;
  uint64_t rays = 0;                      // per world
  std::vector<WorldCast::Target> arrays;  // each with `host` or `memory`
  std::vector<uint32_t> worldStatus;      // kWorld* bits of each world that shaders placed
};

// Rays through worlds in flight, as returned by Renderer::submitCast().
class WorldCastTicket {
 public:
  struct Call;
  explicit WorldCastTicket(std::unique_ptr<Call> call);
  WorldCastTicket(WorldCastTicket&&) noexcept;
  WorldCastTicket& operator=(WorldCastTicket&&) noexcept;
  ~WorldCastTicket();
  bool done() const;  // take() would not wait for the device
  // Waits for the hits, and stores those that the host needs. May be called once, while the device exists.
  WorldHits take();

 private:
  std::unique_ptr<Call> call_;
};

// The inputs of passes that trace rays through the scene.
struct RayPassInputs {
  VkDeviceAddress frame = 0;            // shared::FrameConstants, without views
  std::vector<vk::Constant> constants;  // specialization constants of shaders that evaluate materials
  glm::dvec3 origin{0};                 // of the device's world space, in the scene's
};
using AddRayPasses = std::function<void(const Builder&, const RayPassInputs&)>;

}  // namespace latelight::render
