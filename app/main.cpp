// `latelight`: the command line. base/error.h defines the exit codes.
#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <latelight/latelight.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/commands.h"
#include "app/complete.h"
#include "base/fatal_signals.h"
#include "base/log.h"
#include "base/temporary_file.h"
#include "base/text.h"

namespace latelight::app {

void addQuietFlag(CLI::App& command) {
  command
      .add_flag_callback(
          "-q,--quiet", [] { setQuiet(true); }, "Suppress warnings and progress")
      ->trigger_on_parse();
}

}  // namespace latelight::app

namespace {

using namespace latelight;

// Prints an error. If standard error is not writable, only the exit code remains.
void complain(std::string_view sentence) {
  std::fputs(("latelight: " + printable(sentence) + "\n").c_str(), stderr);
}

// A whole line, which both functions below write without allocating.
constexpr std::string_view kOutOfMemory = "latelight: out of memory; use a smaller scene or image\n";

int outOfMemory() {
  std::fputs(kOutOfMemory.data(), stderr);
  return static_cast<int>(ExitCode::OutOfMemory);
}

std::terminate_handler otherwise = nullptr;

// Memory may run out where no exception may leave, such as in the destructor of nlohmann::json, which allocates. The
// program then ends like outOfMemory(), but without allocating.
[[noreturn]] void endWithoutMemory() {
  try {
    if (const std::exception_ptr exception = std::current_exception()) std::rethrow_exception(exception);
  } catch (const std::bad_alloc&) {
    removeTemporaryFiles();
    if (write(STDERR_FILENO, kOutOfMemory.data(), kOutOfMemory.size()) < 0) errno = 0;  // only the exit code remains
    _exit(static_cast<int>(ExitCode::OutOfMemory));
  } catch (...) {
  }
  otherwise();
  std::abort();
}

std::string commandNames(const CLI::App& cli) {
  std::string names;
  for (const CLI::App* command : cli.get_subcommands(nullptr))
    names += (names.empty() ? "" : ", ") + command->get_name();
  return "the commands are " + names + "; see latelight --help";
}

// Returns true if a value follows this option.
bool takesValue(const CLI::App& cli, const std::string& option) {
  for (const CLI::App* command : cli.get_subcommands(nullptr))
    if (const CLI::Option* found = command->get_option_no_throw(option)) return found->get_items_expected_min() > 0;
  return false;
}

bool isLongOption(const CLI::App& cli, const std::string& name) {
  if (cli.get_option_no_throw("--" + name)) return true;
  for (const CLI::App* command : cli.get_subcommands(nullptr))
    if (command->get_option_no_throw("--" + name)) return true;
  return false;
}

// Rejects long options with a single dash. CLI11 would read "-hdri" as the letter "-h" and more, and print the help.
void checkDashes(const CLI::App& cli, int argc, char** argv) {
  for (int i = 1; i < argc && std::string_view(argv[i]) != "--"; ++i) {
    const std::string argument = argv[i], name = argument.substr(0, argument.find('='));
    if (name.size() < 3 || name[0] != '-' || name[1] == '-' || takesValue(cli, argv[i - 1])) continue;
    if (isLongOption(cli, name.substr(1)))
      badUsage("\"{}\" has one dash, but long options have two: -{}", argument, name);
    // Allows flags in one word, optionally followed by -o with its value.
    const size_t rest = name.find_first_not_of("hq", 1);
    if (rest > 1 && rest != std::string::npos && name[rest] != 'o')
      badUsage("there is no option \"{}\"; see latelight --help", argument);
  }
}

// Returns the command that was given, such as "latelight bench views", and its options.
std::pair<std::string, const CLI::App*> commandOf(const CLI::App& cli) {
  std::string name = cli.get_name();
  const CLI::App* command = &cli;
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    name += " " + command->get_name();
  }
  return {name, command};
}

// Returns the message for a text that is not the number that its option accepts. CLI11's own, "Could not convert: NAME
// = TEXT", does not tell what the option accepts.
std::string inWords(const CLI::ConversionError& error, const CLI::App& cli) {
  const std::string sentence = error.what();
  const size_t colon = sentence.find(": "), equals = sentence.find(" = ");
  if (colon == sentence.npos || equals == sentence.npos) return sentence;
  const std::string name = sentence.substr(colon + 2, equals - colon - 2), text = sentence.substr(equals + 3);
  const CLI::Option* option = commandOf(cli).second->get_option_no_throw(name);
  const std::string type = option ? option->get_type_name() : "";
  const char* numbers = type.starts_with("UINT")  ? "a whole number of at least 0"
                        : type.starts_with("INT") ? "a whole number"
                                                  : "a number";
  return fmt::format("{} takes {}, not \"{}\"", name, numbers, shortened(text));
}

// Returns CLI11's message, with repeated arguments shortened if they are too long to read.
std::string inWords(const CLI::ParseError& error, const CLI::App& cli, int argc, char** argv) {
  if (const auto* conversion = dynamic_cast<const CLI::ConversionError*>(&error)) return inWords(*conversion, cli);
  std::string sentence = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error)) {
    // CLI11's own message lists them backwards.
    const std::vector<std::string> extras = cli.remaining(true);
    sentence = fmt::format("The following argument{} not expected: {}", extras.size() > 1 ? "s were" : " was",
                           fmt::join(extras, " "));
  }
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i], value = argument.substr(argument.find('=') + 1);
    for (const std::string& text : {argument, value})
      if (const size_t at = sentence.find(text); at != std::string::npos)
        sentence.replace(at, text.size(), shortened(text));
  }
  return sentence;
}

