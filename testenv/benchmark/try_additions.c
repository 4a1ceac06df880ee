/* Tries the additions of four_additions.py through the C interface, for try_additions.py. Each line of the output is an addition, a step
   and what arrived or was answered, with tabs between them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "delegate/c_api/alabaster.h"

enum { SIDE = 8 };
static const AlabasterApi* api;
static const float in_range = 0.25f, out_of_range = 2;
static const float color_in_range[] = {0.25f, 0.5f, 0.75f}, color_out_of_range[] = {2, 0, 0};

static void check(AlabasterStatus status) {
  if (status == ALABASTER_OK) return;
  fprintf(stderr, "%s\n", api->last_error());
  exit(1);
}

static void tell(const char* addition, const char* step, const char* answer) {
  printf("%s\t%s\t%s\n", addition, step, answer);
}
static void tell_number(const char* addition, float number) {
  char text[32];
  snprintf(text, sizeof text, "%g", (double)number);
  tell(addition, "arrives", text);
}
static void tell_refusal(const char* addition, const char* step, AlabasterStatus status) {
  tell(addition, step, status == ALABASTER_OK ? "accepted" : api->last_error());
}

/* A warning of the renderer begins with the name of the parameter. */
static void report(void* user, const AlabasterDiagnostic* diagnostic) {
  char name[64] = "";
  (void)user;
  sscanf(diagnostic->text, "%63s", name);
  tell(name, "range", diagnostic->text);
}

static void tell_setting(void* user, const char* name, const AlabasterValue* value) {
  (void)user;
  tell_number(name, *(const float*)value->data);
}

/* Lines of the dump: "  trialOption (0.25, 0.5, 0.75)". */
static void tell_lines(void* user, const char* name, const AlabasterValue* value) {
  const char* line = value->data;
  (void)user;
  (void)name;
  while ((line = strstr(line, "\n  trial")) != NULL) {
    char key[64] = "", text[64] = "";
    if (sscanf(line, " %63s %63[^\n]", key, text) == 2) tell(key, "arrives", text);
    ++line;
  }
}

static AlabasterParameter field(const char* name, int32_t type, const void* data) {
  AlabasterParameter made = {.name = name};
  made.value.type = type;
  made.value.data = data;
  made.value.count = 1;
  return made;
}
static AlabasterStatus edit(AlabasterScene* scene, const char* path, const char* name, int32_t type, const void* data) {
  const AlabasterParameter made = field(name, type, data);
  return api->scene_edit(scene, path, &made, 1);
}

static void fill(AlabasterScene* scene) {
  static const int32_t counts[] = {4}, indices[] = {0, 1, 2, 3};
  static const float corners[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  static const double back[] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 4, 1};
  const AlabasterParameter transform = field("transform", ALABASTER_MATRIX, back);
  AlabasterParameter shape[] = {field("faceVertexCounts", ALABASTER_INT, counts),
                                field("faceVertexIndices", ALABASTER_INT, indices),
                                field("primvars:points", ALABASTER_FLOAT3, corners)};
  for (int i = 0; i < 3; ++i) shape[i].value.is_array = ALABASTER_ARRAY;
  shape[1].value.count = shape[2].value.count = 4;
  check(api->scene_set(scene, "/square", "mesh", shape, 3));
  check(api->scene_set(scene, "/lamp", "sphereLight", &transform, 1));
  check(api->scene_set(scene, "/camera", "camera", &transform, 1));
}

/* The AOV in the first pixel. */
static float draw(AlabasterPass* pass, AlabasterBuffer* buffer) {
  static float pixels[SIDE * SIDE];
  AlabasterBinding binding = {.aov = "trialAov"};
  AlabasterFrame frame = {.size = sizeof frame};
  int32_t over = 0;
  binding.buffer = buffer;
  frame.bindings = &binding;
  frame.binding_count = 1;
  frame.camera = "/camera";
  frame.width = frame.height = SIDE;
  check(api->pass_start(pass, &frame));
  check(api->pass_wait(pass, -1, &over));
  check(api->buffer_read(buffer, pixels, sizeof pixels, 0));
  return pixels[0];
}

static void try_setting(AlabasterDelegate* delegate) {
  AlabasterParameter setting = field("", ALABASTER_FLOAT, &in_range);
  check(api->set_setting(delegate, "trialSetting", &setting.value));
  check(api->get_setting(delegate, "trialSetting", tell_setting, NULL));
  tell_refusal("trialSetting", "misspelt", api->set_setting(delegate, "trialSeting", &setting.value));
  setting.value.data = &out_of_range;
  tell_refusal("trialSetting", "range", api->set_setting(delegate, "trialSetting", &setting.value));
}

int main(void) {
  AlabasterDelegateOptions options = {.size = sizeof options};
  AlabasterScene* scene = NULL;
  AlabasterDelegate* delegate = NULL;
  AlabasterPass* pass = NULL;
  AlabasterBuffer* buffer = NULL;
  int32_t format = 0;
  api = alabaster_api(ALABASTER_API_VERSION);
  check(api->scene_create(NULL, NULL, &scene));
  fill(scene);
  options.report = report;
  check(api->delegate_create(&options, scene, &delegate));
  check(api->pass_create(delegate, &pass));
  check(api->buffer_create(delegate, SIDE, SIDE, ALABASTER_FLOAT32, &buffer));
  try_setting(delegate);

  check(edit(scene, "/square", "trialOption", ALABASTER_FLOAT3, color_in_range));
  check(edit(scene, "/lamp", "trialParameter", ALABASTER_FLOAT, &in_range));
  tell_number("trialAov", draw(pass, buffer));
  check(api->command(delegate, "dumpScene", NULL, 0, tell_lines, NULL));
  check(edit(scene, "/square", "trialOption", ALABASTER_FLOAT3, color_out_of_range));
  check(edit(scene, "/lamp", "trialParameter", ALABASTER_FLOAT, &out_of_range));
  draw(pass, buffer);

  tell_refusal("trialOption", "misspelt", edit(scene, "/square", "trialOptoin", ALABASTER_FLOAT3, color_in_range));
  tell_refusal("trialParameter", "misspelt", edit(scene, "/lamp", "trialParametre", ALABASTER_FLOAT, &in_range));
  check(api->aov_format(delegate, "trialAvo", &format));
  tell("trialAov", "misspelt", format == ALABASTER_FORMAT_NONE ? api->last_error() : "accepted");
  api->buffer_destroy(buffer);
  api->pass_destroy(pass);
  api->delegate_destroy(delegate);
  api->scene_destroy(scene);
  return 0;
}
