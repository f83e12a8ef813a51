// The public API's lists of options and outputs.
#include <latelight/latelight.h>

#include "output/aov.h"
#include "render/options/options.h"

namespace latelight {

namespace {

OptionInfo publicOption(const render::Option& from) {
  OptionInfo out{from.group,        from.name,   from.member, from.help, from.unit, render::rangeText(from),
                 from.defaultValue, from.without};
  for (const render::NamedOption& name : from.names) out.names.push_back({name.name, name.description});
  out.anyText = from.kind == render::OptionKind::Text;
  return out;
}

}  // namespace

std::vector<OptionInfo> optionInfos() {
  std::vector<OptionInfo> all;
  for (const render::Option& option : render::options()) all.push_back(publicOption(option));
  return all;
}

std::vector<OutputInfo> outputInfos() {
  std::vector<OutputInfo> all;
  for (const output::AovInfo& aov : output::aovs())
    all.push_back({std::string(aov.name), std::string(aov.description), std::string(aov.unit), aov.channels,
                   output::holdsIntegers(aov.aov)});
  return all;
}

}  // namespace latelight
