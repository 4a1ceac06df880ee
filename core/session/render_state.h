// The state of a render, as blocks of bytes, from which a session goes on to the very bits of a render that nothing
// interrupted. Who keeps the blocks says what scene and settings they are of, and finds damage to them.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/convergence/group_stopping.h"
#include "core/convergence/sample_allocation.h"
#include "core/diagnostics/counters.h"
#include "core/film/film.h"
#include "core/memory/memory_budget.h"

namespace alabaster {

/// Takes the next block. False: it cannot be kept, and no more is wanted.
using BlockSink = std::function<bool(std::span<const std::byte>)>;
/// Gives the next block, of at most so many bytes. False: none is left, or it is damaged or larger.
using BlockSource = std::function<bool(size_t most, std::vector<std::byte>*)>;

struct RenderState {
  std::shared_ptr<Film> film;
  /// The decisions where samples go and when the frame ends, where settings ask for that: the samples per pixel between
  /// the last decision and the next, and what has been decided. A round from 0 has seen no decision.
  SampleRange round;
  SampleAllocation allocation;
  GroupStopping stopping;
  // So far:
  RenderCounters counters;
  double wall_seconds = 0, cpu_seconds = 0;
};

/// Writes a block for the head, one for the rates if there are any, and one for each tile, with its ids in another
/// where AOVs count them, as each is at its turn. False: the sink did not take them.
bool write_state(const RenderState& state, const BlockSink& sink);

/// Reads it. False, whatever the bytes are, if they are not such a state. Throws MemoryRefused if its films take more
/// than `memory` has left. They are not counted: the render that takes the state does that.
bool read_state(const BlockSource& source, const MemoryBudget& memory, RenderState* state);

/// Appends the next part of the same frame's samples, which are those of `to` and then its own. One of its tiles is in
/// memory at a time. False, with `to` spoilt, if the blocks are not such a state.
bool append_state(const BlockSource& source, RenderState* to);

}  // namespace alabaster
