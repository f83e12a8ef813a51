// latelight: the command line. Exit codes are base/error.h's.
#include <fmt/core.h>

#include <cstdio>
#include <exception>
#include <new>

#include "app/commands.h"
#include "base/log.h"

namespace {

using namespace latelight;

int run(int argc, char** argv) {
  CLI::App cli{"Latelight: a deferred renderer that needs no display, no graphics pipeline and no particular GPU."};
  cli.name("latelight");
  cli.set_version_flag("--version", std::string("latelight ") + LATELIGHT_VERSION);
  cli.require_subcommand(1);
  cli.get_formatter()->column_width(34);
  cli.add_flag_callback("-q,--quiet", [] { setQuiet(true); }, "No warnings, no progress")->trigger_on_parse();
  cli.fallthrough();
  app::addRenderCommand(cli);
  app::addListCommand(cli);
  app::addDevicesCommand(cli);
  app::addDoctorCommand(cli);
  app::addCompareCommand(cli);
  try {
    cli.parse(argc, argv);
  } catch (const CLI::Success& request) {  // --help, --version
    return cli.exit(request);
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "latelight: {} (see latelight --help)\n", error.what());
    return static_cast<int>(ExitCode::Usage);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const app::Exit& exit) {
    return static_cast<int>(exit.code);
  } catch (const Error& error) {
    fmt::print(stderr, "latelight: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "latelight: out of memory; use a smaller scene or picture\n");
    return static_cast<int>(ExitCode::Internal);
  } catch (const std::exception& error) {
    fmt::print(stderr, "latelight: internal error: {}\n", error.what());
    return static_cast<int>(ExitCode::Internal);
  }
}
