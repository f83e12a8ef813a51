#include "data/formats/names.h"

#include <algorithm>
#include <iterator>

namespace latelight::data {

namespace {

// White space beyond ASCII, as in Unicode's property White_Space.
constexpr std::string_view kWhiteSpace[] = {"\u0085", "\u00a0", "\u1680", "\u2000", "\u2001", "\u2002", "\u2003",
                                            "\u2004", "\u2005", "\u2006", "\u2007", "\u2008", "\u2009", "\u200a",
                                            "\u2028", "\u2029", "\u202f", "\u205f", "\u3000"};

}  // namespace

std::string asWord(std::string_view name) {
  std::string word;
  while (!name.empty()) {
    const auto* const space = std::ranges::find_if(kWhiteSpace, [&](auto text) { return name.starts_with(text); });
    const bool isSpace = space != std::end(kWhiteSpace);
    const auto first = static_cast<unsigned char>(name.front());
    word += isSpace || first <= 0x20 || first == 0x7f ? '_' : name.front();
    name.remove_prefix(isSpace ? space->size() : 1);
  }
  return word;
}

std::string nameOf(const output::IdEntry& entry) {
  return output::pathOf(entry.node, entry.copy);
}

}  // namespace latelight::data
