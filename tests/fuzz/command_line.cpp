// Command lines of `latelight render`: arguments separated by zero bytes. Options are added as by the program and read
// by the table of options; then the settings are checked.
#include <algorithm>
#include <string>
#include <vector>

#include "app/render_options.h"
#include "fuzz/fuzz.h"
#include "render/options/option_table.h"

using namespace latelight;

namespace {

void readCommandLine(std::vector<std::string> arguments) {
  CLI::App program("latelight");
  app::RenderOptions options;
  app::addRenderOptions(program, options);
  std::reverse(arguments.begin(), arguments.end());
  try {
    program.parse(std::move(arguments));
  } catch (const CLI::ParseError&) {
    return;
  }
  render::checkSettings(options.settings);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::start();
  std::vector<std::string> arguments;
  for (std::string_view rest = fuzz::textOf(data, size); !rest.empty();) {
    const size_t end = std::min(rest.find('\0'), rest.size());
    arguments.emplace_back(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  // If this throws, the table of options itself is wrong, and errors of inputs would hide it.
  [[maybe_unused]] static const bool works = (readCommandLine({"builtin:boxes", "-o", "out.png"}), true);
  fuzz::expectErrors({ExitCode::Usage}, [&] { readCommandLine(std::move(arguments)); });
  return 0;
}
