#include "core/session/render_state.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <type_traits>

namespace alabaster {
namespace {

// Thirty years: clocks of nanoseconds hold some multiples of it. No checkpoint holds more.
constexpr double kMostSeconds = 1e9;

/// The first block: all that is not per pixel.
struct Head {
  PixelRect window;
  AovSet aovs = 0;
  SampleRange range, round;
  uint32_t rays = 0, ended = 0, kept = 0, has_rates = 0, has_nonfinite = 0, light_groups = 0, unused = 0;
  SampleAddress first_nonfinite;
  double wall_seconds = 0, cpu_seconds = 0, max_walk_weight = 0, walk_lost_energy = 0;
  std::array<uint64_t, std::size(kCounters)> counters = {};
  decltype(RenderCounters::nonfinite_causes) nonfinite_causes = {};
};
static_assert(std::is_trivially_copyable_v<Head> &&
              sizeof(Head) == 16 + 8 + 16 + 28 + 12 + 32 + 8 * (std::size(kCounters) + std::size(kNonfiniteCauses)));

std::span<std::byte> bytes_of(Head& head) {
  return std::as_writable_bytes(std::span(&head, 1));
}

Head head_of(const RenderState& state) {
  const Film& film = *state.film;
  Head head;
  head.window = film.data_window();
  head.aovs = film.aovs(), head.rays = film.extras().rays;
  head.light_groups = static_cast<uint32_t>(film.extras().light_groups);
  head.range = film.extras().range, head.round = state.round;
  head.ended = state.stopping.ended(), head.kept = state.stopping.kept_film() ? state.stopping.kept() : 0;
  head.has_rates = !state.allocation.rates().empty();
  const RenderCounters& counters = state.counters;
  head.has_nonfinite = counters.first_nonfinite.has_value();
  head.first_nonfinite = counters.first_nonfinite.value_or(SampleAddress());
  head.wall_seconds = std::min(state.wall_seconds, kMostSeconds), head.cpu_seconds = state.cpu_seconds;
  head.max_walk_weight = counters.max_walk_weight, head.walk_lost_energy = counters.walk_lost_energy;
  for (size_t i = 0; i < std::size(kCounters); ++i) head.counters[i] = counters.*kCounters[i].member;
  head.nonfinite_causes = counters.nonfinite_causes;
  return head;
}

RenderCounters counters_of(const Head& head) {
  RenderCounters counters;
  for (size_t i = 0; i < std::size(kCounters); ++i) counters.*kCounters[i].member = head.counters[i];
  counters.nonfinite_causes = head.nonfinite_causes;
  counters.max_walk_weight = head.max_walk_weight, counters.walk_lost_energy = head.walk_lost_energy;
  if (head.has_nonfinite) counters.first_nonfinite = head.first_nonfinite;
  return counters;
}

bool is_valid(const Head& head) {
  constexpr int kMostSide = 1 << 20, kLimit = 1 << 24;
  const PixelRect& w = head.window;
  for (const int edge : {w.x0, w.y0, w.x1, w.y1})
    if (edge < -kLimit || edge > kLimit) return false;
  const auto in_order = [](const SampleRange& range) { return range.begin <= range.end; };
  return !w.empty() && w.width() <= kMostSide && w.height() <= kMostSide && head.rays <= 1 && in_order(head.range) &&
         in_order(head.round) && head.ended <= kAllPixelGroups && (head.kept & ~head.ended) == 0 &&
         head.has_rates <= 1 && head.has_nonfinite <= 1 && head.light_groups <= kMostLightGroups &&
         head.wall_seconds >= 0 && head.wall_seconds <= kMostSeconds && head.cpu_seconds >= 0 &&
         std::isfinite(head.cpu_seconds);
}

FilmExtras extras_of(const Head& head) {
  return {head.rays != 0, head.range, head.light_groups};
}

bool read_head(const BlockSource& source, Head* head) {
  std::vector<std::byte> block;
  if (!source(sizeof(Head), &block) || block.size() != sizeof(Head)) return false;
  std::memcpy(bytes_of(*head).data(), block.data(), block.size());
  return is_valid(*head);
}

// `exchanged`: the groups whose pixels `other` holds in the place of `film`; then it is not null.
bool write_film(const Film& film, const Film* other, uint32_t exchanged, const BlockSink& sink) {
  std::vector<std::byte> block;
  for (int t = 0; t < film.tile_count(); ++t) {
    FilmTile tile = film.load_tile(t);
    if (exchanged) {
      FilmTile of_other = other->load_tile(t);
      exchange_groups(film.tile_rect(t), exchanged, &tile, &of_other);
    }
    block.clear();
    for (const auto& plane : tile.planes()) block.insert(block.end(), plane.begin(), plane.end());
    if (!sink(block)) return false;
    for (const IdCounts* ids : tile.ids())
      if (!sink(ids->write())) return false;
  }
  return true;
}

size_t pixels_of(const PixelRect& rect) {
  return static_cast<size_t>(rect.width()) * static_cast<size_t>(rect.height());
}

bool read_tile(const BlockSource& source, FilmTile* tile) {
  const auto planes = tile->planes();
  size_t size = 0;
  for (const auto& plane : planes) size += plane.size();
  std::vector<std::byte> block;
  if (!source(size, &block) || block.size() != size) return false;
  const std::byte* at = block.data();
  for (const auto& plane : planes) {
    std::memcpy(plane.data(), at, plane.size());
    at += plane.size();
  }
  if (!tile->accept_planes()) return false;
  for (IdCounts* ids : tile->ids())
    if (!source(IdCounts::most_bytes(tile->samples()), &block) || !ids->read(block, tile->samples())) return false;
  return true;
}

// True if each pixel has all samples of the range.
bool has_samples(const FilmTile& tile, size_t pixels, const SampleRange& range) {
  for (size_t pixel = 0; pixel < pixels; ++pixel)
    if (tile.samples(pixel) != range.end - range.begin) return false;
  return true;
}

std::shared_ptr<Film> read_film(const BlockSource& source, const Head& head) {
  const FilmExtras extras = extras_of(head);
  auto film = std::make_shared<Film>(head.window, head.aovs, extras);
  for (int t = 0; t < film->tile_count(); ++t) {
    FilmTile tile(pixels_of(film->tile_rect(t)), head.aovs, extras);
    if (!read_tile(source, &tile)) return nullptr;
    if (tile.most_samples() > 0) film->store_tile(t, tile);
  }
  return film;
}

bool read_rates(const BlockSource& source, const Head& head, std::vector<float>* rates) {
  const size_t size = pixels_of(head.window) * sizeof(float);
  std::vector<std::byte> block;
  if (!source(size, &block) || block.size() != size) return false;
  rates->resize(pixels_of(head.window));
  std::memcpy(rates->data(), block.data(), size);
  return std::all_of(rates->begin(), rates->end(),
                     [](float rate) { return rate >= kLeastSampleRate && rate <= kLargestSampleRate; });
}

}  // namespace

bool write_state(const RenderState& state, const BlockSink& sink) {
  Head head = head_of(state);
  if (!sink(bytes_of(head))) return false;
  if (head.has_rates && !sink(std::as_bytes(std::span(state.allocation.rates())))) return false;
  const Film& film = *state.film;
  const Film* const kept = head.kept ? state.stopping.kept_film().get() : nullptr;
  const uint32_t exchanged = state.stopping.shows_ended() ? head.kept : 0;
  return write_film(film, kept, exchanged, sink) && (!kept || write_film(*kept, &film, exchanged, sink));
}

bool read_state(const BlockSource& source, const MemoryBudget& memory, RenderState* state) {
  Head head;
  if (!read_head(source, &head)) return false;
  const size_t films = head.kept ? 2 : 1;
  if (const size_t bytes = films * film_bytes(head.window, head.aovs, extras_of(head)); bytes > memory.left())
    throw MemoryRefused(memory.refusal(MemoryUse::frames, bytes,
                                       "a checkpoint of " + std::to_string(head.window.width()) + " x " +
                                           std::to_string(head.window.height()) + " pixels"));
  std::vector<float> rates;
  if (head.has_rates && !read_rates(source, head, &rates)) return false;
  state->film = read_film(source, head);
  if (!state->film) return false;
  std::shared_ptr<Film> kept = head.kept ? read_film(source, head) : nullptr;
  if (head.kept && !kept) return false;
  state->round = head.round;
  state->allocation = SampleAllocation(std::move(rates));
  state->stopping.restore(head.ended, head.kept, std::move(kept));
  state->counters = counters_of(head);
  state->wall_seconds = head.wall_seconds, state->cpu_seconds = head.cpu_seconds;
  return true;
}

bool append_state(const BlockSource& source, RenderState* to) {
  Head head;
  Film& film = *to->film;
  if (!read_head(source, &head) || head.window != film.data_window() || head.aovs != film.aovs() || head.has_rates ||
      head.rays || head.kept || head.light_groups != film.extras().light_groups)
    return false;
  for (int t = 0; t < film.tile_count(); ++t) {
    const size_t pixels = pixels_of(film.tile_rect(t));
    FilmTile next(pixels, head.aovs, extras_of(head)), tile = film.load_tile(t);
    if (!read_tile(source, &next) || !has_samples(next, pixels, head.range) ||
        !has_samples(tile, pixels, {0, head.range.begin}))
      return false;
    tile.append(next);
    film.store_tile(t, tile);
  }
  to->counters.add(counters_of(head));
  to->wall_seconds = std::min(to->wall_seconds + head.wall_seconds, kMostSeconds), to->cpu_seconds += head.cpu_seconds;
  return true;
}

}  // namespace alabaster
