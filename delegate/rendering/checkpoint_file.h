// Files of checkpoints. A file is the line kMagic and then blocks, each with its size and its checksum: a header in
// JSON, which says what render the state is of, the blocks of write_state() and an empty one. Numbers are little
// endian.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/files/input_file.h"
#include "core/memory/memory_budget.h"
#include "core/session/render_request.h"
#include "core/session/render_state.h"
#include "delegate/prims/id_names.h"

namespace alabaster::hd::rendering {

/// All that a render's pixels depend on. Its members, with text for a value each:
/// - library {line: version}: the renderer, its sampling, and the libraries that it stands on
/// - scene {kind and path: digest}: digest_scene()
/// - camera {name: value}, frame {name: value}, aovs text
/// - settings {name: value}: those that change pixels; where samples decide where others go, their number, too
/// - names {"primId 3" and the like: name}, where AOVs show ids
/// Besides, which a render may differ in: samples [first, end], complete flag, note text.
using CheckpointHeader = nlohmann::json;

/// A longer note is neither written nor read.
inline constexpr size_t kMostNoteBytes = size_t(64) << 10;

/// The header of a request. `scene`: digest_scene() of what request.scene was compiled from. `names`: null where no AOV
/// shows ids.
CheckpointHeader checkpoint_header(const RenderRequest& request, const std::map<std::string, std::string>& scene,
                                   const prims::IdNames* names);
/// Those of a header, which may say anything.
prims::IdNames names_of(const CheckpointHeader& header);

/// Names what differs between the render of a file and another, in words for people; empty if nothing does.
std::string checkpoint_difference(const CheckpointHeader& file, const CheckpointHeader& render);

/// Writes a file of which nobody sees a part. `write`: write_state() of the state. Returns nothing on success, else the
/// reason; the file is then as it was before.
std::string write_checkpoint(const std::string& file, const CheckpointHeader& header,
                             const std::function<bool(const BlockSink&)>& write);

/// Reads a regular file, whatever it holds: nothing of it is trusted.
class CheckpointReader {
 public:
  /// Reads the header, which `memory` holds as long as the reader (MemoryRefused). fault() says why the file cannot be
  /// read, and is empty if it can.
  CheckpointReader(const std::string& file, const std::shared_ptr<MemoryBudget>& memory);
  const CheckpointHeader& header() const { return header_; }
  const std::string& fault() const { return fault_; }
  /// The reservation of the header, to keep with a copy of it.
  MemoryReservation take_memory() { return std::move(held_); }
  /// The next block, for read_state().
  BlockSource source();
  /// After the last block: notes a fault unless the file ends here. `read`: the answer of read_state().
  void finish(bool read);

 private:
  bool next(size_t most, std::vector<std::byte>* block);
  bool fail(const std::string& fault);
  bool read_header();
  bool take(void* out, size_t size);

  InputFile file_;
  MemoryReservation held_;
  size_t left_ = 0;
  uint64_t number_ = 0;  // of the next block
  CheckpointHeader header_;
  std::string fault_;
};

}  // namespace alabaster::hd::rendering
