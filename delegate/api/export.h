#pragma once

#if defined(ALABASTER_BUILDING_LIBRARY)
#define ALABASTER_API __attribute__((visibility("default")))
#else
#define ALABASTER_API
#endif
