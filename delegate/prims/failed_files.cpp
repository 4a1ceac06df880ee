#include "delegate/prims/failed_files.h"

#include "core/texture/udim.h"
#include "delegate/prims/scene_param.h"

namespace alabaster::hd::prims {

FileState state_of(const TextureSource& source) {
  FileState state;
  if (source.bytes) return state;
  const auto add = [&](const std::string& file) {
    std::error_code error;
    const auto written = std::filesystem::last_write_time(file, error);
    const auto size = std::filesystem::file_size(file, error);
    state.emplace_back(written, size);
  };
  if (source.may_be_set)
    for (const UdimTile& tile : udim_tiles(source.path)) add(tile.path);
  if (state.empty()) add(source.path);
  return state;
}

void FailedFiles::keep(const TextureSource& source, FileState state, Failure failure) {
  const std::lock_guard lock(mutex_);
  std::erase_if(kept_, [&](const auto& entry) {
    return entry.second.is_in_memory ? entry.second.bytes.expired() : !source.bytes && entry.first == source.path;
  });
  kept_.emplace(source.path,
                Kept{source.bytes, source.bytes != nullptr, source.within, std::move(state), std::move(failure)});
}

std::optional<FailedFiles::Failure> FailedFiles::find(const TextureSource& source) const {
  const std::lock_guard lock(mutex_);
  const auto [first, last] = kept_.equal_range(source.path);
  for (auto it = first; it != last; ++it) {
    const Kept& kept = it->second;
    const bool is_same = source.bytes ? kept.bytes.lock() == source.bytes : !kept.is_in_memory;
    if (is_same && kept.within == source.within && kept.state == state_of(source)) return kept.failure;
  }
  return std::nullopt;
}

void FailedFiles::forget(const std::string& file) {
  const std::lock_guard lock(mutex_);
  std::erase_if(kept_, [&](const auto& entry) { return names_image(entry.first, file); });
}

}  // namespace alabaster::hd::prims