// Returns the options of a command and of all its subcommands.
std::vector<CLI::Option*> allOptions(CLI::App& command) {
  std::vector<CLI::Option*> all = command.get_options();
  for (CLI::App* below : command.get_subcommands(nullptr)) {
    const std::vector<CLI::Option*> options = allOptions(*below);
    all.insert(all.end(), options.begin(), options.end());
  }
  return all;
}

// Makes every value exactly one word of the command line. By default CLI11 splits "[a,b]" at its commas, and reads
// words after an option's value as more values.
void keepValuesWhole(CLI::App& cli) {
  for (CLI::Option* option : allOptions(cli)) option->allow_extra_args(false);
}

// Rejects empty values: they come from unset shell variables and do not request the default. Some options have a better
// message of their own.
void rejectEmptyValues(CLI::App& cli) {
  const CLI::Validator check(
      [](const std::string& value) { return value.empty() ? "its value is empty" : std::string(); }, "");
  for (CLI::Option* option : allOptions(cli))
    if (option->get_items_expected_min() > 0 && !option->check_name("--out") && !option->check_name("--device"))
      option->check(check);
}

// Makes every number that CLI11 converts a finite decimal one, as in the table of options. CLI11 itself reads 010 as 8,
// and accepts 0x10, " 10", inf and nan.
void acceptOnlyDecimals(CLI::App& cli) {
  for (CLI::Option* option : allOptions(cli)) {
    const std::string type = option->get_type_name(), number = type.substr(0, type.find(':'));
    const bool isWhole = number == "UINT" || number == "INT";
    if (!isWhole && number != "FLOAT") continue;
    option->transform(CLI::Validator(
        [option, isWhole](std::string& text) {
          const std::optional<int64_t> whole = parseNumber<int64_t>(text);
          if (isWhole ? !whole : !parseNumber<double>(text))
            throw CLI::ConversionError(option->get_name(), std::vector<std::string>{text});
          if (isWhole) text = std::to_string(*whole);
          return std::string();
        },
        ""));
  }
}

int parseAndRun(int argc, char** argv) {
  CLI::App cli{"Latelight: a deferred renderer that needs no display, no graphics pipeline and no particular GPU."};
  cli.name("latelight");
  cli.set_version_flag("--version", std::string("latelight ") + version());
  cli.require_subcommand(0, 1);  // a better message than "a subcommand is required" follows below
  cli.get_formatter()->column_width(34);
  app::addQuietFlag(cli);
  cli.fallthrough();
  app::addRenderCommand(cli);
  app::addBatchCommand(cli);
  app::addViewCommand(cli);
  app::addListCommand(cli);
  app::addDevicesCommand(cli);
  app::addDoctorCommand(cli);
  app::addCompareCommand(cli);
  app::addExportCommand(cli);
  app::addStudyCommand(cli);
  app::addServeCommand(cli);
  app::addBenchCommand(cli);
  app::addReportCommand(cli);
  app::addCompletionsCommand(cli);
  app::addManCommand(cli);
  if (argc > 2 && argv[1] == std::string_view("complete") && argv[2] == std::string_view("--")) {
    app::printCompletions(cli, std::vector<std::string>(argv + 3, argv + argc));
    return 0;
  }
  keepValuesWhole(cli);
  rejectEmptyValues(cli);
  acceptOnlyDecimals(cli);
  checkDashes(cli, argc, argv);
  try {
    cli.parse(argc, argv);
  } catch (const CLI::Success& request) {  // --help, --version
    return cli.exit(request);
  } catch (const CLI::ParseError& error) {
    const std::string advice =
        cli.get_subcommands().empty() ? commandNames(cli) : fmt::format("see {} --help", commandOf(cli).first);
    complain(fmt::format("{} ({})", inWords(error, cli, argc, argv), advice));
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
    complain(error.what());
    return static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    return outOfMemory();
  } catch (const std::length_error&) {  // larger than any machine's memory
    return outOfMemory();
  } catch (const std::exception& error) {
    if (std::ferror(stdout)) return static_cast<int>(ExitCode::Usage);  // main() reports it
    complain(fmt::format("internal error: {}", error.what()));
    return static_cast<int>(ExitCode::Internal);
  }
}

// Opens closed standard streams, because otherwise the first opened file would get their descriptor, and output would
// go there. The access mode is wrong on purpose, so that the stream still fails like a closed one.
void holdStandardStreams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(stream, F_GETFD) < 0 && errno == EBADF) open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

// Returns true if the reader of standard output has closed it, as `head` does after a few lines.
bool readerLeft() {
  pollfd output{.fd = STDOUT_FILENO, .events = POLLOUT, .revents = 0};
  return poll(&output, 1, 0) > 0 && (output.revents & POLLERR);
}

}  // namespace

int main(int argc, char** argv) {
  holdStandardStreams();
  // A file that reaches the size limit, or a pipe without a reader, must fail in write() instead of ending the process.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  otherwise = std::set_terminate(endWithoutMemory);
  handleFatalSignals();
  showProgress(true);
  const int code = run(argc, argv);
  // Text is written when its buffer is flushed, so a full disk may only be reported here.
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return code;
  if (readerLeft()) {  // end silently by the signal, as is usual
    std::signal(SIGPIPE, SIG_DFL);
    std::raise(SIGPIPE);
  }
  complain("can't write to standard output; free some space, or send it elsewhere");
  return static_cast<int>(ExitCode::Usage);
}
