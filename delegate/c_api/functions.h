// The functions of the table, by the names of its members. Internal to this room.
#pragma once

#include "delegate/c_api/alabaster.h"

namespace alabaster::hd::c_api {

// Scenes
AlabasterStatus scene_create(AlabasterReport report, void* user, AlabasterScene** scene);
void scene_destroy(AlabasterScene* scene);
AlabasterStatus scene_load(AlabasterScene* scene, const char* file, const AlabasterLoadOptions* options,
                           AlabasterLoaded* loaded);
AlabasterStatus scene_write(AlabasterScene* scene, const char* file, const AlabasterFrame* frame,
                            const AlabasterParameter* settings, size_t count);
AlabasterStatus scene_clear(AlabasterScene* scene);
AlabasterStatus remove_prim(AlabasterScene* scene, const char* path);
AlabasterStatus scene_set(AlabasterScene* scene, const char* path, const char* kind, const AlabasterParameter* fields,
                          size_t count);
AlabasterStatus scene_edit(AlabasterScene* scene, const char* path, const AlabasterParameter* fields, size_t count);
AlabasterStatus scene_set_instances(AlabasterScene* scene, const char* instancer, const char* primvar, size_t first,
                                    const AlabasterValue* values);
AlabasterStatus get_prims(AlabasterScene* scene, AlabasterVisit visit, void* user);

// Delegates
AlabasterStatus delegate_create(const AlabasterDelegateOptions* options, AlabasterScene* scene,
                                AlabasterDelegate** delegate);
void delegate_destroy(AlabasterDelegate* delegate);
AlabasterStatus show(AlabasterDelegate* delegate, AlabasterScene* scene);
AlabasterStatus set_setting(AlabasterDelegate* delegate, const char* key, const AlabasterValue* value);
AlabasterStatus get_setting(AlabasterDelegate* delegate, const char* key, AlabasterVisit visit, void* user);
AlabasterStatus get_settings(AlabasterDelegate* delegate, AlabasterVisitSetting visit, void* user);
AlabasterStatus aov_format(AlabasterDelegate* delegate, const char* aov, int32_t* format);
AlabasterStatus stats(AlabasterDelegate* delegate, AlabasterVisit visit, void* user);
AlabasterStatus command(AlabasterDelegate* delegate, const char* name, const AlabasterParameter* arguments,
                        size_t count, AlabasterVisit visit, void* user);
AlabasterStatus stop(AlabasterDelegate* delegate);
AlabasterStatus restart(AlabasterDelegate* delegate);
AlabasterStatus pause(AlabasterDelegate* delegate);
AlabasterStatus resume(AlabasterDelegate* delegate);
AlabasterStatus record(AlabasterDelegate* delegate, const AlabasterRecordOptions* options, AlabasterVisit visit,
                       void* user);

// Passes and buffers
AlabasterStatus pass_create(AlabasterDelegate* delegate, AlabasterPass** pass);
void pass_destroy(AlabasterPass* pass);
AlabasterStatus pass_start(AlabasterPass* pass, const AlabasterFrame* frame);
AlabasterStatus pass_wait(AlabasterPass* pass, double seconds, int32_t* over);
AlabasterStatus pass_state(AlabasterPass* pass, int32_t* state);
AlabasterStatus progress(AlabasterDelegate* delegate, AlabasterProgress* progress);
AlabasterStatus frame_size(AlabasterDelegate* delegate, const AlabasterFrame* frame, int32_t* width, int32_t* height);
AlabasterStatus buffer_create(AlabasterDelegate* delegate, int32_t width, int32_t height, int32_t format,
                              AlabasterBuffer** buffer);
void buffer_destroy(AlabasterBuffer* buffer);
AlabasterStatus buffer_resize(AlabasterBuffer* buffer, int32_t width, int32_t height, int32_t format);
AlabasterStatus buffer_map(AlabasterBuffer* buffer, AlabasterPixels* pixels);
AlabasterStatus pixels_unmap(AlabasterPixels* pixels);
AlabasterStatus buffer_read(AlabasterBuffer* buffer, void* memory, size_t bytes, int32_t y_down);
AlabasterStatus display_create(const AlabasterDisplayOptions* options, AlabasterDisplay** display);
void display_destroy(AlabasterDisplay* display);
AlabasterStatus display_set_exposure(AlabasterDisplay* display, double stops);
AlabasterStatus buffer_show(AlabasterBuffer* buffer, AlabasterMemory* memory);
AlabasterStatus pick(AlabasterPass* pass, const AlabasterRect* rect, AlabasterVisitPick visit, void* user);
AlabasterStatus snapshot(AlabasterPass* pass, const char* file);

}  // namespace alabaster::hd::c_api
