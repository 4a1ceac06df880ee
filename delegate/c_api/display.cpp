// Pixels in the caller's memory, as a screen shows them.
#include <limits>

#include "delegate/c_api/handles.h"
#include "delegate/host/display_transform.h"
#include "delegate/support/size_text.h"

struct AlabasterDisplay final : alabaster::hd::c_api::Handle {
  explicit AlabasterDisplay(std::unique_ptr<alabaster::hd::host::DisplayTransform> made) : transform(std::move(made)) {}
  std::unique_ptr<alabaster::hd::host::DisplayTransform> transform;
};

namespace alabaster::hd::c_api {
namespace {

AlabasterStatus display_create(const AlabasterDisplayOptions* options, AlabasterDisplay** out) {
  return guarded([&] {
    const auto in = sized(options, "options");
    auto& made = required(out, "display");
    RenderProduct product;
    product.display = text_or(in.display, ""), product.view = text_or(in.view, "");
    product.look = text_or(in.look, ""), product.exposure = float(in.exposure);
    const auto reports = std::make_shared<Reports>(nullptr, nullptr);
    auto transform = host::DisplayTransform::Create(product, {text_or(in.color_config, "")}, sink_of(reports));
    if (!transform) throw bad_argument(reports->take_error("the display cannot be made"));
    made = new AlabasterDisplay{std::move(transform)};
  });
}

AlabasterStatus display_set_exposure(AlabasterDisplay* display, double stops) {
  return guarded([&] {
    if (!required(display, "display").transform->SetExposure(float(stops)))
      throw bad_argument("exposure must be a number of stops between -126 and 127");
  });
}

AlabasterStatus buffer_show(AlabasterBuffer* handle, AlabasterMemory* out) {
  return with_data(handle, "buffer", [&](BufferData& data) {
    data.owner->process.check("the buffer");
    RenderBuffer& buffer = *data.buffer;
    AlabasterMemory in = sized(out, "memory");
    if (in.format <= ALABASTER_FORMAT_NONE || in.format > ALABASTER_INT32)
      throw bad_argument("there is no format " + std::to_string(in.format));
    PixelMemory memory{in.pixels, in.row_bytes, {in.width, in.height}, Format(in.format), in.y_up == 0,
                       nullptr,   in.shown};
    if (in.height > 0 && in.row_bytes > std::numeric_limits<size_t>::max() / size_t(in.height))
      throw bad_argument("row_bytes times height is more than memory can hold");
    if (in.display) memory.transform = in.display->transform.get();
    const bool shown = buffer.ResolveTo(&memory);
    const bool differs = memory.size != Vec2i(in.width, in.height);
    in.width = memory.size.x, in.height = memory.size.y, in.shown = memory.shown;
    answer(out, in, "memory");
    if (differs)
      throw Failure(ALABASTER_NOT_FOUND, "the buffer has " + support::size_text(in.width, in.height) + " pixels");
    if (shown) return;
    if (!in.pixels || in.row_bytes < size_t(in.width) * FormatSize(memory.format))
      throw bad_argument("the memory is null, or row_bytes is less than a row takes");
    throw Failure(ALABASTER_OUT_OF_MEMORY, "the pixels could not be resolved");
  });
}

}  // namespace

void add_display_functions(AlabasterApi* api) {
  api->display_create = display_create;
  api->display_destroy = destroy_handle;
  api->display_set_exposure = display_set_exposure;
  api->buffer_show = buffer_show;
}

}  // namespace alabaster::hd::c_api
