/* A host in C99: loads a scene, renders it into its own memory, edits it, and writes what it saw as a PFM file.
     host SCENE OUT.pfm
   The pixels before the edit are those that the program renders; test_install.sh compares them. */
#include <alabaster/alabaster.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 48, HEIGHT = 32 };
static const AlabasterApi* api;
static int released;

static void check(AlabasterStatus status, const char* what) {
  if (status == ALABASTER_OK) return;
  fprintf(stderr, "%s: %s\n", what, api->last_error());
  exit(1);
}

static void demand(int good, const char* what) {
  if (good) return;
  fprintf(stderr, "error: %s\n", what);
  exit(1);
}

static void report(void* user, const AlabasterDiagnostic* diagnostic) {
  (void)user;
  fprintf(stderr, "%s: %s\n", diagnostic->where, diagnostic->text);
}

static void release(void* owner) {
  free(owner);
  ++released;
}

static AlabasterValue array(int32_t type, const void* data, size_t count) {
  AlabasterValue value = {0};
  value.type = type;
  value.is_array = ALABASTER_ARRAY;
  value.data = data;
  value.count = count;
  return value;
}

/* A quad whose points are lent: the library reads them where they lie, and gives them back. */
static void add_quad(AlabasterScene* scene) {
  static const int32_t counts[] = {4}, indices[] = {0, 1, 2, 3};
  static const float corners[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  static const uint8_t off = 0;
  AlabasterParameter fields[3] = {
      {.name = "faceVertexCounts"}, {.name = "faceVertexIndices"}, {.name = "primvars:points"}};
  AlabasterParameter hidden = {.name = "visible"}, misspelt = {.name = "visble"};
  float* points = malloc(sizeof corners);
  memcpy(points, corners, sizeof corners);
  fields[0].value = array(ALABASTER_INT, counts, 1);
  fields[1].value = array(ALABASTER_INT, indices, 4);
  fields[2].value = array(ALABASTER_FLOAT3, points, 4);
  fields[2].value.release = release;
  fields[2].value.owner = points;
  check(api->scene_set(scene, "/quad", "mesh", fields, 3), "scene_set");
  hidden.value.type = misspelt.value.type = ALABASTER_BOOL;
  hidden.value.data = misspelt.value.data = &off;
  hidden.value.count = misspelt.value.count = 1;
  demand(api->scene_edit(scene, "/quad", &misspelt, 1) == ALABASTER_INVALID_ARGUMENT, "an unknown field was set");
  demand(strstr(api->last_error(), "did you mean 'visible'") != NULL, "the error does not name the nearest field");
  check(api->scene_edit(scene, "/quad", &hidden, 1), "scene_edit");
  hidden.value.type = ALABASTER_NONE; /* the default: visible */
  check(api->scene_edit(scene, "/quad", &hidden, 1), "scene_edit");
}

static void render(AlabasterPass* pass, AlabasterBuffer* color, float* pixels) {
  AlabasterBinding binding = {.aov = "color"};
  AlabasterFrame frame = {.size = sizeof frame};
  int32_t over = 0;
  binding.buffer = color;
  frame.bindings = &binding;
  frame.binding_count = 1;
  check(api->pass_start(pass, &frame), "pass_start");
  while (!over) check(api->pass_wait(pass, 0.1, &over), "pass_wait");
  check(api->buffer_read(color, pixels, sizeof(float) * 4 * WIDTH * HEIGHT, 0), "buffer_read");
}

static void write_pfm(const char* file, const float* rgba) {
  int i;
  FILE* out = fopen(file, "wb");
  demand(out != NULL, "the output cannot be written");
  fprintf(out, "PF\n%d %d\n-1.0\n", WIDTH, HEIGHT);
  for (i = 0; i < WIDTH * HEIGHT; ++i) fwrite(rgba + 4 * i, sizeof(float), 3, out);
  fclose(out);
}

int main(int argc, char** argv) {
  static float before[4 * WIDTH * HEIGHT], after[4 * WIDTH * HEIGHT];
  AlabasterDelegateOptions options = {.size = sizeof options};
  AlabasterScene* scene = NULL;
  AlabasterDelegate* delegate = NULL;
  AlabasterPass* pass = NULL;
  AlabasterBuffer* color = NULL;
  demand(argc == 3, "host SCENE OUT.pfm");
  demand(alabaster_api(ALABASTER_API_VERSION + 1) == NULL, "a later version than the library's was promised");
  api = alabaster_api(ALABASTER_API_VERSION);
  demand(api && api->size >= sizeof *api, "the library is older than its header");

  check(api->scene_create(NULL, NULL, &scene), "scene_create");
  demand(api->scene_load(scene, "missing.json", NULL, NULL) == ALABASTER_INPUT_FAILED, "a missing scene was loaded");
  demand(strstr(api->last_error(), "missing.json") != NULL, "the error does not name the file");
  check(api->scene_load(scene, argv[1], NULL, NULL), "scene_load");

  options.report = report;
  check(api->delegate_create(&options, scene, &delegate), "delegate_create");
  check(api->buffer_create(delegate, WIDTH, HEIGHT, ALABASTER_FLOAT32_4, &color), "buffer_create");
  check(api->pass_create(delegate, &pass), "pass_create");
  render(pass, color, before);
  write_pfm(argv[2], before);

  add_quad(scene);
  render(pass, color, after);
  demand(memcmp(before, after, sizeof before) != 0, "the new mesh is not in the picture");
  check(api->remove(scene, "/quad"), "remove");
  render(pass, color, after);
  demand(memcmp(before, after, sizeof before) == 0, "the mesh that was removed left traces");

  /* In an order that would be wrong if handles did not keep what they need. */
  api->scene_destroy(scene);
  api->delegate_destroy(delegate);
  api->buffer_destroy(color);
  api->pass_destroy(pass);
  demand(released == 1, "the points that were lent were not given back once");
  printf("C99 host: rendered\n");
  return 0;
}
