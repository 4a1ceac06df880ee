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
  static const AlabasterApi api = [] {
    AlabasterApi made{};
    made.size = sizeof made;
    made.version = ALABASTER_API_VERSION;
    made.versions = AlabasterVersions();
    made.last_error = c_api::last_error;
    c_api::add_scene_functions(&made);
    c_api::add_delegate_functions(&made);
    c_api::add_pass_functions(&made);
    c_api::add_display_functions(&made);
    return made;
  }();
  return version == ALABASTER_API_VERSION ? &api : nullptr;
}
