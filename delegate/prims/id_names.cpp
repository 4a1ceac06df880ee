#include "delegate/prims/id_names.h"

#include <algorithm>

#include "core/diagnostics/plain_format.h"
#include "core/digest/cryptomatte_hash.h"

namespace alabaster::hd::prims {
namespace {

std::string asset_of(const std::string& path) {
  const size_t first = path.find('/', 1);
  if (first == std::string::npos) return path;
  const size_t second = path.find('/', first + 1);
  return path.substr(0, second == std::string::npos ? first : second);
}

// Gives things their names in the place of their paths, where these are not shared.
void rename(const Translation& translation, NamesById* names) {
  std::map<std::string, Token> names_of_paths;
  for (const auto& [path, name] : translation.display_names) names_of_paths[path.str()] = name;
  std::map<Token, size_t> count;
  for (const auto& [id, path] : *names)
    if (const auto found = names_of_paths.find(path); found != names_of_paths.end()) ++count[found->second];
  for (auto& [id, name] : *names)
    if (const auto found = names_of_paths.find(name); found != names_of_paths.end() && count[found->second] == 1)
      name = found->second.str();
}

// Of an AOV of ids, by the numbers that films count.
NamesById matte_names(const IdNames& names, Aov aov) {
  if (aov == Aov::crypto_material) return names.materials;
  NamesById all = aov == Aov::crypto_asset ? names.assets : names.prims;
  if (aov == Aov::crypto_object)
    for (const auto& [id, name] : names.objects) all[id] = name;
  if (!names.mattes) return all;
  for (const auto& [id, count] : names.instances) {
    const auto own = all.extract(id);
    if (!own) continue;
    for (uint32_t i = 0; i < count; ++i)
      all[(*names.mattes)[static_cast<size_t>(id)] + static_cast<int32_t>(i)] =
          aov == Aov::crypto_object ? own.mapped() + "." + std::to_string(i) : own.mapped();
  }
  return all;
}

std::vector<uint32_t> hashes(const NamesById& names) {
  std::vector<uint32_t> all(names.empty() ? 0 : static_cast<size_t>(names.rbegin()->first) + 1);
  for (const auto& [id, name] : names) all[static_cast<size_t>(id)] = cryptomatte_hash(name);
  return all;
}

Value table_of(const NamesById& names) {
  auto table = std::make_shared<Dictionary>();
  for (const auto& [id, name] : names) (*table)[std::to_string(id)] = name;
  return table;
}

Value manifest_of(const NamesById& names) {
  auto manifest = std::make_shared<Dictionary>();
  for (const auto& [id, name] : names) (*manifest)[name] = plain_format("%08x", cryptomatte_hash(name));
  return manifest;
}

}  // namespace

IdNames name_ids(const Translation& translation) {
  IdNames names;
  std::map<std::string, std::vector<const DisneyMaterial*>> materials;  // several may be the default
  const auto add = [&](const InstanceDescription& instance) {
    names.prims.try_emplace(instance.prim_id, instance.name);
    for (const auto& material : instance.materials) {
      auto& of_name = materials[material->name];
      if (std::find(of_name.begin(), of_name.end(), material.get()) == of_name.end()) of_name.push_back(material.get());
    }
  };
  for (const InstanceDescription& instance : translation.scene.instances) add(instance);
  for (const InstanceArrayDescription& array : translation.scene.arrays) add(array.look);
  for (const auto& [id, path] : names.prims) names.assets[id] = asset_of(path);
  for (const MatteNames& mattes : translation.scene.mattes) {
    if (!mattes.object.empty()) names.objects[mattes.prim_id] = mattes.object;
    if (!mattes.asset.empty()) names.assets[mattes.prim_id] = mattes.asset;
    if (mattes.instances > 0) names.instances[mattes.prim_id] = mattes.instances;
  }

  std::vector<std::pair<const DisneyMaterial*, int32_t>> by_address;
  int32_t number = 0;
  for (const auto& [path, of_name] : materials) {
    for (const DisneyMaterial* material : of_name) by_address.emplace_back(material, number);
    names.materials[number++] = path;
  }
  std::sort(by_address.begin(), by_address.end(),
            [](const auto& a, const auto& b) { return std::less<>()(a.first, b.first); });
  names.numbers = std::make_shared<const std::vector<std::pair<const DisneyMaterial*, int32_t>>>(std::move(by_address));
  rename(translation, &names.prims);
  rename(translation, &names.materials);
  number_mattes(&names);
  return names;
}

void number_mattes(IdNames* names) {
  if (!names->instances.empty() && !names->prims.empty()) {
    int32_t next = names->prims.rbegin()->first + 1;
    std::vector<int32_t> first(static_cast<size_t>(next), -1);
    for (const auto& [id, count] : names->instances) {
      if (!names->prims.contains(id)) continue;
      first[static_cast<size_t>(id)] = next;
      next += static_cast<int32_t>(count);
    }
    names->mattes = std::make_shared<const std::vector<int32_t>>(std::move(first));
  }
  const auto keys = [&](Aov aov) { return hashes(matte_names(*names, aov)); };
  names->keys = std::make_shared<const IdKeys>(
      IdKeys{keys(Aov::crypto_object), keys(Aov::crypto_asset), keys(Aov::crypto_material)});
}

Dictionary describe_names(const IdNames& names) {
  Dictionary all;
  all[aov_info(Aov::prim_id).name] = table_of(names.prims);
  all[aov_info(Aov::material_id).name] = table_of(names.materials);
  for (const AovInfo& aov : kAovs)
    if (aov.source == AovSource::ids) all[aov.name] = manifest_of(matte_names(names, aov.aov));
  return all;
}

}  // namespace alabaster::hd::prims
