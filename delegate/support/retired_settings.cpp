#include "delegate/support/retired_settings.h"

namespace alabaster::hd::support {
namespace {

struct Retired {
  const char* name;
  const char* value;  // null: the whole setting
  const char* instead;
};

constexpr Retired kRetired[] = {
    {"rouletteDepth", nullptr, "leave it out: paths end by Russian roulette from their first bounce on"},
    {"walkWeights", nullptr, "leave it out: walks choose channels by throughput"},
    {"subsurface", "auto", "use 'walk', whose pictures and times were the same"},
    {"inversion", "vanDeHulst", "use 'exact', which obtains the albedo"},
};

}  // namespace

std::string RetiredSetting(const std::string& name, const std::string& value) {
  for (const Retired& retired : kRetired)
    if (name == retired.name && (!retired.value || value == retired.value))
      return (retired.value ? "Value '" + value + "' of setting '" + name : "Setting '" + name) +
             "' has been removed; " + retired.instead + ".";
  return {};
}

}  // namespace alabaster::hd::support
