#include "delegate/c_api/functions.h"
#include "delegate/c_api/handles.h"

using namespace alabaster::hd;

// The numbers that cross the interface are those of the contract.
static_assert(int(Format::unorm8) == ALABASTER_UNORM8 && int(Format::float16) == ALABASTER_HALF &&
              int(Format::float32) == ALABASTER_FLOAT32 && int(Format::float32vec4) == ALABASTER_FLOAT32_4 &&
              int(Format::int32) == ALABASTER_INT32);
static_assert(int(PassState::idle) == ALABASTER_IDLE && int(PassState::stopped) == ALABASTER_STOPPED &&
              int(PassState::failed) == ALABASTER_FAILED);
static_assert(int(WindowPolicy::matchVertically) == ALABASTER_MATCH_VERTICALLY &&
              int(WindowPolicy::dontConform) == ALABASTER_DONT_CONFORM);
static_assert(int(Severity::info) == ALABASTER_INFO && int(Severity::error) == ALABASTER_ERROR);

extern "C" const AlabasterApi* alabaster_api(uint32_t version) {
  static const AlabasterApi api = {sizeof(AlabasterApi),
                                   ALABASTER_API_VERSION,
                                   AlabasterVersions(),
                                   c_api::last_error,
                                   c_api::scene_create,
                                   c_api::scene_destroy,
                                   c_api::scene_load,
                                   c_api::scene_clear,
                                   c_api::remove_prim,
                                   c_api::scene_set,
                                   c_api::scene_edit,
                                   c_api::scene_set_instances,
                                   c_api::get_prims,
                                   c_api::delegate_create,
                                   c_api::delegate_destroy,
                                   c_api::show,
                                   c_api::set_setting,
                                   c_api::get_setting,
                                   c_api::get_settings,
                                   c_api::aov_format,
                                   c_api::stats,
                                   c_api::command,
                                   c_api::stop,
                                   c_api::restart,
                                   c_api::pause,
                                   c_api::resume,
                                   c_api::record,
                                   c_api::pass_create,
                                   c_api::pass_destroy,
                                   c_api::pass_start,
                                   c_api::pass_wait,
                                   c_api::pass_state,
                                   c_api::progress,
                                   c_api::frame_size,
                                   c_api::buffer_create,
                                   c_api::buffer_destroy,
                                   c_api::buffer_resize,
                                   c_api::buffer_map,
                                   c_api::pixels_unmap,
                                   c_api::buffer_read,
                                   c_api::display_create,
                                   c_api::display_destroy,
                                   c_api::display_set_exposure,
                                   c_api::buffer_show,
                                   c_api::pick,
                                   c_api::snapshot,
                                   c_api::scene_write};
  return version == ALABASTER_API_VERSION ? &api : nullptr;
}
