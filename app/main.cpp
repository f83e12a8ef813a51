// latelight: the command line. Exit codes are base/error.h's.
#include <fmt/core.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>

#include "app/commands.h"
#include "base/log.h"

namespace {

using namespace latelight;

std::string commandNames(const CLI::App& cli) {
  std::string names;
  for (const CLI::App* command : cli.get_subcommands(nullptr))
    names += (names.empty() ? "" : ", ") + command->get_name();
  return "the commands are " + names + "; see latelight --help";
}

int parseAndRun(int argc, char** argv) {
  CLI::App cli{"Latelight: a deferred renderer that needs no display, no graphics pipeline and no particular GPU."};
  cli.name("latelight");
  cli.set_version_flag("--version", std::string("latelight ") + LATELIGHT_VERSION);
  cli.require_subcommand(0, 1);  // none is said below, in better words than "a subcommand is required"
  cli.get_formatter()->column_width(34);
  cli.add_flag_callback(
         "-q,--quiet", [] { setQuiet(true); }, "No warnings, no progress")
      ->trigger_on_parse();
  cli.fallthrough();
  app::addRenderCommand(cli);
  app::addListCommand(cli);
  app::addDevicesCommand(cli);
  app::addDoctorCommand(cli);
  app::addCompareCommand(cli);
  app::addStudyCommand(cli);
  try {
    cli.parse(argc, argv);
  } catch (const CLI::Success& request) {  // --help, --version
    return cli.exit(request);
  } catch (const CLI::ParseError& error) {
    const std::string advice = cli.get_subcommands().empty() ? commandNames(cli) : "see latelight --help";
    fmt::print(stderr, "latelight: {} ({})\n", error.what(), advice);
    return static_cast<int>(ExitCode::Usage);
  }
  if (cli.get_subcommands().empty()) badUsage("no command is given ({})", commandNames(cli));
  return 0;
}

int run(int argc, char** argv) {
  try {
    return parseAndRun(argc, argv);
  } catch (const app::Exit& exit) {
    return static_cast<int>(exit.code);
  } catch (const Error& error) {
    fmt::print(stderr, "latelight: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "latelight: out of memory; use a smaller scene or picture\n");
    return static_cast<int>(ExitCode::DeviceLost);
  } catch (const std::length_error&) {  // more than any machine has
    fmt::print(stderr, "latelight: out of memory; use a smaller scene or picture\n");
    return static_cast<int>(ExitCode::DeviceLost);
  } catch (const std::exception& error) {
    if (std::ferror(stdout)) return static_cast<int>(ExitCode::Usage);  // main() says it
    fmt::print(stderr, "latelight: internal error: {}\n", error.what());
    return static_cast<int>(ExitCode::Internal);
  }
}

}  // namespace

int main(int argc, char** argv) {
  // A file that reaches the limit on sizes is an error of write(), which leaves no half file, and not the end.
  std::signal(SIGXFSZ, SIG_IGN);
  const int code = run(argc, argv);
  // Text leaves when its buffer does: a full disk may show only here.
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return code;
  fmt::print(stderr, "latelight: can't write to standard output; free some space, or send it elsewhere\n");
  return static_cast<int>(ExitCode::Usage);
}
