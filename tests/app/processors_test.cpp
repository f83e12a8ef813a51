// Processors without AVX, as many virtual machines emulate: lavapipe then has vectors of four lanes. It reads
// GALLIUM_OVERRIDE_CPU_CAPS.
#include <gtest/gtest.h>

#include "app/folder.h"
#include "app/process.h"

namespace latelight::app {
namespace {

// Renders with all instructions of this processor, and without AVX.
void expectAlikeWithoutAvx(const std::vector<std::string>& options, const std::vector<std::string>& criteria) {
  const Folder folder;
  for (const auto& [name, instructions] : {std::pair("all.exr", ""), std::pair("few.exr", "sse4.1")}) {
    std::vector<std::string> arguments{"render", "--size", "64x48", "--device", "cpu", "-o", name};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Outcome outcome = latelight({.arguments = arguments,
                                       .environment = {{"GALLIUM_OVERRIDE_CPU_CAPS", instructions}},
                                       .folder = folder.path()});
    ASSERT_EQ(outcome.code, 0) << name << ": " << outcome.text();
  }
  std::vector<std::string> arguments{"compare", "all.exr", "few.exr"};
  arguments.insert(arguments.end(), criteria.begin(), criteria.end());
  const Outcome apart = latelight({.arguments = arguments, .folder = folder.path()});
  EXPECT_EQ(apart.code, 0) << apart.out << apart.text();
}

const std::string kGlass = "builtin:hall,triangles=50000,lights=4,glass=1";

// A few pixels, whose decisions lie on an edge, may differ.
TEST(ProcessorsWithoutAvx, RenderGlass) {
  for (const char* raster : {"hardware", "compute", "rays"}) {
    SCOPED_TRACE(raster);
    expectAlikeWithoutAvx({kGlass, "--raster", raster}, {"--tolerance", "0.01", "--share", "0.01"});
  }
}

// Directions are chosen by subgroups, which have four lanes there, so the noise differs.
TEST(ProcessorsWithoutAvx, TracePaths) {
  const std::vector<std::string> noisy{"--flip", "0.08"};
  expectAlikeWithoutAvx({"builtin:boxes", "--lighting", "reference", "--samples", "64"}, noisy);
  const std::vector<std::string> bounce{"builtin:boxes", "--indirect", "one-bounce", "--shadows", "rays"};
  for (const char* filter : {"none", "spatial", "temporal"}) {
    SCOPED_TRACE(filter);
    std::vector<std::string> options = bounce;
    options.insert(options.end(), {"--indirect-filter", filter});
    expectAlikeWithoutAvx(options, noisy);
  }
}

}  // namespace
}  // namespace latelight::app
