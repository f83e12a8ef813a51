// `latelight man`: prints the manual page in roff from the commands' own descriptions.
#include <fmt/core.h>
#include <latelight/latelight.h>

#include <string>

#include "app/commands.h"

namespace latelight::app {

namespace {

// Escapes text for roff: a backslash begins an escape, a plain dash cannot be searched for, and a line that begins with
// a period or an apostrophe would be a request.
std::string inRoff(const std::string& text) {
  std::string roff;
  for (const char c : text) {
    if (c == '\\')
      roff += "\\e";
    else if (c == '-')
      roff += "\\-";
    else
      roff += c;
  }
  return roff.starts_with('.') || roff.starts_with('\'') ? "\\&" + roff : roff;
}

std::string invocationOf(const CLI::Option& option) {
  std::string text;
  for (const char c : inRoff(option.get_name(option.get_positional(), true)))
    text += c == ',' ? "\\fR, \\fB" : std::string(1, c);
  text = "\\fB" + text + "\\fR";
  if (option.get_items_expected_max() > 0 && !option.get_positional())
    text += " \\fI" + inRoff(option.get_type_name()) + "\\fR";
  if (!option.get_default_str().empty()) text += " (" + inRoff(option.get_default_str()) + ")";
  return text;
}

void printOptions(const CLI::App& command) {
  std::string group = "Options";
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_group().empty() || option->get_name() == "--help") continue;
    if (!option->get_positional() && option->get_group() != group) {
      group = option->get_group();
      fmt::print(".PP\n{}:\n", inRoff(group));
    }
    fmt::print(".TP\n{}\n{}\n", invocationOf(*option), inRoff(option->get_description()));
  }
}

std::string usageOf(const CLI::App& command, const std::string& name) {
  std::string usage = fmt::format("\\fB{}\\fR", inRoff(name));
  for (const CLI::Option* option : command.get_options([](const CLI::Option* o) { return o->get_positional(); })) {
    const std::string word = "\\fI" + inRoff(option->get_name(true)) + "\\fR";
    usage += option->get_required() ? " " + word : " [" + word + "]";
  }
  return usage + " [\\fIoptions\\fR]";
}

// Prints a command and its subcommands.
void printCommand(const CLI::App& command, const std::string& name) {
  if (command.get_group().empty()) return;
  const auto below = command.get_subcommands([](const CLI::App*) { return true; });
  fmt::print(".SS {}\n{}\n.PP\n{}.\n", inRoff(name.substr(name.find(' ') + 1)), usageOf(command, name),
             inRoff(command.get_description()));
  printOptions(command);
  for (const CLI::App* each : below) printCommand(*each, name + " " + each->get_name());
}

struct Ending {
  int code;
  const char* words;
};
constexpr Ending kEndings[] = {
    {0, "Done."},
    {1, "An internal error; for compare, the images differ."},
    {2, "An invalid argument, or a file that cannot be written."},
    {3, "A file that is missing, broken, or requires an unsupported feature."},
    {4, "No suitable Vulkan 1.3 device."},
    {5, "The device was lost."},
    {6, "Some frames failed; the others are complete."},
    {7, "Out of memory, or beyond a limit of the device."},
};

void printPage(const CLI::App& cli) {
  fmt::print(".TH LATELIGHT 1 \"\" \"latelight {}\" \"User Commands\"\n", version());
  fmt::print(".SH NAME\nlatelight \\- a deferred renderer that needs no display\n");
  fmt::print(".SH SYNOPSIS\n\\fBlatelight\\fR \\fIcommand\\fR [\\fIoptions\\fR]\n");
  fmt::print(
      ".SH DESCRIPTION\n{}\nIt renders a scene to a G\\-buffer and lights an image from it, and it outputs every "
      "per\\-pixel value as exact data.\n",
      inRoff(cli.get_description()));
  fmt::print(".SH OPTIONS\n");
  printOptions(cli);
  fmt::print(".SH COMMANDS\n");
  for (const CLI::App* command : cli.get_subcommands([](const CLI::App*) { return true; }))
    printCommand(*command, "latelight " + command->get_name());
  fmt::print(".SH EXIT STATUS\n");
  for (const Ending& ending : kEndings) fmt::print(".TP\n\\fB{}\\fR\n{}\n", ending.code, inRoff(ending.words));
}

}  // namespace

void addManCommand(CLI::App& app) {
  app.add_subcommand("man", "Print the manual page, for man -l -")->callback([&app] { printPage(app); });
}

}  // namespace latelight::app
