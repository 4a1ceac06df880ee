// The names of what AOVs number: primId, materialId and Cryptomatte's layers.
#pragma once

#include "core/film/id_counts.h"
#include "delegate/prims/scene_translation.h"

namespace alabaster::hd::prims {

/// By primId or materialId.
using NamesById = std::map<int32_t, std::string>;

/// A mesh or material has the name that its file gives it (SceneDelegate::GetDisplayName), where no other that is drawn
/// has the same; else its path. Materials are numbered in the order of their paths. The asset of a mesh is the first
/// two words of its path, or the first of two. In Cryptomatte's layers a mesh may have other names.
struct IdNames {
  NamesById prims, assets, materials;
  NamesById objects;                      // of mattes, by primId: those that are not the prim's
  std::map<int32_t, uint32_t> instances;  // that have a matte each, by primId: how many
  std::vector<std::string> light_groups;  // of a checkpoint, by their planes
  MaterialNumbers numbers;                // null: of no scene
  InstanceMattes mattes;                  // of `instances`
  std::shared_ptr<const IdKeys> keys;
};

IdNames name_ids(const Translation& translation);
/// Sets `mattes` and `keys` by the others.
void number_mattes(IdNames* names);
/// {"primId": {"0": name}, "materialId": the same, "cryptoObject": {name: 8 hexadecimal digits}, ...}: the answer to
/// command "names".
Dictionary describe_names(const IdNames& names);

}  // namespace alabaster::hd::prims
