// Types of fields by name, from the tables.
#include "delegate/host/open_fields.h"

namespace alabaster::hd::host {
namespace {

template <class T, class Member>
FieldType type_of_member(Member T::*) {
  if (std::is_same_v<Member, Rgb>) return {ALABASTER_FLOAT3, false};
  if (std::is_same_v<Member, uint32_t>) return {ALABASTER_UINT, false};
  return kFieldType<Member>;
}

using Found = std::optional<FieldType>;

template <class Rows>
Found find_parameter(const Rows& rows, std::span<const OtherParameter> others, const std::string& name) {
  for (const auto& row : rows)
    if (name == row.name) return std::visit([](auto member) { return type_of_member(member); }, row.member);
  for (const OtherParameter& row : others)
    if (name == row.name) return row.type;
  return std::nullopt;
}

constexpr const char* kCapitals = "ABCDEFGHIJKLMNOPQRSTUVWXYZ";

/// `name` is that of the row, with any text in the place of its part in capitals. Rows with two such parts have no
/// name.
bool is_of(const Field& row, const std::string& name) {
  const std::string_view pattern = row.name;
  if (!is_pattern(pattern)) return false;
  const size_t begin = pattern.find_first_of(kCapitals), end = pattern.find_first_not_of(kCapitals, begin);
  const std::string_view before = pattern.substr(0, begin);
  const std::string_view after = end == std::string_view::npos ? "" : pattern.substr(end);
  return name.size() > before.size() + after.size() && name.starts_with(before) && name.ends_with(after);
}

Found find_field(const Kind& kind, const std::string& name) {
  for (const auto& table : {kind.fields, kind.open})
    for (const Field& row : table)
      if (name == row.name) return row.type;
  Found found;
  const std::string parameter = std::string_view(kind.parameters) == "lights" ? without_inputs_namespace(name) : name;
  if (!kind.fields.empty())  // parameters of materials are those of nodes
    visit_table(kind.parameters,
                [&](const auto& rows, const auto&, auto others) { found = find_parameter(rows, others, parameter); });
  if (found) return found;
  for (const Field& row : kind.open)
    if (row.type.type != ALABASTER_NONE && is_of(row, name)) return row.type;
  return std::nullopt;
}

}  // namespace

bool is_pattern(std::string_view name) {
  const size_t begin = name.find_first_of(kCapitals);
  return begin != std::string_view::npos && (begin == 0 || name[begin - 1] == ':');
}

FieldType TypeOfField(const Token& kind, const std::string& name) {
  const std::string wanted = kind.str().ends_with("Light") ? "light" : kind.str();
  Found all;
  for (const Kind& one : kinds()) {
    if (!wanted.empty() && wanted != one.name) continue;
    const Found found = find_field(one, name);
    if (!found) continue;
    if (all && !(*all == *found)) return {};
    all = found;
  }
  return all.value_or(FieldType());
}

}  // namespace alabaster::hd::host
