// `latelight completions`: prints shell scripts that ask the program for completions at the cursor.
#include <fmt/core.h>

#include <array>
#include <string_view>

#include "app/commands.h"

namespace latelight::app {

namespace {

// Readline treats the text after a colon or an equals sign as a word of its own, so the text before it is removed.
constexpr std::string_view kBash = R"(_latelight() {
  local line=${COMP_LINE:0:COMP_POINT} words word files=
  read -ra words <<<"$line"
  [[ $line == *[[:space:]] ]] && words+=("")
  local begun=${words[-1]}
  local kept=${begun%"${begun##*[:=]}"}
  COMPREPLY=()
  while IFS=$'\t' read -r word _; do
    if [[ $word == :files ]]; then files=1; else COMPREPLY+=("${word#"$kept"}"); fi
  done < <("${words[0]}" complete -- "${words[@]:1}" 2>/dev/null)
  if [[ $files ]]; then
    local option=
    [[ $begun == --*=* ]] && option=${begun%%=*}=
    compopt -o filenames
    while read -r word; do
      word=$option$word
      COMPREPLY+=("${word#"$kept"}")
    done < <(compgen -f -- "${begun#"$option"}")
  fi
}
complete -F _latelight latelight
)";

constexpr std::string_view kZsh = R"(#compdef latelight
_latelight() {
  local line files=
  local -a names
  for line in "${(@f)$("${words[1]}" complete -- "${(@)words[2,CURRENT]}" 2>/dev/null)}"; do
    if [[ $line == :files ]]; then
      files=1
    elif [[ -n $line ]]; then
      names+=("${${line%%$'\t'*}//:/\\:}:${line#*$'\t'}")
    fi
  done
  (( $#names )) && _describe 'latelight' names
  [[ -n $files ]] && { [[ $PREFIX == --*=* ]] && compset -P '*='; _files }
}
if [[ $funcstack[1] == _latelight ]]; then _latelight "$@"; else compdef _latelight latelight; fi
)";

constexpr std::string_view kFish = R"(function __latelight_complete
  set -l words (commandline -opc)
  set -l begun (commandline -ct)
  for line in ($words[1] complete -- $words[2..-1] "$begun" 2>/dev/null)
    if test "$line" = :files
      set -l option (string match -r -- '^--[^=]*=' "$begun")
      for path in (__fish_complete_path (string replace -r -- '^--[^=]*=' '' "$begun"))
        echo "$option$path"
      end
    else
      echo $line
    end
  end
end
complete -c latelight -f -a '(__latelight_complete)'
)";

struct Shell {
  std::string_view name, script;
};
constexpr std::array kShells{Shell{"bash", kBash}, Shell{"zsh", kZsh}, Shell{"fish", kFish}};

}  // namespace

std::vector<std::string_view> completionShells() {
  std::vector<std::string_view> names;
  for (const Shell& shell : kShells) names.push_back(shell.name);
  return names;
}

namespace {

void printScript(const std::string& name) {
  for (const Shell& shell : kShells)
    if (shell.name == name) return fmt::print("{}", shell.script);
  badUsage("there are completions for bash, zsh and fish, not for \"{}\"", name);
}

}  // namespace

void addCompletionsCommand(CLI::App& app) {
  CLI::App* scripts = app.add_subcommand("completions", "Print a completion script for bash, zsh or fish");
  auto shell = std::make_shared<std::string>();
  scripts->add_option("SHELL", *shell, "bash, zsh or fish")->required();
  scripts->callback([shell] { printScript(*shell); });
}

}  // namespace latelight::app
