#include "delegate/rendering/pixel_memory.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "core/math/float_environment.h"
#include "delegate/rendering/pixel_format.h"

namespace alabaster::hd::rendering {
namespace {

void show_row(const uint8_t* from, Format format, size_t count, const PixelMemory& memory, uint8_t* to) {
  if (format == memory.format && !memory.transform) {
    std::memcpy(to, from, count * FormatSize(format));
    return;
  }
  constexpr size_t kAtOnce = 256;
  std::array<float, 4 * kAtOnce> values;
  while (count > 0) {
    const std::span<float> rgba(values.data(), 4 * std::min(count, kAtOnce));
    read_pixels(from, format, rgba);
    if (memory.transform) memory.transform->Apply(rgba);
    write_pixels(rgba, 4, memory.format, to);
    const size_t written = rgba.size() / 4;
    from += written * FormatSize(format), to += written * FormatSize(memory.format), count -= written;
  }
}

void show_rect(const BufferStore& picture, const PixelRect& rect, const PixelMemory& memory) {
  if (rect.x0 >= rect.x1) return;
  const RenderBufferDescriptor& description = picture.description();
  for (int y = rect.y0; y < rect.y1; ++y) {
    const auto row = static_cast<size_t>(memory.yDown ? y : description.dimensions.y - 1 - y);
    uint8_t* const to = static_cast<uint8_t*>(memory.pixels) + row * memory.rowBytes +
                        static_cast<size_t>(rect.x0) * FormatSize(memory.format);
    show_row(picture.pixels().data() + picture.offset(rect.x0, y), description.format,
             static_cast<size_t>(rect.x1 - rect.x0), memory, to);
  }
}

}  // namespace

std::string memory_fault(const PixelMemory& memory, const Vec2i& size) {
  if (FormatComponents(memory.format) == 0) return "the format is invalid";
  if (size.x == 0 || size.y == 0) return {};
  if (!memory.pixels) return "the memory is null";
  if (memory.rowBytes < static_cast<size_t>(size.x) * FormatSize(memory.format))
    return "rowBytes is less than a row of " + std::to_string(size.x) + " pixels takes";
  return {};
}

void show(const BufferStore& picture, PixelMemory* memory) {
  const std::vector<PixelRect> changes = picture.changes_since(memory->shown);
  // Isolated: a thread that waits takes up no work of the host.
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(size_t(0), changes.size(), [&](size_t i) {
      const FloatEnvironment environment;
      show_rect(picture, changes[i], *memory);
    });
  });
  memory->shown = picture.number();
}

}  // namespace alabaster::hd::rendering
