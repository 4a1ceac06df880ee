/* Measures what it costs a host to load a library: prints "key value" lines for one dlopen and dlclose in a fresh
   process. load_probe LIBRARY [SCENE] With SCENE it also renders a small picture of it before dlclose. "libraries" and
   "bytes" are those that dlopen mapped beyond glibc's own; "kept" are those that dlclose left mapped. */
#define _GNU_SOURCE
#include <alabaster/alabaster.h>
#include <dirent.h>
#include <dlfcn.h>
#include <link.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

enum { MAX_OBJECTS = 1024 };
struct object {
  char name[256];
  size_t bytes;
};
struct objects {
  struct object list[MAX_OBJECTS];
  int count;
};
static struct objects before, loaded, rendering, after;

static int add_object(struct dl_phdr_info* info, size_t size, void* data) {
  struct objects* all = data;
  struct object* object = &all->list[all->count];
  size_t i;
  (void)size;
  if (all->count == MAX_OBJECTS) return 1;
  snprintf(object->name, sizeof object->name, "%s", info->dlpi_name);
  object->bytes = 0;
  for (i = 0; i < info->dlpi_phnum; ++i)
    if (info->dlpi_phdr[i].p_type == PT_LOAD) object->bytes += info->dlpi_phdr[i].p_memsz;
  ++all->count;
  return 0;
}

static int has(const struct objects* all, const char* name) {
  int i;
  for (i = 0; i < all->count; ++i)
    if (strcmp(all->list[i].name, name) == 0) return 1;
  return 0;
}

static int is_glibc(const char* path) {
  static const char* const names[] = {"libc.so", "libm.so", "libdl.so", "libpthread.so", "librt.so", "ld-linux"};
  const char* name = strrchr(path, '/') ? strrchr(path, '/') + 1 : path;
  size_t i;
  for (i = 0; i < sizeof names / sizeof *names; ++i)
    if (strncmp(name, names[i], strlen(names[i])) == 0) return 1;
  return 0;
}

static int threads(void) {
  int count = 0;
  const struct dirent* entry;
  DIR* folder = opendir("/proc/self/task");
  if (!folder) return -1;
  while ((entry = readdir(folder))) count += entry->d_name[0] != '.';
  closedir(folder);
  return count;
}

static double milliseconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

/* 0 if everything went well. */
static int render(const AlabasterApi* api, const char* file) {
  int i;
  AlabasterScene* scene = NULL;
  AlabasterDelegate* delegate = NULL;
  AlabasterPass* pass = NULL;
  AlabasterBuffer* color = NULL;
  AlabasterBinding binding = {.aov = "color"};
  AlabasterFrame frame = {.size = sizeof frame};
  int failed = api->scene_create(NULL, NULL, &scene) || api->scene_load(scene, file, NULL, NULL) ||
               api->delegate_create(NULL, scene, &delegate) ||
               api->buffer_create(delegate, 48, 32, ALABASTER_FLOAT32_4, &color) || api->pass_create(delegate, &pass);
  if (!failed) {
    binding.buffer = color;
    frame.bindings = &binding;
    frame.binding_count = 1;
    frame.width = 48;
    frame.height = 32;
    failed = api->pass_start(pass, &frame) || api->pass_wait(pass, -1, NULL);
  }
  if (failed) fprintf(stderr, "%s\n", api->last_error());
  dl_iterate_phdr(add_object, &rendering);
  for (i = 0; i < rendering.count; ++i)
    if (!has(&loaded, rendering.list[i].name)) printf("opens %s\n", rendering.list[i].name);
  api->pass_destroy(pass);
  api->buffer_destroy(color);
  api->delegate_destroy(delegate);
  api->scene_destroy(scene);
  return failed;
}

int main(int argc, char** argv) {
  double start;
  void* library;
  size_t bytes = 0;
  int i, libraries = 0, kept = 0;
  if (argc < 2) return 2;
  dl_iterate_phdr(add_object, &before);
  start = milliseconds();
  library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
  if (!library) {
    fprintf(stderr, "%s\n", dlerror());
    return 1;
  }
  printf("milliseconds %.2f\n", milliseconds() - start);
  dl_iterate_phdr(add_object, &loaded);
  for (i = 0; i < loaded.count; ++i) {
    const struct object* object = &loaded.list[i];
    if (has(&before, object->name) || is_glibc(object->name)) continue;
    printf("maps %s\n", object->name);
    ++libraries;
    bytes += object->bytes;
  }
  printf("libraries %d\nbytes %zu\nthreads %d\n", libraries, bytes, threads() - 1);
  if (argc > 2) {
    const AlabasterApi* (*entry)(uint32_t);
    *(void**)&entry = dlsym(library, "alabaster_api");
    if (!entry || !entry(ALABASTER_API_VERSION) || render(entry(ALABASTER_API_VERSION), argv[2])) return 1;
  }
  dlclose(library);
  dl_iterate_phdr(add_object, &after);
  for (i = 0; i < after.count; ++i) {
    if (has(&before, after.list[i].name) || is_glibc(after.list[i].name)) continue;
    printf("keeps %s\n", after.list[i].name);
    ++kept;
  }
  printf("kept %d\nthreads_left %d\n", kept, threads() - 1);
  return 0;
}
