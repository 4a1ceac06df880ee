// Checkpoints with changed contents. Without right checksums every change would be found at once, and nothing behind
// them would be tried: they are made right after the change.
#include <fstream>
#include <iterator>

#include "core/digest/digest.h"
#include "testenv/fuzz/small_render.h"
#include "testenv/fuzz/structured_input.h"

namespace alabaster::fuzz {
namespace {

constexpr size_t kMagicBytes = 23, kHeadBytes = 16;  // delegate/rendering/checkpoint_file.h

using File = std::vector<uint8_t>;

void describe(hd::host::RetainedSceneDelegate* scene) {
  add_stage(scene);
  add_cube(scene, {});
}

File written_checkpoint() {
  hd::host::RetainedSceneDelegate scene;
  describe(&scene);
  SmallRender render;
  render.options.checkpoint = scratch_folder() + "/whole.checkpoint";
  if (render_small(&scene, render).status != hd::host::RecordStatus::done) broken("no checkpoint was written");
  std::ifstream stream(render.options.checkpoint, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

void edit(StructuredInput& in, File* file) {
  for (int left = 1 + in.choice(8); left > 0 && !in.empty(); --left) {
    const size_t at = in.raw<uint16_t>() % file->size();
    switch (in.choice(4)) {
      case 0:
        (*file)[at] = in.byte();
        break;
      case 1: {
        const auto number = in.raw<uint64_t>();
        if (at + sizeof number <= file->size()) std::memcpy(file->data() + at, &number, sizeof number);
        break;
      }
      case 2: {
        const float number = in.number();
        if (at + sizeof number <= file->size()) std::memcpy(file->data() + at, &number, sizeof number);
        break;
      }
      default:
        if (in.choice(8) == 0) file->resize(at + 1);
    }
  }
}

void make_checksums_right(File* file) {
  uint64_t number = 0;
  for (size_t at = kMagicBytes; at + kHeadBytes <= file->size();) {
    uint64_t size = 0;
    std::memcpy(&size, file->data() + at, sizeof size);
    const size_t begin = at + kHeadBytes;
    if (size > file->size() - begin) return;
    const uint64_t sum = checksum(std::as_bytes(std::span(*file).subspan(begin, size)), number++);
    std::memcpy(file->data() + at + sizeof size, &sum, sizeof sum);
    at = begin + size;
  }
}

}  // namespace

void run_checkpoint(Bytes input) {
  static const File kWhole = written_checkpoint();
  StructuredInput in(input);
  File file = kWhole;
  edit(in, &file);
  if (in.choice(8) != 7) make_checksums_right(&file);
  hd::host::RetainedSceneDelegate scene;
  describe(&scene);
  SmallRender render;
  render.options.checkpoint = scratch_file("fuzzed.checkpoint", file);
  render.options.resume = true;
  render.counts_are_ours = false;
  render_small(&scene, render);
}

}  // namespace alabaster::fuzz
