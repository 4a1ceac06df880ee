#include "delegate/host/light_paths.h"

#include <algorithm>
#include <string_view>

#include "core/film/aov.h"
#include "delegate/host/product_writer.h"

namespace alabaster::hd::host {
namespace {

constexpr std::string_view kPrefix = "lpe:";

// The table of delegate/manual/pipeline.md. "[LO]" stands for RenderMan's "[<L.>O]", and "L" for "<L.>".
constexpr struct {
  const char *expression, *aov;
} kPresets[] = {
    {"C.*", "color"},
    {"C.*[LO]", "color"},
    {"C[DS]*[LO]", "color"},
    {"C[LO]", "emission"},
    {"C<RD>.*", "diffuse"},
    {"C<RD>.*[LO]", "diffuse"},
    {"C<RD>[DS]*[LO]", "diffuse"},
    {"C<RD>L", "directDiffuse"},
    {"C<RD>[LO]", "directDiffuse"},
    {"C<RD>.+[LO]", "indirectDiffuse"},
    {"C<RD>[DS]+[LO]", "indirectDiffuse"},
    {"C<RD>[DSVOB].*", "indirectDiffuse"},
    {"C<RS>L", "directSpecular"},
    {"C<RS>[LO]", "directSpecular"},
    {"C<RS>.+[LO]", "indirectSpecular"},
    {"C<RS>[DS]+[LO]", "indirectSpecular"},
    {"C<RS>[DSVOB].*", "indirectSpecular"},
    {"C<TS>.*", "transmission"},
    {"C<TS>.*[LO]", "transmission"},
    {"C<TS>[DS]*[LO]", "transmission"},
    {"C<.S>.*", "specular"},
    {"C<.S>.*[LO]", "specular"},
    {"C<TD>.*", "subsurface"},
    {"C<TD>.*[LO]", "subsurface"},
    {"C<TD>[DS]*[LO]", "subsurface"},
    {"C<TD>L", "directSubsurface"},
    {"C<TD>[LO]", "directSubsurface"},
    {"C<TD>.+[LO]", "indirectSubsurface"},
    {"C<TD>[DS]+[LO]", "indirectSubsurface"},
    {"C<TD>[DSVOB].*", "indirectSubsurface"},
};
// Of the light of a group, all of it: then its name, and the end of it.
constexpr std::string_view kOfGroup[] = {"C.*<L.'", "C[DS]*<L.'"}, kEndOfGroup = "'>";

// As the table writes it.
std::string usual_form(std::string_view expression) {
  std::string out;
  for (size_t i = 0; i < expression.size(); ++i) {
    constexpr std::string_view kAnyLight = "<L.>";
    if (expression.substr(i).starts_with(kAnyLight))
      out += 'L', i += kAnyLight.size() - 1;
    else if (expression[i] != ' ')
      out += expression[i];
  }
  return out;
}

}  // namespace

std::string aov_of_light_paths(const std::string& name) {
  if (!name.starts_with(kPrefix)) return name;
  const std::string_view given = std::string_view(name).substr(kPrefix.size());
  for (const std::string_view begin : kOfGroup) {
    const bool is_of_group =
        given.size() > begin.size() + kEndOfGroup.size() && given.starts_with(begin) && given.ends_with(kEndOfGroup);
    if (!is_of_group) continue;
    const auto group = given.substr(begin.size(), given.size() - begin.size() - kEndOfGroup.size());
    if (group.find('\'') == group.npos) return aov_info(Aov::light_group).name + std::string(group);
  }
  const std::string expression = usual_form(given);
  for (const auto& preset : kPresets)
    if (expression == preset.expression) return preset.aov;
  return name;
}

void resolve_light_paths(std::vector<RenderVar>* vars) {
  for (RenderVar& var : *vars) {
    std::string aov = aov_of_light_paths(var.aov.str());
    if (aov == var.aov.str()) continue;
    if (var.name == var.aov.str()) var.name = aov;
    var.aov = Token(aov);
  }
}

std::string light_paths_fault(const std::string& name) {
  if (!name.starts_with(kPrefix) || aov_of_light_paths(name) != name) return {};
  return "no AOV shows the light paths '" + name.substr(kPrefix.size()) +
         "'; the expressions that are known are in the table of the manual, pipeline.md, \"Light path expressions\"";
}

}  // namespace alabaster::hd::host
