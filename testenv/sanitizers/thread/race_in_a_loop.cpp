// A race inside a parallel loop. The thread sanitizer must report it: where reports do not name inlined functions, the
// body of a loop goes by the name of the tbb function that it was inlined into, which the suppressions name.
#include <tbb/parallel_for.h>

#include <cstdio>

int main() {
  long sum = 0;
  for (int i = 0; i < 20; ++i) tbb::parallel_for(0, 100000, [&](int k) { sum += k; });
  std::printf("%ld\n", sum);
}
