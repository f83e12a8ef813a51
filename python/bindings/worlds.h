// Converts the arguments of render_worlds() and submit_worlds().
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tensors.h"

namespace latelight::python {

// The arguments of a call. Arrays refer to memory of `kept` and `tensors`.
struct GivenWorlds {
  struct Input {
    WorldArray* array;  // of `worlds` or `rays`
    const char* name;
    Tensor tensor;
  };
  Worlds worlds;
  WorldRays rays;  // of cast_worlds()
  std::vector<nanobind::object> kept;
  std::vector<Input> tensors;  // that have yet to be copied to the renderer's memory
};

// Removes the arguments that describe worlds from `keywords`. `stream`: returns the stream that will read arrays in
// CUDA's memory; called only if there are such arrays.
// `vertices`: returns the number of vertices of a mesh.
std::unique_ptr<GivenWorlds> worldsOf(nanobind::handle count, nanobind::handle cameras, nanobind::dict& keywords,
                                      const std::function<uintptr_t()>& stream,
                                      const std::function<uint64_t(Handle<Mesh>)>& vertices);
// Reads the rays of worlds, (N, R, 3), or, with one world, (R, 3). `stream`: that which reads arrays in CUDA's memory.
void readRays(GivenWorlds& given, nanobind::handle origins, nanobind::handle directions, bool perWorld,
              uintptr_t stream);
bool isWorldArgument(std::string_view name);
std::string worldParameters();  // of a signature: ", instances: ... = None" and so on
std::string worldDocs();

}  // namespace latelight::python
